"""What a run must not leave on the machine: processes, and their shared memory."""

from __future__ import annotations

import time
from pathlib import Path

from lexstack_bringup.shared_memory import FOLDER, abandoned

_OURS = tuple(
    f"lexstack_{package}.".encode()
    for package in ("ros", "plant", "bringup", "testing", "sim", "bag", "experiments")
)
_PATIENCE = 10.0  # s, in which what is ending ends


def is_alive(pid: int) -> bool:
    """Return whether a process runs or is stopped; one that waits to be reaped is not (Linux).

    It keeps its id until its parent has looked, and where the first process of a container never
    looks, for good. A signal of number 0 reaches it all the same.
    """
    try:
        stat = Path(f"/proc/{pid}/stat").read_text(encoding="ascii", errors="replace")
    except OSError:
        return False
    state = stat.rpartition(")")[2].split()[0]  # behind the name, which may have brackets itself
    return state not in {"Z", "X", "x"}


def our_processes() -> dict[int, str]:
    """Return the command lines of lexstack's processes on this machine, by process id (Linux)."""
    found = {}
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            words = (folder / "cmdline").read_bytes().split(b"\0")
        except OSError:
            continue  # it has ended
        if any(word.startswith(_OURS) for word in words):
            found[int(folder.name)] = b" ".join(words).decode(errors="replace")
    return found


def what_is_left(before: dict[int, str], folder: Path = FOLDER) -> list[str]:
    """Return what has come since ``before`` and does not go, a line each; waits for it a while."""
    end = time.monotonic() + _PATIENCE
    while True:
        new = [
            f"process {pid}: {line}" for pid, line in our_processes().items() if pid not in before
        ]
        left = [*new, *(f"shared memory: {path}" for path in abandoned(folder))]
        if not left or time.monotonic() > end:
            return left
        time.sleep(0.2)
