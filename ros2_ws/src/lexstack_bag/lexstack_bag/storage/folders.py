"""Folders that cannot be written to: whose they are, and what to do."""

from __future__ import annotations

import os
from pathlib import Path


def whose(out: Path) -> str:
    """Return whose the folder is in which ``out`` could not be made, and what to do, in a line."""
    there = next(folder for folder in (out, *out.parents) if folder.exists())
    return (
        f"{there} is user {there.stat().st_uid}'s, this process is user {os.geteuid()}'s; name a "
        "folder of your own (one that docker made is root's: mkdir it before docker run, and "
        'give --user "$(id -u):$(id -g)")'
    )
