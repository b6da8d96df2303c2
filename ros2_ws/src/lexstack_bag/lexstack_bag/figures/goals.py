"""The paper's figures and ours to reach for its task sequence, held against a run."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

from lexstack_bag.figures.figures import Metrics, PerRobot, PhaseMetrics
from lexstack_bag.figures.relative_errors import TITLES

Verdict = Literal["reached", "not reached", "not judged", "not in this run"]

PAPER_SEQUENCE = "transition-sequence"
"""The scenario that repeats the paper's Figs. 5 to 9."""

_RESTING = "velocity_damping"  # ends the name of such a task
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
    doubts: tuple[str, ...] = ()  # why it cannot be called reached, even within the limit

    @property
    def reached(self) -> bool | None:
        """Whether the run is within the limit; None where it does not show that beyond doubt."""
        if self.value is None:
            return None
        if self.least:
            within = self.value >= self.limit - _ROUNDING
        else:
            within = self.value <= self.limit + _ROUNDING
        return None if within and self.doubts else within

    @property
    def verdict(self) -> Verdict:
        """The same in words."""
        if self.value is None:
            return "not in this run"
        if self.reached is None:
            return "not judged"
        return "reached" if self.reached else "not reached"

    @property
    def goal(self) -> str:
        """The limit in words."""
        sign = "≥" if self.least else "≤"
        return f"{sign} {self.limit:g} {self.unit}".strip() if self.limit else "0"

    @property
    def ours(self) -> str:
        """The value in words."""
        if self.value is None:
            return "none"
        if 0.0 < self.value < 1e-3:
            return f"< 0.001 {self.unit}".strip()
        return f"{self.value:.4g} {self.unit}".strip()


def goals_of(metrics: Metrics) -> tuple[Goal, ...]:
    """Return the goals; (A) is the first phase whose stack has a base task.

    Only the paper's own sequence is held against the paper; of any other run only what must
    hold always: the command within its limits, and never an empty box; and that the sequences of
    the HTMPC, if any, were completed. No goal is reached in a run that braked, lost ticks or was
    reset; nor one about every tick where the bag does not have every command.
    """
    missing = metrics.gaps if metrics.commands_not_in_bag else ()
    every_tick = _every_tick(metrics)
    return tuple(
        replace(goal, doubts=metrics.doubts + (missing if goal in every_tick else ()))
        for goal in _all_goals(metrics, every_tick)
    )


def _every_tick(metrics: Metrics) -> tuple[Goal, ...]:
    """Return the goals about every tick of a run."""
    return (
        Goal(
            "Peak acceleration of the command / limit",
            "smooth by eye" if metrics.scenario == PAPER_SEQUENCE else "–",
            1.0,
            "",
            metrics.peak_acceleration_ratio,
        ),
        Goal("Ticks with an empty box of bounds", "–", 0.0, "", float(metrics.empty_bounds)),
    )


def _all_goals(metrics: Metrics, always: tuple[Goal, ...]) -> tuple[Goal, ...]:
    """Return the goals of a run, ``always`` among them."""
    if metrics.scenario != PAPER_SEQUENCE:
        return (*always, *_of_sequences(metrics))
    after_a = next((phase for phase in metrics.phases if phase.base_error_mm), None)
    ee, base = (after_a.ee_error_mm, after_a.base_error_mm) if after_a else (None, None)
    last = metrics.phases[-1]
    switches = metrics.phases[1:]
    cancelled = sum(phase.outcome == "cancelled" for phase in switches)
    unfinished = sum(phase.transition_s is None for phase in switches) - cancelled
    told = f" ({cancelled} cancelled on request)" if cancelled else ""
    return (
        Goal("End-effector error after (A)", "< 10 mm", 2.0, "mm", _worst(ee)),
        Goal("Base error after (A)", "< 50 mm", 5.0, "mm", _worst(base)),
        Goal("Final end-effector error", "< 2 mm", 1.0, "mm", _worst(last.ee_error_mm)),
        *always,
        Goal(
            f"Switches not adopted, of {len(switches)}{told}",
            "0 of 3",
            0.0,
            "",
            float(unfinished) if switches else None,
        ),
    )


def _of_sequences(metrics: Metrics) -> tuple[Goal, ...]:
    """Return the goals of a run with sequences of tasks."""
    count = sum(sequence.count for sequence in metrics.sequences)
    kept = [sequence for sequence in metrics.sequences if not sequence.cancelled]
    left = sum(sequence.count - sequence.done for sequence in kept)
    cancelled = len(metrics.sequences) - len(kept)
    told = f" ({cancelled} cancelled on request)" if cancelled else ""
    done = Goal(f"Tasks of sequences not done, of {count}{told}", "0", 0.0, "", float(left))
    ratio = Goal(
        "Time of ST-Arch / time of HT-Arch", "2.3", _RATIO, "", metrics.st_over_ht, least=True
    )
    compared = {sequence.architecture for sequence in metrics.sequences} == {"ht", "st"}
    return ((done, ratio) if compared else (done,)) if metrics.sequences else ()


def _worst(values: PerRobot | None) -> float | None:
    """Return the largest of the robots' known values, None without any."""
    return max((value for value in (values or {}).values() if value is not None), default=None)


def summary_lines(metrics: Metrics) -> list[str]:
    """Return the goals and phases as lines of plain text."""
    lines = [f"{'':42} {'paper':>14} {'goal':>9} {'ours':>11}"]
    for goal in goals_of(metrics):
        word = goal.verdict.replace("not reached", "NOT reached")
        lines.append(f"{goal.quantity:42} {goal.paper:>14} {goal.goal:>9} {goal.ours:>11}  {word}")
    lines += [f"not judged: {doubt}" for doubt in metrics.doubts]
    lines += [f"gap: {gap}" for gap in metrics.gaps]
    names = [phase.title for phase in metrics.phases]
    width = max(16, *(len(name) + 1 for name in names))
    lines.append("")
    lines.append(
        f"{'phase':{width}}{'start s':>9} {'settled s':>11} {'blend s':>11} "
        f"{'EE mm':>20} {'base mm':>20} {'acc. ratio':>11}"
    )
    lines += [
        f"{name:{width}}{phase.start_s:>9.2f} {settled_text(phase):>11} {blend_text(phase):>11} "
        f"{_pair(phase.ee_error_mm):>20} {_pair(phase.base_error_mm):>20} "
        f"{_text(phase.peak_acceleration_ratio, 3):>11}"
        for name, phase in zip(names, metrics.phases, strict=True)
    ]
    lines += [f"level held back: {text}" for text in held_back(metrics)]
    lines += list(metrics.singular)
    lines += _sequence_lines(metrics)
    for key, title in TITLES.items():
        values = [(phase.title, getattr(phase, key)) for phase in metrics.phases]
        told = ", ".join(f"{name} {_pair(found)}" for name, found in values if found)
        lines += [f"{title}: {told}"] if told else []
    lines += [
        f"{phase.title}: {one.task} {_error(one.error_mm, one.error_mrad)}, "
        f"peak {_error(one.peak_error_mm, one.peak_error_mrad)}"
        for phase in metrics.phases
        for one in phase.tasks
    ]
    return lines


def _error(linear: float | None, angular: float | None) -> str:
    """Return an error with its units, or a dash."""
    known = [(linear, "mm"), (angular, "mrad")]
    return ", ".join(f"{value:.2f} {unit}" for value, unit in known if value is not None) or "–"


def settled_text(phase: PhaseMetrics) -> str:
    """Return when a phase had settled [s], or why there is no such time."""
    if phase.settled_s is not None:
        return f"{phase.settled_s:.2f}"
    return "never" if phase.has_errors else "–"


def blend_text(phase: PhaseMetrics) -> str:
    """Return how long a switch took [s], or what became of it; a dash: no switch."""
    return f"{phase.transition_s:.2f}" if phase.transition_s is not None else phase.outcome or "–"


def held_back(metrics: Metrics) -> list[str]:
    """Return which level is held back at the end of which phase, and by what.

    Levels that only ask for little velocity are left out: those above them move, so they always
    are.
    """
    return [
        f"{phase.title}: level {level.level} ({', '.join(level.residual)}) by "
        f"{', '.join(level.held_by)}"
        for phase in metrics.phases
        for level in phase.levels
        if level.held_by and not all(task.endswith(_RESTING) for task in level.residual)
    ]


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
