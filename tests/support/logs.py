"""Waiting for what a process prints into a file."""

from __future__ import annotations

import subprocess
import time
from pathlib import Path
from typing import Any


def until_printed(
    log: Path, text: str, process: subprocess.Popen[Any] | None = None, patience: float = 60.0
) -> str:
    """Return the last line of a file with a text, once there is one.

    Fails after ``patience`` [s of wall time], and with what is printed where ``process`` has ended.
    """
    end = time.monotonic() + patience
    while True:
        printed = log.read_text(encoding="utf-8") if log.exists() else ""
        found = [line for line in printed.splitlines() if text in line]
        if found:
            return found[-1]
        assert process is None or process.poll() is None, process.communicate()[1] or printed
        assert time.monotonic() < end, f"not in {log}: {text}; but {printed[-2000:]}"
        time.sleep(0.05)
