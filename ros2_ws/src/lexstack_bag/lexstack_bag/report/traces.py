"""Plotly traces as plain data: typed arrays on a regular grid of ticks, in colours for all eyes.

Plots are written as the JSON that plotly.js reads. A series carries its start and its step in
place of one time per sample, and single-precision values in base64: a third of the text.
"""

from __future__ import annotations

import base64
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lexstack_bag.run.run import Run

Plain = dict[str, Any]

# Okabe and Ito's palette without yellow, which is lost on white.
BLUE, VERMILLION, GREEN = "#0072B2", "#D55E00", "#009E73"
ORANGE, SKY, PURPLE, BLACK = "#E69F00", "#56B4E9", "#CC79A7", "#000000"
SERIES = (BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY, BLACK)
# Of a robot, in the order of chi: as its tint in the 3-D view, where robot A is orange.
ROBOTS = (VERMILLION, BLUE, GREEN, PURPLE, ORANGE, SKY, BLACK)
# Of the joints of a robot, base included: x and joint 1 shall not look alike. The last three are
# Tol's wine, olive and indigo.
JOINTS = (*SERIES, "#882255", "#999933", "#332288")
DASHES = ("solid", "dash", "dot", "dashdot", "longdash", "longdashdot")  # told apart without colour
GREY = "#6B7785"

_MOST_SAMPLES = 4000  # of one series: more cannot be seen
_MOST_WITHIN = 500  # of a part of it
_MOST_NUMBERS = 80_000  # over the samples of one series of each joint: keeps the file small


@dataclass(frozen=True, slots=True)
class Grid:
    """The regular ticks on which every series of a report is drawn.

    Attributes:
        first: the first tick.
        count: number of ticks.
        start: time of the first tick [s].
        period: of a tick [s].
        stride: ticks per drawn sample; above 1 the least and the largest of 2 strides are drawn.
    """

    first: int
    count: int
    start: float
    period: float
    stride: int

    @classmethod
    def of(cls, run: Run) -> Grid:
        """Return the grid from a run's first tick of the plant to its last."""
        ticks = run.plant.tick
        count = int(ticks[-1] - ticks[0]) + 1
        stride = -(-count // min(_MOST_SAMPLES, _MOST_NUMBERS // run.plant.q.shape[1]))
        return cls(int(ticks[0]), count, float(run.plant.stamp[0]), run.period, stride)

    @property
    def span(self) -> tuple[float, float]:
        """The time of the first and of the last tick [s]."""
        return self.start, self.start + (self.count - 1) * self.period

    def spread(self, ticks: NDArray[np.int64], values: Any) -> NDArray[np.float64]:
        """Return values, shape (K,), on all ticks, shape (count,): nan where there are none."""
        dense = np.full(self.count, np.nan)
        inside = (ticks >= self.first) & (ticks < self.first + self.count)
        dense[ticks[inside] - self.first] = np.asarray(values, dtype=np.float64)[inside]
        dense[np.isinf(dense)] = np.nan
        return dense

    def series(self, ticks: NDArray[np.int64], values: Any) -> Plain:
        """Return ``x0``, ``dx``, ``y`` of a trace that shows every peak."""
        return drawn(self.spread(ticks, values), self.start, self.period, self.stride)

    def window(self, ticks: NDArray[np.int64], values: Any, begin: float, end: float) -> Plain:
        """Return ``x0``, ``dx``, ``y`` of the part between two times [s], more finely drawn."""
        low = max(0, int(np.floor((begin - self.start) / self.period)))
        high = min(self.count, int(np.ceil((end - self.start) / self.period)) + 1)
        dense = self.spread(ticks, values)[low:high]
        stride = max(1, -(-len(dense) // _MOST_WITHIN))
        return drawn(dense, self.start + low * self.period, self.period, stride)


def drawn(values: NDArray[np.float64], start: float, step: float, stride: int) -> Plain:
    """Return ``x0``, ``dx``, ``y`` of values in even steps, one of them drawn per stride."""
    return {"x0": start, "dx": step * stride, "y": typed(extremes(values, stride))}


def extremes(values: NDArray[np.float64], stride: int) -> NDArray[np.float64]:
    """Return the least and the largest of every 2 strides, in the order in which they come.

    A stride of 1 leaves all as it is. Where all of 2 strides are nan, so is what is returned.
    """
    if stride == 1:
        return values
    padded = np.full(-(-len(values) // (2 * stride)) * 2 * stride, np.nan)
    padded[: len(values)] = values
    rows = padded.reshape(-1, 2 * stride)
    low, high = np.fmin.reduce(rows, axis=1), np.fmax.reduce(rows, axis=1)
    unknown = np.isnan(rows)
    first_low = np.argmin(np.where(unknown, np.inf, rows), axis=1)
    first_high = np.argmax(np.where(unknown, -np.inf, rows), axis=1)
    falls = first_high < first_low
    pairs = np.column_stack([np.where(falls, high, low), np.where(falls, low, high)])
    return pairs.ravel()


def typed(values: NDArray[np.float64]) -> Plain:
    """Return an array as plotly.js takes it: single precision in base64."""
    return {"dtype": "f4", "bdata": packed(values)}


def packed(values: Any) -> str:
    """Return numbers in single precision and base64."""
    data = np.ascontiguousarray(values, dtype="<f4").tobytes()
    return base64.b64encode(data).decode("ascii")


def suffix(number: int) -> str:
    """Return what plotly puts behind x and y of a plot's axes; the first one is 1."""
    return "" if number == 1 else str(number)


def line(
    series: Plain,
    name: str,
    color: str,
    *,
    row: int = 1,
    dash: str = "solid",
    unit: str = "",
    width: float = 1.6,
    legend: bool = True,
    **more: Any,
) -> Plain:
    """Return a line trace in subplot ``row``; traces of one name share a legend entry.

    What is shown under the pointer ends with ``unit``.
    """
    key = suffix(row)
    return {
        "type": "scatter",
        "mode": "lines",
        **series,
        "name": name,
        "legendgroup": name,
        "showlegend": legend,
        "line": {"color": color, "width": width, "dash": dash, "simplify": False},
        "xaxis": f"x{key}",
        "yaxis": f"y{key}",
        "hoverlabel": {"namelength": -1},
        "hovertemplate": f"%{{y:.5g}} {unit}".rstrip(),
        **more,
    }
