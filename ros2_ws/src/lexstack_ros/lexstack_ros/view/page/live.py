"""The page of a run under way."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection

from lexstack.robots import Team
from lexstack.types import Vector
from lexstack_ros.view.orders import Known, Order
from lexstack_ros.view.page.controls import Controls
from lexstack_ros.view.page.plots import Plots
from lexstack_ros.view.page.scene import Scene
from lexstack_ros.view.page.server import PageServer
from lexstack_ros.view.page.status import answer_line, status_table
from lexstack_ros.view.page.targets import Targets
from lexstack_ros.view.picture import History, Picture

_REDRAWN = 0.5  # s of wall time between two states of the plots
_WIDTH = 310  # pixels, of the panel
_RATE = 0.5  # s of wall time over which ticks are counted at least


class LivePage:
    """What browsers see, and where they ask.

    Attributes:
        url: where it is.
    """

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
        self._server = server = PageServer(title)
        self.url = server.url
        server.gui.configure_theme(show_logo=False, show_share_button=False)
        server.gui.main_panel.dock_right()
        server.gui.main_panel.set_width(_WIDTH)
        self._scene = Scene(server, team)
        self._scene.look_at(home)
        self._status = server.gui.add_html(answer_line("waiting for the run"), order=10)
        self._answer = server.gui.add_html("", order=15)
        self._controls = Controls(server, known, ask, self.refuse)
        self._targets = Targets(server, team, known, ask, self.refuse)
        self._add_target_options()
        self._plots = Plots(server)
        self._history, self._drawn = History(), 0.0
        self._begun: tuple[int, float] | None = None  # tick and wall time from which rate counts

    @property
    def is_watched(self) -> bool:
        """Whether anybody looks: otherwise nothing needs to be made."""
        return bool(self._server.get_clients())

    def show(self, picture: Picture) -> None:
        """Show a picture to all who look."""
        with self._server.atomic():
            self._scene.show(picture)
            self._targets.show(picture.goals)
            self._status.content = status_table(picture, self._rate(picture.tick))
        self._history.add(picture)
        now = time.monotonic()
        if now - self._drawn >= _REDRAWN:
            self._drawn = now
            self._plots.show(self._history.curves())

    def offer(self, services: Collection[str]) -> None:
        """Show the buttons of what the run serves."""
        self._controls.offer(services)

    def say(self, text: str) -> None:
        """Show what became of an order."""
        self._answer.content = answer_line(text)

    def refuse(self, reason: str) -> None:
        """Show why an order was not carried out."""
        self._answer.content = answer_line(reason, bad=True)

    def close(self) -> None:
        """Send the browsers away."""
        self._server.close()

    def _add_target_options(self) -> None:
        """Add what can be chosen of the gizmos."""
        gui = self._server.gui
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
