"""What every page has: robots, a table of where the run stands, plots."""

from __future__ import annotations

import time

from lexstack.robots import Team
from lexstack.types import Vector
from lexstack_ros.view.page.plots import Plots
from lexstack_ros.view.page.scene import Scene
from lexstack_ros.view.page.server import PageServer
from lexstack_ros.view.page.status import answer_line, status_table
from lexstack_ros.view.picture import Curves, Picture

_REDRAWN = 0.5  # s of wall time between two states of the plots
_WIDTH = 310  # pixels, of the panel


class Page:
    """Serves a page from its making on.

    Attributes:
        url: where it is.
    """

    def __init__(self, title: str, team: Team, home: Vector) -> None:
        """Serve it; ``title`` of the panel, ``home`` where the robots start, shape (nq,)."""
        self.server = server = PageServer(title)
        self.url = server.url
        server.gui.configure_theme(show_logo=False, show_share_button=False)
        server.gui.main_panel.dock_right()
        server.gui.main_panel.set_width(_WIDTH)
        self.scene = Scene(server, team)
        self.scene.look_at(home)
        self._status = server.gui.add_html(answer_line("waiting for the run"), order=10)
        self._plots, self._drawn = Plots(server), 0.0

    @property
    def is_watched(self) -> bool:
        """Whether anybody looks: otherwise nothing needs to be made."""
        return bool(self.server.get_clients())

    def draw(self, picture: Picture, rate: float | None = None) -> None:
        """Show a picture; ``rate`` is that of ``status_table``."""
        self.scene.show(picture)
        self._status.content = status_table(picture, rate)

    def plots_are_due(self) -> bool:
        """Return whether it is time to draw the plots again; if so, count from now."""
        now = time.monotonic()
        if now - self._drawn < _REDRAWN:
            return False
        self._drawn = now
        return True

    def plot(self, curves: Curves) -> None:
        """Draw the plots."""
        self._plots.show(curves)

    def close(self) -> None:
        """Send the browsers away."""
        self.server.close()
