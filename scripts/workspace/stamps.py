"""Content hashes that tell what is done already."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from workspace.ros import Ros

# Raise it when a change of the set-up must make everything anew.
SETUP_VERSION = 1

PACKAGE_FILES = (
    "package.xml",
    "CMakeLists.txt",
    "setup.py",
    "setup.cfg",
    "resource/*",
    "msg/*.msg",
    "srv/*.srv",
    "action/*.action",
)


@dataclass(frozen=True)
class Stamp:
    """A file that stands for finished work and names what it was made from."""

    path: Path
    digest: str

    def is_current(self) -> bool:
        """Return whether the work was finished, from the same inputs."""
        return self.is_whole() and self.path.read_text() == self.digest

    def is_whole(self) -> bool:
        """Return whether the work was finished, from whatever inputs."""
        return self.path.is_file()

    def clear(self) -> None:
        """Mark the work as unfinished."""
        self.path.unlink(missing_ok=True)

    def write(self) -> None:
        """Mark the work as finished."""
        self.path.write_text(self.digest)


def digest(parts: Iterable[str | bytes]) -> str:
    """Return a hash of the parts and of where each ends."""
    total = hashlib.sha256()
    for part in parts:
        data = part.encode() if isinstance(part, str) else part
        total.update(len(data).to_bytes(8, "big") + data)
    return total.hexdigest()


def environment_stamp(root: Path, ros: Ros, python: str) -> Stamp:
    """Return the stamp of the virtual environment made with that Python."""
    lock = (root / "requirements.lock").read_bytes()
    parts = (str(SETUP_VERSION), str(root), str(ros), python, lock)
    return Stamp(root / ".venv/lexstack.stamp", digest(parts))


def workspace_stamp(root: Path, environment: Stamp) -> Stamp:
    """Return the stamp of the colcon workspace built in that environment."""
    source = root / "ros2_ws/src"
    files = sorted(file for name in PACKAGE_FILES for file in source.glob(f"*/{name}"))
    # What writes .venv/environment.sh belongs to it, but not to the packages.
    writer = Path(__file__).with_name("environment.py")
    parts: list[str | bytes] = [environment.digest, writer.read_bytes()]
    for file in files:
        parts += [str(file.relative_to(source)), file.read_bytes()]
    return Stamp(root / "ros2_ws/install/lexstack.stamp", digest(parts))
