"""Two runs side by side: every figure of both, and how they differ (``comparison.json``)."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from difflib import SequenceMatcher
from itertools import zip_longest
from typing import Any, Literal, TypeVar

from lexstack_bag.figures.figures import Metrics, PhaseMetrics
from lexstack_bag.figures.phases import Phase

P = TypeVar("P", PhaseMetrics, Phase)

RUN, MESSAGES = "run", "messages"
"""Groups of figures: of the whole run, and the counts of messages by topic."""
TROUBLE = "not as it should be"
"""In the setup: what was wrong with the runs or their bags; missing where nothing was."""

_UNITS = {"mm": "mm", "mrad": "mrad", "s": "s", "us": "µs", "hz": "Hz"}
_SETUP = ("scenario", "mode", "seed")
_WORDS = ("parts", "doubts", "gaps", "part", "singular")  # no figures
# Figures of which less is better; of the others a difference is only a difference.
_LESS_IS_BETTER = (
    "error",
    "ratio",
    "settled",
    "completion",
    "late ticks",
    "missing ticks",
    "holding ticks",
    "braking ticks",
    "not in bag",
    "longest gap",
    "empty bounds",
    "failures",
    "solve",
    "lost",
)


@dataclass(frozen=True, slots=True)
class Difference:
    """One figure of two runs; None where a run does not have it."""

    group: str  # RUN, MESSAGES, or a phase as in "phase 2: reach_base"
    figure: str  # e.g. "ee error, robot_a"
    unit: str  # empty for ratios and counts
    first: float | None
    second: float | None

    @property
    def change(self) -> float | None:
        """The second minus the first, in the unit; None where one is missing."""
        if self.first is None or self.second is None:
            return None
        return self.second - self.first

    @property
    def relative(self) -> float | None:
        """The change over the first; None where there is none, or the first is 0."""
        return None if self.change is None or not self.first else self.change / abs(self.first)

    @property
    def better(self) -> Literal["first", "second", "same"] | None:
        """Which run has the better figure; None where that cannot be said."""
        if self.change == 0.0:
            return "same"
        judged = any(word in self.figure for word in _LESS_IS_BETTER)
        if self.change is None or self.group == MESSAGES or not judged:
            return None
        return "second" if self.change < 0.0 else "first"


@dataclass(frozen=True, slots=True)
class Comparison:
    """All figures of two runs.

    Attributes:
        names: what to call the runs.
        setup: scenario, mode and seed of both, as text, by key.
        differences: the figures of the run first, then phase by phase, then the messages.
    """

    names: tuple[str, str]
    setup: dict[str, tuple[str, str]]
    differences: tuple[Difference, ...]

    def to_json(self) -> str:
        """Return the text of ``comparison.json``; it never holds NaN."""
        content = {
            "names": self.names,
            "setup": self.setup,
            "differences": [
                asdict(entry)
                | {"change": entry.change, "relative": entry.relative, "better": entry.better}
                for entry in self.differences
            ],
        }
        return json.dumps(content, indent=2, allow_nan=False, ensure_ascii=False) + "\n"


def compare_metrics(
    first: Metrics, second: Metrics, names: tuple[str, str] = ("first", "second")
) -> Comparison:
    """Return the differences of two runs; phases are paired by their stacks, in order."""
    one, other = asdict(first), asdict(second)
    setup = {key: (str(one.pop(key)), str(other.pop(key))) for key in _SETUP}
    for key in _WORDS:
        one.pop(key), other.pop(key)
    doubts = tuple("; ".join(side.doubts + side.gaps) for side in (first, second))
    if any(doubts):
        setup[TROUBLE] = doubts[0] or "nothing", doubts[1] or "nothing"
    messages = (one.pop("messages"), other.pop("messages"))
    for key in ("phases", "sequences"):
        one.pop(key), other.pop(key)
    differences = [*_differences(RUN, one, other)]
    for place, (left, right) in enumerate(paired(first.phases, second.phases), start=1):
        either = left or right
        assert either is not None
        group = f"phase {place}: {either.title}"
        differences += _differences(group, _figures(left), _figures(right))
    for place, (one_of, other_of) in enumerate(
        zip_longest(first.sequences, second.sequences), start=1
    ):
        titles = dict.fromkeys(each.title for each in (one_of, other_of) if each is not None)
        group = f"sequence {place}: {' | '.join(titles)}"
        pair = [{} if each is None else asdict(each) for each in (one_of, other_of)]
        differences += _differences(group, pair[0], pair[1])
    differences += _differences(MESSAGES, *messages)
    return Comparison(names, setup, tuple(differences))


def summary_lines(comparison: Comparison) -> list[str]:
    """Return the figures that differ as lines of plain text, those of messages left out."""
    width = max(21, *(len(name) + 2 for name in comparison.names))
    first, second = comparison.names
    shown = [entry for entry in comparison.differences if entry.group != MESSAGES]
    lines = [
        f"{key}: {one}" if one == other else f"{key}: {one} | {other}"
        for key, (one, other) in comparison.setup.items()
    ]
    lines.append(f"{'':56}{first:>{width}}{second:>{width}}{'change':>12}  better")
    for entry in shown:
        if entry.better == "same" or entry.first == entry.second:
            continue
        name = f"{entry.group}, {entry.figure}"
        name += f" [{entry.unit}]" if entry.unit else ""
        numbers = f"{_text(entry.first):>{width}}{_text(entry.second):>{width}}"
        change = f"{_text(entry.change):>12}"
        lines.append(f"{name:56}{numbers}{change}  {entry.better or ''}".rstrip())
    same = sum(entry.first == entry.second for entry in shown)
    return [*lines, f"{same} of {len(shown)} figures are the same"]


def paired(first: Sequence[P], second: Sequence[P]) -> Iterator[tuple[P | None, P | None]]:
    """Yield the phases of both runs with the same stack together, the others alone, in order."""
    stacks = [phase.stack for phase in first], [phase.stack for phase in second]
    i = j = 0
    for left, right, length in SequenceMatcher(None, *stacks, autojunk=False).get_matching_blocks():
        yield from ((phase, None) for phase in first[i:left])
        yield from ((None, phase) for phase in second[j:right])
        i, j = left + length, right + length
        yield from zip(first[left:i], second[right:j], strict=True)


def _figures(phase: PhaseMetrics | None) -> dict[str, Any]:
    """Return a phase's figures by key; its stack is in its name."""
    words = ("stack", "has_errors", "levels", "tasks")
    if phase is None:
        return {}
    left = {f"level {one.level} residual": one.residual for one in phase.levels}
    for key in ("error_mm", "error_mrad", "peak_error_mm", "peak_error_mrad"):
        left[f"task_{key}"] = {one.task: getattr(one, key) for one in phase.tasks}
    return {k: v for k, v in asdict(phase).items() if k not in words} | left


def _differences(
    group: str, first: Mapping[str, Any], second: Mapping[str, Any]
) -> Iterator[Difference]:
    """Yield the figures of both, in the order of the first."""
    one, other = dict(_flat(first)), dict(_flat(second))
    for key in dict.fromkeys([*one, *other]):
        head, *rest = key
        words = head.split("_")
        unit = _UNITS.get(words[-1], "") if group != MESSAGES else ""
        figure = " ".join(words[:-1] if unit else words) if group != MESSAGES else head
        yield Difference(group, ", ".join([figure, *rest]), unit, one.get(key), other.get(key))


def _flat(tree: Mapping[str, Any]) -> Iterator[tuple[tuple[str, ...], float | None]]:
    """Yield the numbers in nested mappings with their path; a mapping that is None has none."""
    for key, value in tree.items():
        if isinstance(value, Mapping):
            yield from (((key, *path), number) for path, number in _flat(value))
        elif isinstance(value, int | float) and not isinstance(value, bool):
            yield (key,), value


def _text(value: float | None) -> str:
    """Return a number, or that a run has no such figure."""
    return "none" if value is None else f"{value:.4g}"
