"""What the controller reports of its own absence, and of its transitions' reasons."""

from __future__ import annotations

from collections.abc import Sequence

from lexstack.transition import TransitionState


class Absence:
    """The ticks that the controller served, and why its transitions are not as asked."""

    def __init__(self, longest: int) -> None:
        """More than ``longest`` ticks without it are an absence: the plant brakes then."""
        self._longest = longest
        self._served: int | None = None
        self._anew = False
        self._reasons: tuple[str, ...] = ()
        self._news = ""

    def begin_anew(self) -> None:
        """Take note that the plant begins from its start."""
        self._served, self._anew = None, True

    def arrive(self, tick: int) -> str:
        """Return why the controller goes on at this tick as if it had just begun, or ''."""
        before, self._served = self._served, tick
        anew, self._anew = self._anew, False
        if anew:
            return f"the plant began anew, the controller at tick {tick}"
        if before is None:
            return f"the controller began at tick {tick}" if tick > self._longest else ""
        if tick - before > self._longest:
            return f"the controller was away from tick {before + 1} to {tick - 1}"
        return ""

    def see(self, transitions: Sequence[TransitionState]) -> None:
        """Take note of the reasons of one tick."""
        reasons = tuple(each.reason for each in transitions if each.reason)
        if reasons != self._reasons:
            self._reasons = reasons
            self._news = "; ".join(dict.fromkeys(reasons)) or self._news

    def report(self) -> str:
        """Return the newest reason since the last report, or ''."""
        news, self._news = self._news, ""
        return news
