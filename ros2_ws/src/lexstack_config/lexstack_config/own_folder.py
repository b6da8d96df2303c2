"""Where lexstack's own configuration lies: in a clone, or installed in share."""

from __future__ import annotations

import os
from pathlib import Path

PACKAGE = "lexstack_config"
_INDEX = Path("share/ament_index/resource_index/packages")


def own_root() -> Path:
    """Return the clone that LEXSTACK_ROOT names, or the present folder: runs are written there."""
    return Path(os.environ.get("LEXSTACK_ROOT", ".")).resolve()


def own_config() -> Path:
    """Return the folder with ``scenarios/``, ``stacks/`` and ``robots/``.

    It is that of the clone which LEXSTACK_ROOT names, always; else that of a clone which is the
    present folder; else the installed one, by the ament index.
    """
    clone = own_root() / "config"
    if "LEXSTACK_ROOT" in os.environ or (clone / "scenarios").is_dir():
        return clone
    return installed_config() or clone


def installed_config() -> Path | None:
    """Return the folder in the share of the first prefix that has this package, or None."""
    for prefix in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep):
        folder = Path(prefix) / "share" / PACKAGE / "config"
        if prefix and (Path(prefix) / _INDEX / PACKAGE).exists() and folder.is_dir():
            return folder
    return None
