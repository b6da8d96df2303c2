"""The last seconds as plots: alpha, residuals of levels, times of solves."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import viser
from viser import uplot

from lexstack.types import PlantStatus, Vector
from lexstack_bag.report.traces import ROBOTS, SERIES
from lexstack_ros.view.picture import WINDOW, Curves

_DASHES = ((), (8, 4), (2, 3), (8, 3, 2, 3))  # told apart without colour
_LEAST = 1e-9  # a logarithm has no zero
_ALPHA, _RESIDUAL, _SOLVE = "α", "log10 of the residuals [m/s, rad/s]", "solve times [ms]"
_WIDTH = 300  # pixels
_HEIGHT = 170  # pixels
_MOST = 600  # samples of one curve
_BANDS = {
    PlantStatus.BRAKING: ("plant brakes", "rgba(213, 94, 0, 0.35)"),
    PlantStatus.HOLDING: ("plant holds", "rgba(230, 159, 0, 0.35)"),
}


class Plots:
    """Three plots above each other; each is made again where the number of its curves changes."""

    def __init__(self, server: viser.ViserServer) -> None:
        """Know nothing yet."""
        self._gui = server.gui
        self._plots: dict[str, tuple[tuple[str, ...], viser.GuiUplotHandle]] = {}
        panel = server.gui.add_panel()
        with panel.add_tab(f"The last {WINDOW:g} s"):
            self._folders = {
                name: server.gui.add_folder(name, order=place)
                for place, name in enumerate((_ALPHA, _RESIDUAL, _SOLVE))
            }
        panel.dock_left()
        panel.set_width(_WIDTH)

    def show(self, curves: Curves) -> None:
        """Draw; two samples are the least."""
        if len(curves.time) < 2:
            return
        every = -(-len(curves.time) // _MOST)
        time = curves.time[::every]
        blend = {"α": curves.alpha}
        blend |= {
            name: np.where(curves.plant == status, 1.0, 0.0) for status, (name, _) in _BANDS.items()
        }
        levels = {
            f"level {k}": np.log10(np.maximum(_held(row), _LEAST))
            for k, row in enumerate(curves.levels, 1)
        }
        solve = {name: np.nan_to_num(row) for name, row in curves.solve.items()}
        for name, rows in zip(self._folders, (blend, levels, solve), strict=True):
            if rows:
                self._draw(name, time, {key: row[::every] for key, row in rows.items()})

    def _draw(self, name: str, time: Vector, rows: dict[str, Vector]) -> None:
        """Draw one plot."""
        labels, data = tuple(rows), (time, *rows.values())
        known = self._plots.get(name)
        if known is not None and known[0] == labels:
            known[1].data = data
            return
        if known is not None:
            known[1].remove()
        with self._folders[name]:
            plot = self._gui.add_uplot(
                data,
                (uplot.Series(label="t [s]"), *_series(labels, name)),
                scales={"x": uplot.Scale(time=False, auto=True), "y": _scale(name)},
                legend=uplot.Legend(show=True),
                height=_HEIGHT,
            )
        self._plots[name] = labels, plot


def _held(row: Vector) -> Vector:
    """Return a curve with its gaps filled by the value before them, or else after them.

    viser hands a plot numbers alone, and where nan comes first it finds no scale.
    """
    known = np.flatnonzero(np.isfinite(row))
    if not len(known):
        return np.zeros_like(row)
    places = np.searchsorted(known, np.arange(len(row)), "right") - 1
    return row[known[np.maximum(places, 0)]]


def _series(labels: Sequence[str], name: str) -> list[Any]:
    """Return the look of each curve."""
    bands = dict(_BANDS.values())
    colors = ROBOTS if name == _SOLVE else SERIES
    return [
        uplot.Series(label=label, fill=bands[label], width=0, spanGaps=False)
        if label in bands
        else uplot.Series(
            label=label,
            stroke=colors[i % len(colors)],
            width=1.6,
            dash=_DASHES[i % len(_DASHES)],
        )
        for i, label in enumerate(labels)
    ]


def _scale(name: str) -> Any:
    """Return the scale of a plot's values."""
    return uplot.Scale(range=(-0.05, 1.05)) if name == _ALPHA else uplot.Scale(auto=True)
