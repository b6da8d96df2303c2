"""One picture of all rows and methods: how smooth each is."""

from __future__ import annotations

from pathlib import Path

from lexstack_experiments.experiments.method_runs import Rows
from lexstack_experiments.pictures import COLOURS, legend_beside, picture

_PANELS = (
    ("acceleration", "peak acceleration / limit"),
    ("jerk", "peak jerk / limit"),
)


def draw(rows: Rows, still: str, path: Path) -> None:
    """Write a picture with a line per row and a dot per method, ``still`` as a bar.

    Args:
        rows: the figures.
        still: the name of the run without switches.
        path: of the PNG file.
    """
    names = list(rows)
    methods = [name for name in rows[names[0]] if name != still]
    places = range(len(names))
    with picture(path, 1, 2, (9.0, 0.9 + 0.36 * len(names))) as axes:
        for panel, (figure, title) in zip(axes, _PANELS, strict=True):
            values = {
                method: [getattr(rows[name][method], figure) for name in names]
                for method in (still, *methods)
            }
            panel.plot(values[still], places, "|", color="#000000", markersize=12, label=still)
            for k, method in reversed(list(enumerate(methods))):
                # Where the colours begin again, the shape is another one.
                size, shape = (8, "D") if k == 0 else (5, "o" if k < len(COLOURS) else "^")
                colour = COLOURS[k % len(COLOURS)]
                panel.plot(values[method], places, shape, color=colour, ms=size, label=method)
            panel.axvline(1.0, color="#555555", linewidth=0.8, linestyle=":")
            panel.set_xscale("log")
            panel.set_xlabel(title)
            panel.set_yticks(places, names)
            panel.invert_yaxis()
        axes[1].set_yticklabels([])
        legend_beside(axes[1])
