"""The order of ticks: what is new, what is over, and what cannot be true."""

from __future__ import annotations

from lexstack_core.errors import InputError

_FAR = 100  # ticks: farther ahead than this is believed only when the next tick follows it


class TickOrder:
    """Tells new states from repeated, replayed and impossible ones.

    A tick far ahead of the last may be a fault or the truth (this process was stopped for a
    while). It is put aside; the state after it shows which it was.

    Attributes:
        begins_anew: whether the last new state is the first after a reset of the plant, or of
            another plant.
    """

    def __init__(self, where: str) -> None:
        """Begin before the first tick of the topic ``where``."""
        self.begins_anew = False
        self._where = where
        self._origin: tuple[str, int] | None = None  # sender, resets
        self._last = -1
        self._doubted = -1

    def is_new(self, sender: str, resets: int, tick: int) -> bool:
        """Return whether a state is to be served: false when it is over already.

        Raises:
            InputError: it is far ahead of the last one, and not the successor of one that was.
        """
        self.begins_anew = False
        if self._origin is None or sender != self._origin[0] or resets > self._origin[1]:
            self.begins_anew = self._origin is not None
            self._origin, self._last, self._doubted = (sender, resets), tick, -1
            return True
        if resets < self._origin[1] or tick <= self._last:
            return False
        if tick > self._last + _FAR and not 0 < tick - self._doubted <= _FAR:
            self._doubted = tick
            raise InputError(f"{self._where}: tick: {tick} is far ahead of {self._last}")
        self._last, self._doubted = tick, -1
        return True
