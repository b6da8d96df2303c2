"""What docs/experiments-htmpc.md says of ``waypoint-path`` and ``delivery``."""

from __future__ import annotations

from lexstack_experiments.documents.store import Store
from lexstack_experiments.documents.text import digits, table

_PATHS = ("HT path m", "ST path m", "ST by height m", "least m")


def _waypoints(store: Store) -> str:
    """Return the row of every height, the lowest first."""
    rows = []
    for row in sorted(store["waypoint-path"].rows(), key=lambda row: row["height m"]):
        share = row["HT / ST"]
        rows.append(
            [
                f"{row['height m']:.1f}",
                *(f"{row[name]:.2f}" for name in _PATHS),
                f"{share:.3f}" if abs(share - 1.0) < 0.005 else f"{share:.2f}",
                *(f"{row[name]:.1f}" for name in ("HT s", "ST s")),
                *(f"{row[name]:.2f}" for name in ("HT nearest m", "reach m")),
            ]
        )
    columns = ["height m", *_PATHS, "HT / ST", "HT s", "ST s", "HT's base nearest m", "reach m"]
    return table(columns, rows)


def _deliveries(store: Store) -> str:
    """Return the row of every layout, speed and set of weights."""
    rows = []
    for row in store["delivery"].rows():
        ours = row["weights"] == "lexstack"
        speed = "at once" if row["tool m/s"] is None else f"{row['tool m/s']:g} m/s"
        share = f"{row['ST / HT']:.2f}"
        goal = ours and row["layout"] == "table" and row["tool m/s"] is not None
        rows.append(
            [
                *((row["layout"], speed) if ours else ("", "")),
                ("**ours**" if goal else "ours") if ours else "authors'",
                *(f"{row[name]:.1f}" for name in ("HT s", "ST s")),
                f"**{share}**" if goal else share,
                *(digits(row[name]) for name in ("HT path m", "ST path m")),
            ]
        )
    columns = ["layout", "tool", "weights", "HT s", "ST s", "ST / HT", "HT path m", "ST path m"]
    return table(columns, rows)


FIELDS = {"waypoint-path.table": _waypoints, "delivery.table": _deliveries}
