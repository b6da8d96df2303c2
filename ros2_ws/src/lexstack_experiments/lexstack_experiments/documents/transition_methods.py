"""What docs/experiments.md says of the experiment ``transition-methods``."""

from __future__ import annotations

from lexstack_experiments.documents.store import Store
from lexstack_experiments.documents.text import digits, table

_NAME = "transition-methods"
_BASELINE = "no switch"


def _matrix(store: Store, title: str) -> str:
    """Return the peaks of all methods in all rows; the best, and those that tie, in bold."""
    results = store[_NAME]
    place = [entry["title"] for entry in results.content["tables"]].index(title)
    rows, tie = results.rows(place), results.content["setup"]["tie"]
    columns = list(rows[0])
    lines = []
    for row in rows:
        methods = [name for name in columns[1:] if name != _BASELINE]
        least = min(row[name] for name in methods)
        cells = [row["row"]]
        for name in columns[1:]:
            text = _peak(row[name])
            best = name != _BASELINE and row[name] <= tie * least
            cells.append(f"**{text}**" if best else text)
        lines.append(cells)
    return table(columns, lines)


def _peak(value: float) -> str:
    """Return a peak over its limit, with two or three digits."""
    return digits(value, 3 if value >= 0.1 else 2)


FIELDS = {
    "transition-methods.acceleration": lambda store: _matrix(store, "peak acceleration / limit"),
    "transition-methods.jerk": lambda store: _matrix(store, "peak jerk / limit"),
}
