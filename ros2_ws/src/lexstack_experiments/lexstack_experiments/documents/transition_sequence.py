"""What the documents say of the experiment ``transition-sequence``."""

from __future__ import annotations

from typing import Any

from lexstack_experiments.documents.store import Store
from lexstack_experiments.documents.text import digits, length, ratio, reached, table

_NAME = "transition-sequence"
_SETTLED = "Switch ({}) to settled, against instant_limited"
_JERK = "Peak jerk of the command / limit"


def _figure_row(store: Store, name: str, title: str) -> list[str]:
    """Return the row of a figure beside the paper's, the baseline's and its goal."""
    figure = store[_NAME].figure(name)
    unit = f" {figure['unit']}" if figure["unit"] else ""
    limit = figure["goal"]["limit"]
    sign = "≤ " if figure["goal"]["comparison"] == "<=" else ""
    return [
        title,
        figure["paper"] or "–",
        _cell(figure["peer"]["value"], unit),
        f"{sign}{digits(limit)}{unit}",
        _cell(figure["value"], unit),
        reached(figure),
    ]


def _cell(value: float, unit: str) -> str:
    """Return a length [mm], a count, or a ratio."""
    if unit:
        return f"{length(value)}{unit}"
    return f"{value:.0f}" if value in (0.0,) else ratio(value)


def _settled_row(store: Store, switch: str) -> list[str]:
    """Return the row of a switch: how long until it has settled."""
    figure = store[_NAME].figure(_SETTLED.format(switch))
    row = _switch(store, switch)
    times = f"{row['settled s']:.2f} s, {figure['value']:.2f} ×"
    limit = f"≤ {digits(figure['goal']['limit'])} ×"
    baseline = f"{row['baseline s']:.2f} s"
    return [f"({switch}) to settled", "–", baseline, limit, times, reached(figure)]


def _switch(store: Store, switch: str) -> dict[str, Any]:
    """Return the row of a switch in the results."""
    return store[_NAME].row("switch", f"({switch})")


def _table(store: Store) -> str:
    """Return all figures with a goal."""
    figures = {
        "End-effector error after (A)": "end-effector error after (A)",
        "Base error after (A)": "base error after (A)",
        "Final end-effector error": "final end-effector error",
        "Peak acceleration of the command / limit": "peak acceleration of the command / limit",
        "Ticks with an empty box of bounds": "ticks with an empty box",
        "Switches not adopted, of 3": "switches not adopted",
    }
    rows = [_figure_row(store, name, title) for name, title in figures.items()]
    rows += [_settled_row(store, switch) for switch in "ABC"]
    return table(["figure", "paper", "baseline", "goal", "ours", ""], rows)


def _cost(store: Store) -> str:
    """Return by how many per cent the switches settle later than the baseline."""
    shares = [
        100.0 * (store[_NAME].figure(_SETTLED.format(switch))["value"] - 1.0) for switch in "ABC"
    ]
    return f"{min(shares):.0f} to {max(shares):.0f} %"


def _jerk(store: Store) -> str:
    """Return the peak jerk, ours and the baseline's."""
    figure = store[_NAME].figure(_JERK)
    return (
        f"Peak jerk is {digits(figure['value'], 2)} of the limit, "
        f"the baseline's is {figure['peer']['value']:.1f}."
    )


FIELDS = {
    "transition-sequence.table": _table,
    "transition-sequence.jerk": _jerk,
    "transition-sequence.cost": _cost,
}
