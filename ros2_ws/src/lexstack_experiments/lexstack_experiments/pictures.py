"""How pictures look: one style, drawn without a display, small files."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000", "#999999")
"""Eight colours that also the colour-blind tell apart (Okabe and Ito)."""

_STYLE = {
    "axes.grid": True,
    "axes.prop_cycle": mpl.cycler(color=COLOURS),
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlesize": 9,
    "font.size": 8,
    "grid.alpha": 0.3,
    "legend.frameon": False,
    "lines.linewidth": 1.2,
}
_DPI = 110


@contextmanager
def picture(path: Path, rows: int, columns: int, size: tuple[float, float]) -> Iterator[list[Axes]]:
    """Yield the axes of a picture, row by row, and write it as PNG at the end.

    Args:
        path: of the file.
        rows: of axes.
        columns: of axes.
        size: width and height [inch].
    """
    with mpl.rc_context(_STYLE):
        figure = Figure(figsize=size, layout="constrained")
        grid = figure.subplots(rows, columns, squeeze=False)
        yield list(grid.flat)
        figure.savefig(path, dpi=_DPI, metadata={"Software": None}, pil_kwargs={"optimize": True})


def mark(axes: Axes, times: dict[str, float]) -> None:
    """Draw a line with a name at each of these times."""
    for name, time in times.items():
        axes.axvline(time, color="#555555", linewidth=0.8, linestyle=":")
        axes.annotate(
            f" {name}", (time, 1.0), xycoords=("data", "axes fraction"), va="top", fontsize=8
        )


def legend_beside(axes: Axes) -> None:
    """Put the legend to the right of the axes, where it hides no curve."""
    axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))


def few_ticks(axes: Axes) -> None:
    """Leave at most five numbers on the vertical axis."""
    axes.yaxis.set_major_locator(MaxNLocator(5))


def share_height(panels: Sequence[Axes]) -> None:
    """Give all panels the limits of the vertical axis that show what is in any of them."""
    low = min(panel.get_ylim()[0] for panel in panels)
    high = max(panel.get_ylim()[1] for panel in panels)
    for panel in panels:
        panel.set_ylim(low, high)


def from_above(panel: Axes) -> None:
    """Make a panel a map of the floor, to scale."""
    panel.set_aspect("equal")
    panel.set_xlabel("x [m]")
    panel.set_ylabel("y [m]")
