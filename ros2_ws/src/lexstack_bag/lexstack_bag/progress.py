"""Progress of long work: a bar on a terminal, nothing elsewhere but the line at its end."""

from __future__ import annotations

import sys
import time

_WIDTH = 30
_PERIOD = 0.1  # s between two drawings


class ProgressBar:
    """Call it with how much is done, from 0 to 1; it ends by itself at 1, once."""

    def __init__(self, what: str) -> None:
        """Say ``what`` is done, on the standard error output."""
        self._what = what
        self._stream = sys.stderr
        self._drawn = 0.0
        self._begun = time.monotonic()
        self._ended = False

    def __call__(self, part: float) -> None:
        """Draw the bar, if it is time to."""
        now = time.monotonic()
        if self._ended or (part < 1.0 and now - self._drawn < _PERIOD):
            return
        self._drawn = now
        self._ended = part >= 1.0
        if not self._stream.isatty():
            return
        spent = now - self._begun
        full = round(_WIDTH * min(part, 1.0))
        left = (
            f"{spent / part - spent:4.0f} s left" if 0.02 < part < 1.0 else f"{spent:4.1f} s     "
        )
        bar = "#" * full + "." * (_WIDTH - full)
        end = "\n" if self._ended else ""
        self._stream.write(f"\r{self._what:20} [{bar}] {part:4.0%} {left}{end}")
        self._stream.flush()
