"""What killed processes leave in shared memory: Fast DDS frees it only where a process ends itself.

A living process holds a lock on its segment (``flock`` on ``NAME_el``), from before the segment is
made until it ends, however it ends. Ports come after the segment, and are there for a moment before
they are locked: they can be told from abandoned ones only while no process has a segment.
"""

from __future__ import annotations

import fcntl
import os
import re
import time
from pathlib import Path

FOLDER = Path("/dev/shm")  # noqa: S108 - not a temporary file of ours
_YOUNG = 2.0  # s
_SEGMENT = re.compile(r"(fastrtps_[0-9a-f]{16})(_el)?")
_PORT = re.compile(r"(?:sem\.)?(fastrtps_port\d+)(?:_el|_sl|_mutex)?")


def abandoned(folder: Path = FOLDER) -> list[Path]:
    """Return the segments that no process holds, and the ports if none is held, by name."""
    ports = [] if _in_use(folder) else _all(folder, _PORT)
    return [path for path in _all(folder, _SEGMENT) if _is_free(path)] + ports


def remove_abandoned(folder: Path = FOLDER) -> list[Path]:
    """Remove the segments and ports that no process holds any more, and return them.

    Ports stay while any process on this machine uses shared memory: its end will remove them. What
    belongs to other users stays as well.
    """
    segments = [path for path in _all(folder, _SEGMENT) if _is_free(path) and _remove(path)]
    ports = [
        path for path in _all(folder, _PORT) if not _in_use(folder) and _remove(path)
    ]  # looked at again each time: a process may begin meanwhile
    return segments + ports


def _in_use(folder: Path) -> bool:
    """Return whether a process has a segment."""
    return not all(_is_free(path) for path in _all(folder, _SEGMENT))


def _all(folder: Path, kind: re.Pattern[str]) -> list[Path]:
    """Return segments or ports, also those of which only a lock or mutex is left."""
    try:
        found = [kind.fullmatch(path.name) for path in folder.iterdir()]
    except OSError:  # no such folder: not Linux
        return []
    return [folder / name for name in sorted({match[1] for match in found if match})]


def _is_free(segment: Path) -> bool:
    """Return whether no process holds a segment."""
    try:
        handle = os.open(segment.with_name(f"{segment.name}_el"), os.O_RDONLY)
    except FileNotFoundError:
        return True
    except OSError:
        return False  # another user's
    try:
        if not segment.exists() and time.time() - os.fstat(handle).st_mtime < _YOUNG:
            return False  # its process is about to lock it
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    finally:
        os.close(handle)
    return True


def _remove(path: Path) -> bool:
    """Remove a segment or port and all that belongs to it; return False for another user's."""
    names = (path.name, f"sem.{path.name}_mutex", f"{path.name}_sl", f"{path.name}_el")
    try:
        for name in names:
            path.with_name(name).unlink(missing_ok=True)
    except OSError:
        return False
    return True
