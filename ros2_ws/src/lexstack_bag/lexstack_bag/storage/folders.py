"""Folders for results: made where they are missing, and what to do where they cannot be written."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from lexstack.errors import ConfigurationError
from lexstack_bag.errors import BagError


def whose(out: Path) -> str:
    """Return whose the folder is in which ``out`` could not be made, and what to do, in a line."""
    there = next(folder for folder in (out, *out.parents) if folder.exists())
    return (
        f"{there} is user {there.stat().st_uid}'s, this process is user {os.geteuid()}'s; name a "
        "folder of your own (one that docker made is root's: mkdir it before docker run, and "
        'give --user "$(id -u):$(id -g)")'
    )


def empty_folder(out: Path) -> Path:
    """Return the folder of ``--out``, made; raises ConfigurationError where it holds something."""
    out = out.resolve()
    try:
        out.mkdir(parents=True, exist_ok=True)
        if any(out.iterdir()):
            raise ConfigurationError(f"--out: {out} is not empty; name another folder")
    except PermissionError as error:
        raise ConfigurationError(f"--out: {out}: {error.strerror}: {whose(out)}") from error
    except OSError as error:
        raise ConfigurationError(f"--out: {out}: {error.strerror}") from error
    return out


@contextmanager
def writing(path: Path, *, make: bool = False) -> Iterator[None]:
    """Turn what the disk refuses into a BagError; ``make``: make the folder first."""
    try:
        if make:
            path.mkdir(parents=True, exist_ok=True)
        yield
    except OSError as error:
        raise BagError(f"{path}: cannot be written: {error.strerror}") from error
