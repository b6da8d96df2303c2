"""A disk that is full soon: a small tmpfs, or where mounts are not permitted, small files.

``python -m lexstack_testing.faults.disk --ros-args ...`` is a recorder whose files may not grow.
"""

from __future__ import annotations

import resource
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from lexstack_ros.recorder.node import main as record

_BYTES = 400_000


@contextmanager
def small_disk(folder: Path) -> Iterator[tuple[Path, str]]:
    """Yield a folder, and the module to record with ('' for the usual one).

    What was written stands afterwards in the folder of the same name with ``_copy`` behind.
    """
    folder.mkdir()
    kept = folder.with_name(f"{folder.name}_copy")
    mount = ["mount", "-t", "tmpfs", "-o", f"size={_BYTES}", "tmpfs", str(folder)]
    try:
        mounted = subprocess.run(mount, check=False, capture_output=True).returncode == 0
    except OSError:
        mounted = False
    try:
        yield folder, "" if mounted else __name__
        shutil.copytree(folder / "bag", kept)
    finally:
        if mounted:
            subprocess.run(["umount", "-l", str(folder)], check=False, capture_output=True)


def main() -> int:
    """Run the recorder; returns the exit code."""
    resource.setrlimit(resource.RLIMIT_FSIZE, (_BYTES, _BYTES))
    return record()


if __name__ == "__main__":
    sys.exit(main())
