"""What docs/experiments.md says of the experiment ``sudden-limits``."""

from __future__ import annotations

from typing import Any

from lexstack_experiments.documents.store import Store
from lexstack_experiments.documents.text import digits, merged, ratio, table

_NAME = "sudden-limits"
_OURS = "ours"
# The laws that the page shows of each case; the others are in results.json.
_SHOWN = {
    "in motion": (
        "ours", "ours, within 1 s", "T(31), brake", "T(31), give way", "T(34) old limits, brake",
        "T(34) old limits, give way", "T(34) last box, brake", "T(34) last box, give way",
    ),
    "at rest": ("ours", "ours, within 1 s", "T(31), give way"),
    "slower joints too": ("ours", "T(31), give way"),
    "pre-empted": ("ours", "T(31), give way"),
    "jerk limits": ("ours",),
    "MuJoCo, in motion": ("ours", "T(31), give way"),
}  # fmt: skip


def _table(store: Store) -> str:
    """Return the rows that the page shows."""
    rows = [_row(row) for row in store[_NAME].rows() if row["law"] in _SHOWN.get(row["case"], ())]
    columns = [
        "case", "law", "ticks with an empty box", "acceleration ratio", "outside [s]", "least [s]",
        "late", "outside later than need be [mrad]", "tools away [mm]",
    ]  # fmt: skip
    return table(columns, merged(rows))


def _row(row: dict[str, Any]) -> list[str]:
    """Return a law's row; ours in bold."""
    law = row["law"].replace("brake", "brakes").replace("give way", "gives way")
    empty = str(row["empty"])
    if row["empty"] == 400:  # all ticks of the case after the trigger
        empty = "400 of 400"
    late, away = row["violation mrad"], row["EE away mm"]
    outside = "never" if row["outside s"] is None else f"{row['outside s']:.2f}"
    if row["law"] == _OURS:
        law, empty, outside = f"**{law}**", f"**{empty}**", f"**{outside}**"
    return [
        row["case"],
        law,
        empty,
        ratio(row["acc. ratio"]),
        outside,
        f"{row['least s']:.2f}",
        "–" if row["late ticks"] is None else str(row["late ticks"]),
        *(digits(value, 2 if value < 100.0 else 3) for value in (late, away)),
    ]


FIELDS = {"sudden-limits.table": _table}
