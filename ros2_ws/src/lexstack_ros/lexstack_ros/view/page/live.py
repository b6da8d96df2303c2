"""The page of a run under way."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Sequence

from lexstack.robots import Team
from lexstack.types import Vector
from lexstack_ros.view.orders import Known, Order
from lexstack_ros.view.page.base import Page
from lexstack_ros.view.page.controls import Controls
from lexstack_ros.view.page.status import answer_line
from lexstack_ros.view.page.targets import Targets
from lexstack_ros.view.picture import History, Picture

_RATE = 0.5  # s of wall time over which ticks are counted at least


class LivePage(Page):
    """What browsers see, and where they ask."""

    def __init__(
        self, title: str, team: Team, home: Vector, known: Known, ask: Callable[[Order], None]
    ) -> None:
        """Serve it.

        Args:
            title: of the panel.
            team: the robots.
            home: where they start, shape (nq,).
            known: what orders may name.
            ask: takes every order, checked; called by viser's threads.
        """
        super().__init__(title, team, home)
        self._answer = self.server.gui.add_html("", order=15)
        self._controls = Controls(self.server, known, ask, self.refuse)
        self._targets = Targets(self.server, team, known, ask, self.refuse)
        self._add_target_options()
        self._history = History()
        self._begun: tuple[int, float] | None = None  # tick and wall time from which rate counts

    def show(self, picture: Picture) -> None:
        """Show a picture to all who look."""
        with self.server.atomic():
            self.draw(picture, self._rate(picture.tick))
            self._targets.show(picture.goals, picture.frames)
        self._history.add(picture)
        if self.plots_are_due():
            self.plot(self._history.curves())

    def offer(self, services: Collection[str]) -> None:
        """Show the buttons of what the run serves."""
        self._controls.offer(services)

    def know_stacks(self, names: Sequence[str]) -> None:
        """Offer these stacks from now on."""
        self._controls.know_stacks(names)

    def say(self, text: str) -> None:
        """Show what became of an order."""
        self._answer.content = answer_line(text)

    def refuse(self, reason: str) -> None:
        """Show why an order was not carried out."""
        self._answer.content = answer_line(reason, bad=True)

    def _add_target_options(self) -> None:
        """Add what can be chosen of the gizmos."""
        gui = self.server.gui
        with gui.add_folder("Targets", order=25):
            shown = gui.add_checkbox("show", initial_value=True)
            streams = gui.add_checkbox(
                "follow the hand", initial_value=False, hint="else: sent when it is let go"
            )

        @shown.on_update
        @streams.on_update
        def _(_event: object) -> None:
            self._targets.visible = bool(shown.value)
            self._targets.streams = bool(streams.value)

    def _rate(self, tick: int) -> float | None:
        """Return how many ticks pass in a second of wall time; None: not known yet."""
        now = time.monotonic()
        if self._begun is None or tick < self._begun[0] or now - self._begun[1] > 3.0:
            self._begun = tick, now
        first, begun = self._begun
        return (tick - first) / (now - begun) if now - begun > _RATE else None
