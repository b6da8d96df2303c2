"""Fast DDS' discovery server as a child of the supervisor: it ends when the supervisor does.

``python -m lexstack_bringup.discovery_server ADDRESS PORT``
"""

from __future__ import annotations

import os
import shutil
import sys

from lexstack_ros.node.parent import end_with_supervisor
from lexstack_ros.node.spin import BAD_ARGUMENT

_PROGRAM = "fast-discovery-server"


def main() -> int:
    """Become the server; returns an exit code only where it cannot."""
    if len(sys.argv) != 3:
        print("usage: python -m lexstack_bringup.discovery_server ADDRESS PORT", file=sys.stderr)
        return BAD_ARGUMENT
    program = shutil.which(_PROGRAM)
    if program is None:
        print(f"error: {_PROGRAM}, a part of Fast DDS, is not installed", file=sys.stderr)
        return BAD_ARGUMENT
    end_with_supervisor()  # holds across exec
    address, port = sys.argv[1:]
    os.execv(program, [program, "-i", "0", "-l", address, "-p", port])  # noqa: S606
    return 0


if __name__ == "__main__":
    sys.exit(main())
