"""What docs/experiments.md says of the experiment ``realism``."""

from __future__ import annotations

from lexstack_experiments.documents.store import Store
from lexstack_experiments.documents.text import digits, length, table

_NAME = "realism"
_FLAWS = {
    "none": "none",
    "encoder_step": "encoders",
    "velocity_noise": "velocity noise",
    "latency": "latency",
    "payload": "payload",
    "friction": "friction",
    "base_slip": "base slip",
    "pushes": "push",
    "all": "all",
}
_LENGTHS = ("EE after (A) mm", "base after (A) mm", "final EE mm", "peak EE mm")
_TOUCH = "robots touch, ticks"


def _table(store: Store) -> str:
    """Return the table of all flaws."""
    rows = []
    for flaw, title in _FLAWS.items():
        row = store[_NAME].row("flaw", flaw)
        rows.append([title, *(length(row[name]) for name in _LENGTHS), digits(row["acc. ratio"])])
    return table(["flaw", *_LENGTHS, "acceleration / limit"], rows)


def _touching(store: Store, flaw: str) -> str:
    """Return for how long robots touch each other, in seconds."""
    results = store[_NAME]
    return digits(results.row("flaw", flaw)[_TOUCH] / results.content["setup"]["rate_hz"], 2)


def _elsewhere(store: Store) -> str:
    """Return in which rows robots touch."""
    touching = [_FLAWS[row["flaw"]] for row in store[_NAME].rows() if row[_TOUCH]]
    return " and ".join(touching)


FIELDS = {
    "realism.table": _table,
    "realism.encoders-touch-s": lambda store: _touching(store, "encoder_step"),
    "realism.slip-touch-s": lambda store: _touching(store, "base_slip"),
    "realism.touching": _elsewhere,
    "realism.slip-base-mm": lambda store: digits(
        store[_NAME].row("flaw", "base_slip")["base after (A) mm"], 2
    ),
}
