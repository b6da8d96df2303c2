"""What docs/hardware.md says of the experiment ``hardware``."""

from __future__ import annotations

from lexstack_experiments.documents.store import Store
from lexstack_experiments.documents.text import digits, ratio, table

_NAME = "hardware"
_TURNED, _CONFIGURED, _SWITCHES = range(3)  # places of its tables
_ERRORS = ("EE after (A) mm", "base after (A) mm", "final EE mm")
_METHODS = {
    "bridge": "`bridge`, ours",
    "instant_limited": "new stack at once, within acceleration limits",
    "instant": "new stack at once",
}


def _sequences(store: Store) -> str:
    """Return the errors with every habit, and how the sequence as configured ended."""
    configured = {row["habits"]: row["stopped"] for row in store[_NAME].rows(_CONFIGURED)}
    rows = []
    for row in store[_NAME].rows(_TURNED):
        ends = configured[row["habits"]]
        end = "all settle" if ends == "no" else f"stopped {ends.partition(':')[0]}"
        errors = (_error(row[name]) for name in _ERRORS)
        rows.append([row["habits"], *errors, str(row["settled"]), end])
    return table(["habits", *_ERRORS, "settled, of 3", "as configured"], rows)


def _error(value: float | None) -> str:
    """Return an error [mm]; far below a micrometre as a bound."""
    if value is None:
        return "–"
    return "< 0.0001" if value < 1e-4 else digits(value, 2 if value < 0.1 else 3)


def _switches(store: Store) -> str:
    """Return what became of random switches by each method."""
    rows = []
    for method, title in _METHODS.items():
        row = store[_NAME].row("method", method, _SWITCHES)
        stops = (row["reflex stops"], row["stopped by the adapter"])
        rows.append([title, *map(str, stops), ratio(row["acc. ratio"]), ratio(row["jerk ratio"])])
    peaks = ("peak acceleration / limit", "peak jerk / limit")
    return table(["method", "reflex stops", "stopped by the adapter", *peaks], rows)


FIELDS = {
    "hardware.commit": lambda store: str(store[_NAME].content["commit"])[:7],
    "hardware.sequences": _sequences,
    "hardware.switches": _switches,
}
