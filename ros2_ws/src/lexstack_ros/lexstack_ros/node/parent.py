"""A node ends when the process that started it ends (Linux)."""

from __future__ import annotations

import ctypes
import os
import signal
import sys

PARENT = "LEXSTACK_PARENT"
"""The environment variable that holds the process id of the supervisor."""

_PR_SET_PDEATHSIG = 1


def end_with_supervisor() -> None:
    """Let this process get SIGTERM when the supervisor that started it is gone (Linux)."""
    parent = os.environ.get(PARENT)
    if parent is None or sys.platform != "linux":
        return
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
    if os.getppid() != int(parent):
        os.kill(os.getpid(), signal.SIGTERM)
