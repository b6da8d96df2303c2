"""What docs/hqp.md and docs/htmpc.md say of the benches."""

from __future__ import annotations

from typing import Any

from lexstack_experiments.documents.store import Store
from lexstack_experiments.documents.text import table


def _certificate(store: Store) -> str:
    """Return, for every solver, its failures and largest excess over all kinds of problems."""
    by: dict[str, list[dict[str, Any]]] = {}
    for row in store["strictness"].rows():
        by.setdefault(row["solver"], []).append(row)
    lines = []
    for solver, rows in by.items():
        regular = [row for row in rows if row["problems"] != "near-singular"]
        (singular,) = [row for row in rows if row["problems"] == "near-singular"]
        lines.append(
            [
                solver,
                f"{sum(row['failures'] for row in rows)} of {sum(row['number'] for row in rows)}",
                f"{max(float(row['excess']) for row in regular):.1e}",
                f"{float(singular['excess']):.1e}",
                f"{max(float(row['outside']) for row in rows):.1e}",
            ]
        )
    columns = ["solver", "failures", "largest excess", "near singularities", "outside the bounds"]
    return table(columns, lines)


def _made(store: Store, name: str) -> str:
    """Return on what a bench ran, and whether that was quiet."""
    content = store[name].content
    machine, quiet = content["machine"], content.get("quiet")
    told = f"commit {content['commit']}, {machine['cores']} cores, Python {machine['python']}"
    if not quiet:
        return told
    return f"{told}; {'; '.join(quiet['reasons']) or 'the machine was quiet'}"


FIELDS = {
    "strictness.table": _certificate,
    "strictness.on": lambda store: _made(store, "strictness"),
}
