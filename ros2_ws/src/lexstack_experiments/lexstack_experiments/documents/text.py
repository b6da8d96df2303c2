"""Numbers and tables as documents show them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from lexstack_experiments.documents.store import Quoted

_SIGNS = {"<=": "≤ ", ">=": "≥ ", "==": ""}


def table(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a Markdown table."""
    head, *lines = [
        "|" + "".join(f" {cell} |" if cell else " |" for cell in cells)
        for cells in (columns, *rows)
    ]
    return "\n".join([head, "|---" * len(columns) + "|", *lines])


def merged(rows: Sequence[Sequence[str]]) -> list[list[str]]:
    """Return rows whose first cell is empty where it is the one of the row above."""
    before, lines = "", []
    for first, *others in rows:
        lines.append(["" if first == before else first, *others])
        before = first
    return lines


def goals(results: Quoted, peer: str) -> str:
    """Return the figures that have a goal, beside a peer's."""
    rows = []
    for figure in results.content["figures"]:
        if figure["goal"] is None:
            continue
        unit = f" {figure['unit']}" if figure["unit"] else ""
        limit, sign = figure["goal"]["limit"], _SIGNS[figure["goal"]["comparison"]]
        name = figure["name"]
        rows.append(
            [
                name[0].lower() + name[1:],
                _count(figure["peer"]["value"], unit) if figure["peer"] else "–",
                f"{sign}{limit:g}",
                _count(figure["value"], unit),
                reached(figure),
            ]
        )
    return table(["figure", peer, "goal", "ours", ""], rows)


def _count(value: float, unit: str) -> str:
    """Return a length without decimals, a count, or a ratio with two decimals."""
    text = f"{value:.0f}" if unit or value != 1.0 else f"{value:.2f}"
    return f"{text}{unit}".replace("-", "−")


def length(value: float | None) -> str:
    """Return a length [mm] with three digits; below a micrometre as a bound."""
    if value is None:
        return "–"
    return "< 0.001" if abs(value) < 1e-3 else digits(value)


def digits(value: float, count: int = 3) -> str:
    """Return a number with so many significant digits, without exponent or needless zeros."""
    rounded = float(f"{value:.{count}g}")
    return f"{rounded:g}" if abs(rounded) < 1e6 else f"{rounded:.0f}"


def ratio(value: float | None) -> str:
    """Return a ratio with two decimals."""
    return "–" if value is None else f"{value:.2f}"


def reached(figure: dict[str, Any]) -> str:
    """Return whether a figure's goal is reached, in words."""
    return {True: "reached", False: "NOT reached", None: ""}[figure["reached"]]
