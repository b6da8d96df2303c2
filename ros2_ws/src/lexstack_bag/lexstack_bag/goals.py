"""The paper's figures and ours to reach for its task sequence, held against a run."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from lexstack_bag.metrics import Metrics, PerRobot, PhaseMetrics
from lexstack_bag.relations import TITLES

PAPER_SEQUENCE = "transition-sequence"
"""The scenario that repeats the paper's Figs. 5 to 9."""

_RATIO = 2.3  # H, Sec. V-D
_ROUNDING = 1e-4  # of a ratio that meets its limit exactly


@dataclass(frozen=True, slots=True)
class Goal:
    """One line of the table paper | ours."""

    quantity: str
    paper: str
    limit: float
    unit: str
    value: float | None  # None: the run does not show it
    least: bool = False  # whether more is better

    @property
    def reached(self) -> bool | None:
        """Whether the run is within the limit; None where it does not show the quantity."""
        if self.value is None:
            return None
        if self.least:
            return self.value >= self.limit - _ROUNDING
        return self.value <= self.limit + _ROUNDING

    @property
    def goal(self) -> str:
        """The limit in words."""
        sign = "≥" if self.least else "≤"
        return f"{sign} {self.limit:g} {self.unit}".strip() if self.limit else "0"

    @property
    def ours(self) -> str:
        """The value in words."""
        if self.value is None:
            return "–"
        if 0.0 < self.value < 1e-3:
            return f"< 0.001 {self.unit}".strip()
        return f"{self.value:.4g} {self.unit}".strip()


def goals_of(metrics: Metrics) -> tuple[Goal, ...]:
    """Return the goals; (A) is the first phase whose stack has a base task.

    Only the paper's own sequence is held against the paper; of any other run only what must
    hold always: the command within its limits, and never an empty box; and that the sequences of
    the HTMPC, if any, were completed.
    """
    always = (
        Goal(
            "Peak acceleration of the command / limit",
            "smooth by eye" if metrics.scenario == PAPER_SEQUENCE else "–",
            1.0,
            "",
            metrics.peak_acceleration_ratio,
        ),
        Goal("Ticks with an empty box of bounds", "–", 0.0, "", float(metrics.empty_bounds)),
    )
    if metrics.scenario != PAPER_SEQUENCE:
        return (*always, *_of_sequences(metrics))
    after_a = next((phase for phase in metrics.phases if phase.base_error_mm), None)
    last = metrics.phases[-1]
    switches = metrics.phases[1:]
    unfinished = sum(phase.transition_s is None for phase in switches)
    return (
        Goal("End-effector error after (A)", "< 10 mm", 2.0, "mm", _worst_ee(after_a)),
        Goal("Base error after (A)", "< 50 mm", 5.0, "mm", _worst_base(after_a)),
        Goal("Final end-effector error", "< 2 mm", 1.0, "mm", _worst_ee(last)),
        *always,
        Goal(
            f"Switches not adopted, of {len(switches)}",
            "0 of 3",
            0.0,
            "",
            float(unfinished) if switches else None,
        ),
    )


def _of_sequences(metrics: Metrics) -> tuple[Goal, ...]:
    """Return the goals of a run with sequences of tasks."""
    count = sum(sequence.count for sequence in metrics.sequences)
    left = count - sum(sequence.done for sequence in metrics.sequences)
    done = Goal(f"Tasks of sequences not done, of {count}", "0", 0.0, "", float(left))
    ratio = Goal(
        "Time of ST-Arch / time of HT-Arch", "2.3", _RATIO, "", metrics.st_over_ht, least=True
    )
    compared = {sequence.architecture for sequence in metrics.sequences} == {"ht", "st"}
    return ((done, ratio) if compared else (done,)) if metrics.sequences else ()


def _worst_ee(phase: PhaseMetrics | None) -> float | None:
    """Return the larger steady-state error of the end effectors [mm]."""
    return None if phase is None else _worst(phase.ee_error_mm.values())


def _worst_base(phase: PhaseMetrics | None) -> float | None:
    """Return the larger steady-state error of the bases [mm]."""
    errors: PerRobot = (phase.base_error_mm if phase is not None else None) or {}
    return _worst(errors.values())


def _worst(values: Iterable[float | None]) -> float | None:
    """Return the largest of the known values, None without any."""
    return max((value for value in values if value is not None), default=None)


def summary_lines(metrics: Metrics) -> list[str]:
    """Return the goals and phases as lines of plain text."""
    lines = [f"{'':42} {'paper':>14} {'goal':>9} {'ours':>11}"]
    for goal in goals_of(metrics):
        word = {True: "reached", False: "NOT reached", None: "not in this run"}[goal.reached]
        lines.append(f"{goal.quantity:42} {goal.paper:>14} {goal.goal:>9} {goal.ours:>11}  {word}")
    lines.append("")
    lines.append(
        f"{'phase':20} {'start s':>8} {'settled s':>10} {'blend s':>8}"
        f" {'EE mm':>17} {'base mm':>17} {'acc. ratio':>11}"
    )
    lines += [
        f"{phase.stack:20} {phase.start_s:>8.2f} {_text(phase.settled_s):>10}"
        f" {_text(phase.transition_s):>8} {_pair(phase.ee_error_mm):>17}"
        f" {_pair(phase.base_error_mm):>17} {_text(phase.peak_acceleration_ratio, 3):>11}"
        for phase in metrics.phases
    ]
    lines += _sequence_lines(metrics)
    for key, title in TITLES.items():
        values = [(phase.stack, getattr(phase, key)) for phase in metrics.phases]
        told = ", ".join(f"{stack} {_pair(found)}" for stack, found in values if found)
        lines += [f"{title}: {told}"] if told else []
    return lines


def _sequence_lines(metrics: Metrics) -> list[str]:
    """Return the sequences as lines of plain text."""
    if not metrics.sequences:
        return []
    head = f"{'sequence':22} {'begun s':>8} {'done':>9} {'completed in s':>15} {'plans Hz':>9}"
    lines = ["", f"{head} {'solve ms':>9} {'p99 ms':>7}"]
    for one in metrics.sequences:
        solve = metrics.solve_us[f"htmpc, {one.robot}"]
        median, p99 = (None if solve[k] is None else 1e-3 * solve[k] for k in ("median", "p99"))
        lines.append(
            f"{one.title:22} {one.begun_s:>8.2f} {f'{one.done} of {one.count}':>9}"
            f" {_text(one.completion_s):>15} {_text(one.plans_hz, 1):>9} {_text(median):>9}"
            f" {_text(p99):>7}"
        )
    return lines


def _text(value: float | None, digits: int = 2) -> str:
    """Return a number, or a dash."""
    return "–" if value is None else f"{value:.{digits}f}"


def _pair(values: PerRobot | None) -> str:
    """Return the robots' values side by side, of many the largest, or a dash."""
    known = [value for value in (values or {}).values() if value is not None]
    if len(known) > 2:
        return f"at most {max(known):.2f}"
    return " / ".join(_text(value) for value in values.values()) if values else "–"
