"""What docs/experiments.md says of the experiment ``peers``."""

from __future__ import annotations

from typing import Any

from lexstack_experiments.documents.store import Store
from lexstack_experiments.documents.text import merged, reached, table

_NAME = "peers"
_COLUMNS = ["robot", "limits up to", "law", "reached", "median", "90 %", "ticks beyond position",
            "velocity", "acceleration", "µs p50", "µs p99", "ms before"]  # fmt: skip


def _table(store: Store) -> str:
    """Return how every law did on every arm."""
    rows = []
    for row in store[_NAME].rows():
        times = [_seconds(row[key]) for key in ("median s", "90 % s")]
        beyond = [
            _beyond(row["position ticks"], row["largest rad"], " rad"),
            _beyond(row["velocity ticks"], row["largest x"], " ×"),
            _beyond(row["acceleration ticks"], row["most x"], " ×"),
        ]
        steps = [f"{row[key]:.0f}" for key in ("us p50", "us p99")]
        before = f"{row['ms before']:.0f}" if row["ms before"] >= 1.0 else "–"
        share = f"{row['reached %']:.1f} %"
        rows.append(
            [row["robot"], row["limits"], row["law"], share, *times, *beyond, *steps, before]
        )
    return table(_COLUMNS, merged(rows))


def _seconds(value: float | None) -> str:
    """Return a time, or a dash."""
    return "–" if value is None else f"{value:.2f} s"


def _beyond(ticks: Any, largest: float, unit: str) -> str:
    """Return in how many ticks a limit was left, and by how much at most."""
    return f"{ticks}, {largest:.2g}{unit}" if ticks else "0"


def _goals(store: Store) -> str:
    """Return the figures with a goal."""
    rows = []
    for figure in store[_NAME].content["figures"]:
        unit, goal, peer = figure["unit"], figure["goal"], figure["peer"]
        bound = {"<=": "≤ ", ">=": "≥ ", "==": ""}[goal["comparison"]] + _number(
            goal["limit"], unit
        )
        theirs = f"{peer['name']}: {_number(peer['value'], unit)}" if peer else "–"
        rows.append(
            [figure["name"], theirs, bound, _number(figure["value"], unit), reached(figure)]
        )
    return table(["figure", "best peer", "goal", "ours", ""], rows)


def _number(value: float | None, unit: str) -> str:
    """Return a share, a ratio or a count with its unit."""
    if value is None:
        return "–"
    return {"%": f"{value:.1f} %", "x": f"{value:.2f} ×"}.get(unit, f"{value:.0f}")


def _on(store: Store) -> str:
    """Return how many reaches there were, on what, and of which commit."""
    content = store[_NAME].content
    machine = content["machine"]
    return (
        f"{content['cases']} reaches of each arm, seed {content['seed']}, commit "
        f"{content['commit']}, {machine['cores']} cores ({machine['processor']}), "
        f"Python {machine['python']}"
    )


FIELDS = {"peers.table": _table, "peers.goals": _goals, "peers.on": _on}
