"""What a plot of the report is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from lexstack_bag.figures.phases import Phase
from lexstack_bag.report.traces import Plain


@dataclass(frozen=True, slots=True)
class Figure:
    """One plot of the report.

    Attributes:
        name: its HTML id.
        title: heading; plain text, or Markup.
        caption: what to see in it; plain text, or Markup.
        traces: plotly traces; of their texts Markup alone is taken for HTML.
        layout: plotly layout.
        linked: whether its time axis moves with those of the other figures.
        choices: labels of what can be chosen; the traces come in as many equal groups, of which
            one is shown. Empty: no choice.
    """

    name: str
    title: str
    caption: str
    traces: list[Plain]
    layout: Plain
    linked: bool = True
    choices: tuple[str, ...] = ()


def letters(phases: Sequence[Phase]) -> list[str]:
    """Return the paper's names of the switches: (A) for the first, and so on."""
    return [f"({chr(ord('A') + i % 26)})" for i in range(len(phases) - 1)]
