"""Plotly layouts: stacked plots on one time axis, or a grid of them; marks at the switches."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from markupsafe import Markup

from lexstack_bag.figures.phases import Phase
from lexstack_bag.report.figure import letters
from lexstack_bag.report.traces import GREY, Plain, suffix

TIME = "simulated time [s]"
"""Title of every axis of time."""

_GRID = "#E3E7EC"
_INK = "#1D2733"
_TOP = 64  # px above the plots: legend and names of the stacks
_BOTTOM = 46  # px
_RIGHT = 46  # px: the tool bar stands there, beside the plots and below no legend
_BOLD = Markup("<b>{}</b>")

# Of the legend, to leave room for it.
_ROW, _WIDTH = 19, 960  # px: height of a row, width of all
_LETTER, _KEY = 7, 50  # px: of a name's letter, of the line before it


def stacked(
    titles: Sequence[str],
    height: int,
    phases: Sequence[Phase],
    span: tuple[float, float],
) -> Plain:
    """Return the layout of plots above each other that share one time axis.

    Args:
        titles: of the vertical axes, with units, from the top.
        height: of one plot [px].
        phases: their starts are marked by lines with the stacks' names.
        span: of the time axis [s].
    """
    rows = len(titles)
    layout = _base(rows * height + _TOP + _BOTTOM)
    for row, title in enumerate(titles, start=1):
        layout |= _plot(row, title, _band(row - 1, rows), span, last=row == rows)
    layout |= marks(phases)
    return layout


def grid(
    titles: Sequence[Sequence[str]],
    heads: Sequence[str],
    height: int,
    span: tuple[float, float],
    shapes: list[Plain],
) -> Plain:
    """Return the layout of rows x columns of plots; plots are numbered row by row.

    Args:
        titles: of the vertical axes, by row and column.
        heads: of the columns.
        height: of one plot [px].
        span: of the time axes [s].
        shapes: lines across the plots.
    """
    rows, columns = len(titles), len(heads)
    layout = _base(rows * height + _TOP + _BOTTOM)
    width = (1.0 - 0.09 * (columns - 1)) / columns
    for i in range(rows * columns):
        row, column = divmod(i, columns)
        left = column * (width + 0.09)
        across = {"domain": [left, left + width]}
        title, last = titles[row][column], row == rows - 1
        layout |= _plot(i + 1, title, _band(row, rows), span, last=last, **across)
    layout["shapes"] = shapes
    layout["annotations"] = [
        {
            "text": _BOLD.format(head),
            "xref": "paper",
            "yref": "paper",
            "x": i * (width + 0.09) + width / 2,
            "y": 1.0,
            "yanchor": "bottom",
            "showarrow": False,
            "font": {"size": 13, "color": _INK},
        }
        for i, head in enumerate(heads)
    ]
    return layout


def _plot(
    number: int,
    title: str,
    band: tuple[float, float],
    span: tuple[float, float],
    *,
    last: bool,
    **across: Any,
) -> Plain:
    """Return the axes of one of several plots that share the axis of time [s]."""
    key = suffix(number)
    across |= {"anchor": f"y{key}", "showticklabels": last, "range": list(span)}
    return {
        f"xaxis{key}": _axis(TIME if last else "", **across, **({"matches": "x"} if key else {})),
        f"yaxis{key}": _axis(title, domain=list(band), anchor=f"x{key}"),
    }


def single(x_title: str, y_title: str, height: int) -> Plain:
    """Return the layout of one plot with these axis titles; height of the plot [px]."""
    layout = _base(height + _TOP + _BOTTOM)
    layout["xaxis"] = _axis(x_title, anchor="y")
    layout["yaxis"] = _axis(y_title, anchor="x")
    return layout


def marks(phases: Sequence[Phase]) -> Plain:
    """Return vertical lines at the switches, with the stacks' names above the plots."""
    switches = list(zip(letters(phases), phases[1:], strict=True))
    annotations = [
        {
            "text": _BOLD.format(label) + f" → {phase.title}",
            "x": phase.start,
            "y": 1.0,
            "xref": "x",
            "yref": "paper",
            "xanchor": "left",
            "yanchor": "bottom",
            "showarrow": False,
            "font": {"size": 12, "color": GREY},
        }
        for label, phase in switches
    ]
    shapes = [vertical(phase.start, "x", "solid") for _, phase in switches]
    return {"shapes": shapes, "annotations": annotations}


def vertical(time: float, axis: str, dash: str) -> Plain:
    """Return a vertical line over all plots at a time [s] of an x axis."""
    return {
        "type": "line",
        "xref": axis,
        "yref": "paper",
        "x0": time,
        "x1": time,
        "y0": 0,
        "y1": 1,
        "line": {"color": GREY, "width": 1, "dash": dash},
        "layer": "below",
    }


def level(value: float, row: int, color: str) -> Plain:
    """Return a horizontal dashed line at a value of one plot."""
    key = suffix(row)
    return {
        "type": "line",
        "xref": f"x{key} domain",
        "yref": f"y{key}",
        "x0": 0,
        "x1": 1,
        "y0": value,
        "y1": value,
        "line": {"color": color, "width": 1.2, "dash": "dash"},
    }


def with_room(layout: Plain, traces: Sequence[Plain]) -> Plain:
    """Return a layout with room above the plots for a legend of several rows."""
    entries = dict.fromkeys(
        str(entry.get("name", ""))
        for entry in (*traces, *layout.get("shapes", []))
        if entry.get("visible", True)
        and entry.get("showlegend", "mode" in entry or entry["type"] == "bar")  # shapes: no
    )
    rows, used = 1, 0
    for name in entries:
        width = _KEY + _LETTER * len(name)
        if used and used + width > _WIDTH:
            rows, used = rows + 1, 0
        used += width
    more = _ROW * (rows - 1)
    if not more:
        return layout
    margin = layout["margin"] | {"t": layout["margin"]["t"] + more}
    return layout | {"height": layout["height"] + more, "margin": margin}


def _band(row: int, rows: int) -> tuple[float, float]:
    """Return the part of the height that a row from the top takes."""
    gap = 0.05 if rows > 1 else 0.0
    size = (1.0 - gap * (rows - 1)) / rows
    low = 1.0 - row * (size + gap) - size
    return max(0.0, low), min(1.0, low + size)


def _base(height: int) -> Plain:
    """Return what all layouts share."""
    return {
        "height": height,
        "margin": {"l": 72, "r": _RIGHT, "t": _TOP, "b": _BOTTOM},
        "modebar": {"orientation": "v"},
        "font": {
            "family": "system-ui, -apple-system, Segoe UI, sans-serif",
            "size": 12,
            "color": _INK,
        },
        "paper_bgcolor": "white",
        "plot_bgcolor": "white",
        "hovermode": "x",
        "legend": {
            "orientation": "h",
            "yref": "container",
            "y": 1.0,
            "yanchor": "top",
            "x": 0,
            "font": {"size": 12},
        },
    }


def _axis(title: str, **more: Any) -> Plain:
    """Return one axis."""
    return {
        "title": {"text": title, "standoff": 8},
        "gridcolor": _GRID,
        "linecolor": "#B8C1CB",
        "ticks": "outside",
        "ticklen": 4,
        "tickcolor": "#B8C1CB",
        "zeroline": False,
        "showline": True,
        "hoverformat": ".5g",
        **more,
    }
