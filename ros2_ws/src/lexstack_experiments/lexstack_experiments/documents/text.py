"""Numbers and tables as documents show them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any


def table(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a Markdown table."""
    head, *lines = [f"| {' | '.join(cells)} |".replace("|  |", "| |") for cells in (columns, *rows)]
    return "\n".join([head, "|---" * len(columns) + "|", *lines])


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
