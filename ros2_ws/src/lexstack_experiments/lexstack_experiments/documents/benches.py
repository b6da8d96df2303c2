"""What the documents say of the benches: goals, peers, the certificate, and how they were made."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from lexstack_experiments.benches.goals import table_of
from lexstack_experiments.documents.store import Quoted, Store
from lexstack_experiments.documents.text import digits, merged, table
from lexstack_experiments.results import Figure
from lexstack_experiments.text import cell_text

_KEPT = ("hqp", "transition", "tick", "scaling", "htmpc")
"""The benches with goals whose results are kept in docs/results."""


def _goals(store: Store) -> str:
    """Return every goal of speed: what it is, what was reached, and by which figure."""
    found = {name: _figures(store[name]) for name in _KEPT}
    rows = [[cell_text(cell) for cell in row] for row in table_of(found).rows]
    columns = ["bench", "row", "goal", "moonshot", "ours", "", "the worst figure"]
    return table(columns, merged(rows))


def _figures(results: Quoted) -> list[Figure]:
    """Return the figures of a bench's results file."""
    return [
        Figure(each["name"], each["value"], each["unit"]) for each in results.content["figures"]
    ]


def _titled(results: Quoted, title: str) -> list[dict[str, Any]]:
    """Return the rows of the table whose title begins so."""
    tables = results.content["tables"]
    return next(list(each["rows"]) for each in tables if each["title"].startswith(title))


def _hqp(store: Store) -> str:
    """Return how many times as long as ours every solver takes on every sequence."""
    rows = _titled(store["hqp"], "p50 over ours")
    lines = [[name.removeprefix("lexstack ") for name in rows[0]]]
    lines += [[cell_text(cell) for cell in row.values()] for row in rows]
    return table(lines[0], lines[1:])


def _who(store: Store) -> str:
    """Return what every solver solves."""
    return _plain(_titled(store["hqp"], "who solves what"))


def _one_level(store: Store) -> str:
    """Return how the peers of the MPC do on one level."""
    columns = ["robot, N", "solver", "iterations", "p50 over ours", "gap, mean", "gap, worst",
               "ms p50", "ms p99", "failed"]  # fmt: skip
    rows = []
    for row in store["htmpc-peers"].rows():
        ratio = "–" if row["p50 over ours"] is None else digits(row["p50 over ours"], 2)
        told = [row["solver"], row["iterations"], ratio]
        told += [cell_text(row[key]) for key in ("gap, mean", "gap, worst")]
        told += [cell_text(row[key]) for key in ("cpu ms p50", "cpu ms p99", "failed")]
        rows.append([f"{row['robot']}, {row['N']}", *told])
    return table(columns, merged(rows))


def _solves(store: Store) -> str:
    """Return what two levels of the MPC take, with the paper's problem and with ours."""
    by: dict[tuple[str, int, int], dict[str, dict[str, Any]]] = {}
    for row in _titled(store["htmpc"], "two levels"):
        by.setdefault((row["robot"], row["N"], row["spheres"]), {})[row["parameters"]] = row
    lines = []
    for (robot, stages, spheres), row in by.items():
        authors, ours = row["authors"], row["lexstack"]
        times = [authors["cpu ms p50"], authors["cpu ms p99"], authors["paper cpu ms p50"]]
        times += [authors["paper over ours"], ours["cpu ms p50"], ours["cpu ms p99"]]
        name = [robot, str(stages), str(spheres or "–")]
        lines.append([*name, *(digits(each, 3) for each in times)])
    columns = ["robot", "N", "spheres", "authors: ms p50", "p99", "paper's way: ms p50", "ratio"]
    return table([*columns, "lexstack: ms p50", "p99"], lines)


def _plain(rows: list[dict[str, Any]]) -> str:
    """Return a table as it is."""
    return table(list(rows[0]), [[cell_text(cell) for cell in row.values()] for row in rows])


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


def _made(name: str, store: Store) -> str:
    """Return on what a bench ran, and whether that was quiet."""
    content = store[name].content
    machine, quiet = content["machine"], content.get("quiet")
    told = f"commit {content['commit']}, {machine['cores']} cores, Python {machine['python']}"
    if not quiet:
        return told
    return f"{told}; {'; '.join(quiet['reasons']) or 'the machine was quiet'}"


FIELDS: dict[str, Callable[[Store], str]] = {
    **{f"{name}.on": partial(_made, name) for name in (*_KEPT, "htmpc-peers", "strictness")},
    "speed.goals": _goals,
    "hqp.ratios": _hqp,
    "hqp.who": _who,
    "htmpc.table": _solves,
    "htmpc-peers.table": _one_level,
    "strictness.table": _certificate,
}
