"""Stack files of a user's own, in a copy of the configuration."""

from __future__ import annotations

import shutil
from pathlib import Path

from support.scenario import CONFIG, SCENARIO

HEAD = "name: some\ndescription: d\n"
LEVELS = "levels:\n  - tasks:\n      - type: velocity_damping\n"


def folder(tmp_path: Path, **files: str) -> Path:
    """Return a scenario's file in a copy of the configuration, with more stacks or other text."""
    shutil.copytree(CONFIG, tmp_path / "config")
    for name, text in files.items():
        (tmp_path / "config" / "stacks" / f"{name}.yaml").write_text(text, encoding="utf-8")
    return tmp_path / "config" / "scenarios" / SCENARIO.name
