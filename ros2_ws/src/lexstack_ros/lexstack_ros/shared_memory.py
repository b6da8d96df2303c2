"""What killed processes leave in shared memory: Fast DDS frees it only where a process ends itself.

A living process holds a lock on each of its segments and ports (``flock`` on ``NAME_el`` or
``NAME_sl``), which ends with it, however it ends.
"""

from __future__ import annotations

import fcntl
import os
import re
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

FOLDER = Path("/dev/shm")  # noqa: S108 - not a temporary file of ours
_SEGMENT = re.compile(r"fastrtps_[0-9a-f]{16}")
_PORT = re.compile(r"fastrtps_port\d+")
_LOCKS = ("_el", "_sl")
_YOUNG = 2.0  # s, for which a port may be there before its process has locked it
FREE_AFTER = _YOUNG + 1.0
"""So long after its end [s of wall time] all that a process has left can be removed."""
_LOOK = 0.1  # s between two looks at it


def abandoned(folder: Path = FOLDER) -> list[Path]:
    """Return the segments and ports that no process holds, by name."""
    found = []
    for path in _all(folder):
        with _nobody_holding(path) as free:
            if free:
                found.append(path)
    return found


def remove_abandoned(folder: Path = FOLDER, patience: float = 0.0) -> list[Path]:
    """Remove the segments and ports that no process holds any more, and return them.

    What belongs to other users stays, and a port that was written to just now.

    Args:
        folder: where they are.
        patience: how long to wait for such ports [s].
    """
    end = time.monotonic() + patience
    removed: list[Path] = []
    while True:
        young = False
        for path in _all(folder):
            with _nobody_holding(path) as free:
                if free and _is_young_port(path):
                    young = True
                elif free and _remove(path):
                    removed.append(path)
        if not young or time.monotonic() >= end:
            return removed
        time.sleep(_LOOK)


def _all(folder: Path) -> list[Path]:
    """Return segments and ports, also those of which only a lock is left."""
    names = (path.name.removesuffix(_LOCKS[0]).removesuffix(_LOCKS[1]) for path in _files(folder))
    kinds = (_SEGMENT, _PORT)
    return [
        folder / name for name in sorted(set(names)) if any(kind.fullmatch(name) for kind in kinds)
    ]


def _files(folder: Path) -> list[Path]:
    """Return what is in a folder; nothing where there is none (not Linux)."""
    try:
        return list(folder.iterdir())
    except OSError:
        return []


@contextmanager
def _nobody_holding(path: Path) -> Iterator[bool]:
    """Yield whether nobody holds a segment or port; meanwhile nobody can take it."""
    with ExitStack() as locks:
        yield all(_lock(path.with_name(path.name + suffix), locks) for suffix in _LOCKS)


def _is_young_port(path: Path) -> bool:
    """Return whether it is a port that was written to just now, perhaps not locked yet.

    A segment is locked before it is made.
    """
    try:
        age = time.time() - path.stat().st_mtime
    except FileNotFoundError:
        return False
    return bool(_PORT.fullmatch(path.name)) and age < _YOUNG


def _lock(path: Path, locks: ExitStack) -> bool:
    """Lock a file until ``locks`` ends; return False where another process has it."""
    try:
        handle = os.open(path, os.O_RDONLY)
    except FileNotFoundError:
        return True
    except OSError:
        return False  # another user's
    locks.callback(os.close, handle)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True


def _remove(path: Path) -> bool:
    """Remove a segment or port and all that belongs to it; return False for another user's."""
    mutex = path.with_name(f"sem.{path.name}_mutex")
    try:
        for file in (path, mutex, *(path.with_name(path.name + suffix) for suffix in _LOCKS)):
            file.unlink(missing_ok=True)
    except OSError:
        return False
    return True
