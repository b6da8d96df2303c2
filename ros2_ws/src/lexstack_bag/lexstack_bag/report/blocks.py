"""Figures made of plain arrays: paths from above, time lines, errors by level, solve times.

They know nothing of a run, so that anything with arrays can be shown: an HTMPC plan, an experiment.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from markupsafe import Markup
from numpy.typing import ArrayLike

from lexstack_bag.figures.phases import Phase
from lexstack_bag.report.figure import Figure
from lexstack_bag.report.layout import TIME, single, stacked
from lexstack_bag.report.traces import DASHES, GREY, SERIES, Plain, drawn, suffix, typed

_MOST_POINTS = 3000  # of a path or a series
_HATCHES = ("", "/", "x", "-", "+", ".", "|", "\\")  # told apart without colour
_SYMBOLS = ("circle-open", "x-thin", "square-open", "diamond-open", "cross-thin")


@dataclass(frozen=True, slots=True)
class Path:
    """A line seen from above.

    Attributes:
        name: in the legend.
        x: m, shape (k,).
        y: m, shape (k,).
        color: of the line; None: the next of the palette.
        dash: of the line; None: the next style.
    """

    name: str
    x: ArrayLike
    y: ArrayLike
    color: str | None = None
    dash: str | None = None


@dataclass(frozen=True, slots=True)
class Span:
    """A time in which something named was so.

    Attributes:
        lane: the row in which it stands, e.g. "base".
        label: what was so, e.g. the task; equal labels have one colour.
        start: s.
        end: s.
    """

    lane: str
    label: str
    start: float
    end: float


def paths_from_above(
    name: str,
    title: str,
    caption: str,
    paths: Sequence[Path],
    targets: Mapping[str, tuple[float, float]] | None = None,
    obstacles: Sequence[tuple[float, float, float]] = (),
) -> Figure:
    """Return paths in the floor's plane, to scale.

    Args:
        name: the figure's HTML id.
        title: heading.
        caption: plain text, or Markup.
        paths: lines; each begins with a dot.
        targets: points by name, x and y [m].
        obstacles: circles: x, y, radius [m].
    """
    traces: list[Plain] = []
    for i, path in enumerate(paths):
        x, y = np.asarray(path.x, dtype=np.float64), np.asarray(path.y, dtype=np.float64)
        stride = max(1, -(-len(x) // _MOST_POINTS))
        color = path.color or SERIES[i % len(SERIES)]
        dash = path.dash or DASHES[i % len(DASHES)]
        traces.append(
            _plane(path.name, x[::stride], y[::stride])
            | {
                "mode": "lines",
                "line": {"color": color, "width": 1.8, "dash": dash},
            }
        )
        traces.append(
            _plane(path.name, x[:1], y[:1])
            | {
                "mode": "markers",
                "showlegend": False,
                "marker": {"color": color, "size": 8},
            }
        )
    for i, (target, (x_target, y_target)) in enumerate((targets or {}).items()):
        symbol = _SYMBOLS[i % len(_SYMBOLS)]
        traces.append(
            _plane(target, np.array([x_target]), np.array([y_target]))
            | {
                "mode": "markers",
                "legendgroup": f"target {target}",
                "marker": {"symbol": symbol, "size": 12, "color": "black", "line": {"width": 2}},
            }
        )
    layout = single("x [m]", "y [m]", 460)
    layout["yaxis"] |= {"scaleanchor": "x", "scaleratio": 1}
    layout["hovermode"] = "closest"
    layout["shapes"] = [_circle(*obstacle) for obstacle in obstacles]
    return Figure(name, title, caption, traces, layout, linked=False)


def timeline(
    name: str, title: str, caption: str, spans: Sequence[Span], whole: tuple[float, float]
) -> Figure:
    """Return what was so at what time, a row for every lane.

    Args:
        name: the figure's HTML id.
        title: heading.
        caption: plain text, or Markup.
        spans: in any order.
        whole: begin and end of the time axis [s].
    """
    lanes = list(dict.fromkeys(span.lane for span in spans))
    labels = list(dict.fromkeys(span.label for span in spans))
    traces: list[Plain] = []
    for i, label in enumerate(labels):
        mine = [span for span in spans if span.label == label]
        traces.append(
            {
                "type": "bar",
                "orientation": "h",
                "name": label,
                "y": [span.lane for span in mine],
                "base": [span.start for span in mine],
                "x": [span.end - span.start for span in mine],
                "text": [label for _ in mine],
                "textposition": "inside",
                "insidetextanchor": "middle",
                "insidetextfont": {"color": "black"},
                "customdata": [[span.start, span.end] for span in mine],
                "hovertemplate": "%{customdata[0]:.2f} to %{customdata[1]:.2f} s",
                "marker": {
                    "color": SERIES[i % len(SERIES)],
                    "opacity": 0.55,
                    "pattern": {
                        "shape": _HATCHES[i % len(_HATCHES)],
                        "fillmode": "overlay",
                        "fgopacity": 0.3,
                        "size": 6,
                    },
                },
            }
        )
    layout = single(TIME, "", 44 * len(lanes))
    layout["xaxis"] |= {"range": list(whole)}
    layout["yaxis"] |= {"categoryorder": "array", "categoryarray": lanes[::-1], "automargin": True}
    layout |= {"barmode": "overlay", "hovermode": "closest", "bargap": 0.25}
    return Figure(name, title, caption, traces, layout)


def series(
    name: str,
    title: str,
    caption: str,
    time: ArrayLike,
    rows: Sequence[tuple[str, str, Mapping[str, ArrayLike]]],
    *,
    log: bool = False,
    phases: Sequence[Phase] = (),
) -> Figure:
    """Return values over time, in plots above each other: errors by level, solve times, gaps.

    Args:
        name: the figure's HTML id.
        title: heading.
        caption: plain text, or Markup.
        time: s, shape (k,), in even steps.
        rows: for each plot its axis title without unit, the unit, and the values, shape (k,), by
            name; nan where there is none.
        log: logarithmic axes.
        phases: marked by lines where they begin.
    """
    times = np.asarray(time, dtype=np.float64)
    count = len(times)
    span = (float(times[0]), float(times[-1])) if count else (0.0, 1.0)
    step = (span[1] - span[0]) / max(count - 1, 1)
    stride = max(1, -(-count // _MOST_POINTS))
    traces = []
    for row, (_, unit, values) in enumerate(rows, start=1):
        key = suffix(row)
        for i, (label, one) in enumerate(values.items()):
            traces.append(
                {
                    "type": "scatter",
                    "mode": "lines",
                    **drawn(np.asarray(one, dtype=np.float64), span[0], step, stride),
                    "name": label,
                    "line": {"color": SERIES[i % len(SERIES)], "dash": DASHES[i % len(DASHES)]},
                    "xaxis": f"x{key}",
                    "yaxis": f"y{key}",
                    "hovertemplate": f"%{{y:.5g}} {unit}",
                    "hoverlabel": {"namelength": -1},
                }
            )
    titles = [f"{head} [{unit}]" for head, unit, _ in rows]
    layout = stacked(titles, 190, phases, span)
    if log:
        for row in range(1, len(rows) + 1):
            layout[f"yaxis{suffix(row)}"] |= {"type": "log", "exponentformat": "power"}
    return Figure(name, title, caption, traces, layout)


def _plane(name: str, x: Any, y: Any) -> Plain:
    """Return what all traces of a plane share."""
    return {
        "type": "scatter",
        "name": name,
        "legendgroup": name,
        "x": typed(x),
        "y": typed(y),
        "hovertemplate": Markup("x %{x:.3f} m<br>y %{y:.3f} m"),
    }


def _circle(x: float, y: float, radius: float) -> Plain:
    """Return an obstacle."""
    return {
        "type": "circle",
        "x0": x - radius,
        "x1": x + radius,
        "y0": y - radius,
        "y1": y + radius,
        "line": {"color": GREY, "width": 1.5},
        "fillcolor": "rgba(204, 121, 167, 0.35)",
        "layer": "below",
    }
