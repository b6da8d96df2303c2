"""The page of a recorded run: a slider of time, and a button that plays it."""

from __future__ import annotations

import math
import time
from threading import Event
from typing import Any

import viser

from lexstack_ros.view.page.base import Page
from lexstack_ros.view.recorded import Recorded

_STEP = 0.01  # s
_SPEEDS = {"1/4": 0.25, "1/2": 0.5, "1": 1.0, "2": 2.0, "5": 5.0, "20": 20.0}


class BagPage(Page):
    """What browsers see of a bag.

    Attributes:
        time: that is shown, simulated [s].
        plays: whether it goes on by itself.
    """

    def __init__(self, title: str, recorded: Recorded) -> None:
        """Serve it; ``title`` of the panel."""
        first = recorded.picture(0)
        super().__init__(title, recorded.team, first.q)
        self._recorded = recorded
        self.time, self.plays, self._speed = float(recorded.time[0]), False, 1.0
        self._shown = -1
        self._plotted = -1
        self._add_controls()

    def advance(self, seconds: float) -> None:
        """Show what is due after some wall time [s], to whoever looks."""
        if self.plays:
            self.time = min(self.time + self._speed * seconds, self._last)
            self._slider.value = self.time
            if self.time >= self._last:
                self._play(plays=False)
        row = self._recorded.row(self.time)
        if row != self._shown:
            with self.server.atomic():
                self.draw(self._recorded.picture(row))
            self._shown = row
        if row != self._plotted and self.plots_are_due():
            self.plot(self._recorded.curves(row))
            self._plotted = row

    def _add_controls(self) -> None:
        """Add slider, button and speed."""
        gui, times = self.server.gui, self._recorded.time
        first, last = float(times[0]), max(float(times[-1]), float(times[0]) + _STEP)
        with gui.add_folder("Time", order=5):
            self._slider = gui.add_slider("time [s]", first, last, _STEP, first)
            self._button = gui.add_button("Play")
            speed = gui.add_dropdown("speed", tuple(_SPEEDS), initial_value="1")

        @self._slider.on_update
        def _(event: viser.GuiEvent[Any]) -> None:
            if event.client is not None:  # otherwise it is what is shown already
                self._go_to(event.target.value)

        @self._button.on_click
        def _(_event: object) -> None:
            self._play(plays=not self.plays)

        @speed.on_update
        def _(_event: object) -> None:
            self._speed = _SPEEDS.get(speed.value, 1.0)

    def _go_to(self, value: Any) -> None:
        """Show another time; what is none stays without effect."""
        if isinstance(value, int | float) and math.isfinite(value):
            self.time = min(max(float(value), float(self._recorded.time[0])), self._last)

    @property
    def _last(self) -> float:
        """The last recorded time [s]."""
        return float(self._recorded.time[-1])

    def _play(self, *, plays: bool) -> None:
        """Go on, from the beginning where the end was reached, or stop."""
        if plays and self.time >= self._last:
            self.time = float(self._recorded.time[0])
        self.plays = plays
        self._button.label = "Pause" if plays else "Play"


def run_page(page: BagPage, ended: Event, period: float = 0.05) -> None:
    """Show a bag until it is ``ended``; ``period`` of wall time between two pictures [s].

    An exception in the middle of a picture, as Ctrl-C would be, may leave a lock of the server
    taken, and the server could not be ended: so the signal sets an event.
    """
    last = time.monotonic()
    while not ended.wait(period):
        now = time.monotonic()
        page.advance(now - last)
        last = now
