"""Bands in the plots over time: when the plant braked, or held the last command."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from lexstack_bag.report.figure import Figure
from lexstack_bag.report.layout import TIME
from lexstack_bag.report.traces import Plain
from lexstack_bag.run.wholeness import Band

_COLORS = {"braking": "rgba(213, 94, 0, 0.20)", "holding": "rgba(230, 159, 0, 0.22)"}
_NAMES = {"braking": "plant braking", "holding": "plant holding the last command"}


def with_bands(figure: Figure, bands: Sequence[Band], title: str = TIME, whose: str = "") -> Figure:
    """Return a figure with bands behind its plots; one without an axis of time stays as it is.

    Args:
        figure: any.
        bands: in s of the axis.
        title: of the axes of time.
        whose: stands behind the name in the legend.
    """
    axes = [
        key.replace("axis", "")
        for key, axis in figure.layout.items()
        if key.startswith("xaxis") and axis["title"]["text"] == title
    ]
    if not axes or not bands:
        return figure
    shapes = [_shape(band, axis, whose) for axis in axes for band in bands]
    named: set[str] = set()
    for shape in shapes:
        shape["showlegend"] = shape["name"] not in named
        named.add(shape["name"])
    layout = figure.layout | {
        "shapes": [*figure.layout.get("shapes", []), *shapes],
        "showlegend": True,
    }
    return replace(figure, layout=layout)


def _shape(band: Band, axis: str, whose: str) -> Plain:
    """Return a band over all plots above an x axis."""
    name = _NAMES[band.kind] + whose
    return {
        "type": "rect",
        "name": name,
        "legendgroup": name,
        "xref": axis,
        "yref": "paper",
        "x0": band.start,
        "x1": band.end,
        "y0": 0,
        "y1": 1,
        "fillcolor": _COLORS[band.kind],
        "line": {"width": 0},
        "layer": "below",
    }
