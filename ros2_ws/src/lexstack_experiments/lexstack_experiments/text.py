"""Results as plain text: the figures beside paper and peer, the main table, the last line."""

from __future__ import annotations

from collections.abc import Sequence

from lexstack_experiments.results import Cell, Figure, Results, Table

_SIGNS = {"<=": "≤", ">=": "≥", "==": "="}
_HEAD = ("figure", "paper", "peer or baseline", "goal", "ours", "")


def lines_of(results: Results) -> list[str]:
    """Return all that is printed at the end of an experiment; the last line counts the goals."""
    figures = Table(_HEAD, tuple(_row(figure) for figure in results.figures))
    made = f"{results.cases} cases, seed {results.seed}"
    machine = f"{results.machine.cores} cores, Python {results.machine.python}"
    parts = [
        [f"{results.name}: {made}, {machine}"],
        *(aligned(table) for table in results.tables),
        list(results.notes),
        [results.quiet.text] if results.quiet else [],
        aligned(figures) if results.figures else [],
    ]
    return [line for part in parts if part for line in (*part, "")] + [reached_line(results)]


def reached_line(results: Results) -> str:
    """Return how many goals are reached, and then what fell short with its figure."""
    goals = results.goals
    short = [figure for figure in goals if not figure.reached]
    told = "; ".join(f"{figure.name} {_short(figure)}" for figure in short)
    count = f"reached {len(goals) - len(short)} of {len(goals)}"
    return f"{count}: {told}" if told else count


def aligned(table: Table) -> list[str]:
    """Return a table as lines: words to the left, numbers to the right."""
    if not table.rows:
        return []
    texts = [list(table.columns)] + [[cell_text(cell) for cell in row] for row in table.rows]
    widths = [max(len(row[i]) for row in texts) for i in range(len(table.columns))]
    words = [any(isinstance(row[i], str) for row in table.rows) for i in range(len(widths))]
    lines = [_line(row, widths, words) for row in texts]
    return [f"{table.title}:", *lines] if table.title else lines


def cell_text(cell: Cell) -> str:
    """Return a cell in words: four significant digits, and a dash for what is not there."""
    if cell is None:
        return "–"
    return cell if isinstance(cell, str) else number(cell)


def number(value: float) -> str:
    """Return a number with at most four significant digits; tiny ones as a bound."""
    if 0.0 < abs(value) < 1e-6:
        return "< 1e-6"
    return f"{value:.4g}"


def goal_text(figure: Figure) -> str:
    """Return a figure's goal in words, or an empty text."""
    if figure.goal is None:
        return ""
    return f"{_SIGNS[figure.goal.comparison]} {_with_unit(figure.goal.limit, figure.unit)}"


def _row(figure: Figure) -> tuple[str, ...]:
    """Return the line of one figure."""
    peer = figure.peer
    word = "reached" if figure.reached else "NOT reached"
    return (
        figure.name,
        figure.paper or "–",
        f"{_with_unit(peer.value, figure.unit)} ({peer.name})" if peer else "–",
        goal_text(figure) or "–",
        _with_unit(figure.value, figure.unit),
        "" if figure.goal is None else word if figure.value is not None else "not in this run",
    )


def _short(figure: Figure) -> str:
    """Return what a figure is, and what it was to be."""
    if figure.value is None:
        return "is not in this run"
    return f"{_with_unit(figure.value, figure.unit)} ({goal_text(figure)})"


def _with_unit(value: float | None, unit: str) -> str:
    """Return a number with its unit, or a dash."""
    return "–" if value is None else f"{number(value)} {unit}".strip()


def _line(texts: Sequence[str], widths: Sequence[int], words: Sequence[bool]) -> str:
    """Return one line of a table."""
    cells = [
        text.ljust(width) if word else text.rjust(width)
        for text, width, word in zip(texts, widths, words, strict=True)
    ]
    return "  ".join(cells).rstrip()
