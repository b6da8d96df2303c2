"""What docs/experiments.md says of the experiment ``obstacle``."""

from __future__ import annotations

from lexstack_experiments.documents.store import Store
from lexstack_experiments.documents.text import digits, goals, length, merged, ratio, table

_NAME = "obstacle"


def _table(store: Store) -> str:
    """Return what came of every case in every way."""
    rows = []
    for row in store[_NAME].rows():
        clearance = f"{row['clearance mm']:.0f} mm".replace("-", "−")
        arrives = row["case"] != "robots sent across"  # nobody does: there is no final error
        final = row["EE final mm"] if arrives else None
        peak = _mm(row["EE peak mm"])
        touching = str(row["touching, ticks"])
        rows.append(
            [
                row["case"],
                row["way"],
                clearance,
                touching,
                peak,
                _mm(final),
                ratio(row["acc. ratio"]),
            ]
        )
    columns = ["case", "way", "clearance", "ticks touching", "EE error, peak", "EE error, final"]
    return table([*columns, "acceleration / limit"], merged(rows))


def _mm(value: float | None) -> str:
    """Return a length with its unit, or a dash."""
    if value is None:
        return "–"
    text = f"{value:.0f}" if value >= 100.0 else length(value) if value < 1e-3 else _two(value)
    return f"{text} mm"


def _two(value: float) -> str:
    """Return a length below 100 mm with two digits, no more than three decimals."""
    return f"{value:.3f}" if value < 0.01 else digits(value, 3 if value >= 10.0 else 2)


def _goals(store: Store) -> str:
    """Return the figures with a goal."""
    return goals(store[_NAME], peer="nothing")


FIELDS = {"obstacle.table": _table, "obstacle.goals": _goals}
