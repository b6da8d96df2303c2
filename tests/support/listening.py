"""The sockets that a process has open, as the kernel tells it."""

from __future__ import annotations

import re
from pathlib import Path

_LISTEN = "0A"
Socket = tuple[str, int]  # address in hexadecimal, port


def sockets(pid: int) -> tuple[list[Socket], list[Socket]]:
    """Return the TCP sockets on which a process listens, and its UDP sockets with a port."""
    inodes = set()
    for link in Path(f"/proc/{pid}/fd").iterdir():
        try:
            found = re.fullmatch(r"socket:\[(\d+)\]", str(link.readlink()))
        except OSError:
            continue
        if found:
            inodes.add(found.group(1))
    tcp = [s for kind in ("tcp", "tcp6") for s in _table(pid, kind, inodes, listening=True)]
    udp = [s for kind in ("udp", "udp6") for s in _table(pid, kind, inodes, listening=False)]
    return tcp, udp


def _table(pid: int, kind: str, inodes: set[str], *, listening: bool) -> list[Socket]:
    """Return the sockets of one table of /proc that belong to the process."""
    path = Path(f"/proc/{pid}/net/{kind}")
    if not path.exists():
        return []
    result = []
    for line in path.read_text(encoding="ascii").splitlines()[1:]:
        words = line.split()
        if words[9] in inodes and (not listening or words[3] == _LISTEN):
            host, port = words[1].split(":")
            result.append((host, int(port, 16)))
    return result
