"""The report's tables, as HTML."""

from __future__ import annotations

from collections.abc import Sequence

from markupsafe import Markup

from lexstack_bag.figures.figures import Metrics, PerRobot
from lexstack_bag.figures.goals import blend_text, goals_of, settled_text
from lexstack_bag.figures.levels import UNMET
from lexstack_bag.figures.relative_errors import TITLES
from lexstack_bag.report.html import render

_CLASSES = {"reached": "yes", "not reached": "no"}  # of the verdicts; the others: none
_BOLD = Markup("<b>{}</b>")


def goals_table(metrics: Metrics) -> Markup:
    """Return the table paper | ours."""
    rows = [
        [goal.quantity, goal.paper, goal.goal, _BOLD.format(goal.ours), _verdict(goal.verdict)]
        for goal in goals_of(metrics)
    ]
    return table(["", "paper", "goal", "ours", ""], rows, "goals")


def _verdict(text: str) -> Markup:
    """Return a verdict in its colour."""
    kind = _CLASSES.get(text, "none")
    return Markup('<span class="{}">{}</span>').format(kind, text)


def phases_table(metrics: Metrics) -> Markup:
    """Return the figures of every phase, with the errors of each robot."""
    robots = tuple(metrics.phases[0].ee_error_mm)
    head = ["stack", "start [s]", "settled after [s]", "blend [s]"]
    head += [f"EE {name} [mm]" for name in robots]
    head += [f"EE peak {name} [mm]" for name in robots]
    head += [f"base {name} [mm]" for name in robots]
    head += ["acceleration / limit"]
    more = [key for key in TITLES if any(getattr(phase, key) for phase in metrics.phases)]
    head += [f"{name}, {TITLES[key]}" for key in more for name in robots]
    rows = []
    for phase in metrics.phases:
        row = [_BOLD.format(phase.title), f"{phase.start_s:.2f}"]
        row += [settled_text(phase), blend_text(phase)]
        row += _numbers(phase.ee_error_mm, robots, 3)
        row += _numbers(phase.ee_peak_error_mm, robots, 2)
        row += _numbers(phase.base_error_mm, robots, 2)
        row += [number(phase.peak_acceleration_ratio, 3)]
        for key in more:
            row += _numbers(getattr(phase, key), robots, 2)
        rows.append(row)
    return table(head, rows, "phases")


def levels_table(metrics: Metrics) -> Markup:
    """Return what each task of each phase leaves, and what holds its level back."""
    rows = [
        [
            _BOLD.format(phase.title),
            f"{level.level}",
            task,
            "–" if residual is None else f"{residual:.2e}",
            ", ".join(level.held_by) if residual is not None and residual > UNMET else "",
        ]
        for phase in metrics.phases
        for level in phase.levels
        for task, residual in level.residual.items()
    ]
    head = ["stack", "level", "task", "residual [m/s, rad/s]", "held back by"]
    return table(head, rows, "levels")


def tasks_table(metrics: Metrics) -> Markup:
    """Return the errors of tasks that have no columns among the phases; empty without any."""
    rows = [
        [
            _BOLD.format(phase.title),
            one.task,
            *(number(x, 3) for x in (one.error_mm, one.error_mrad)),
            *(number(x, 2) for x in (one.peak_error_mm, one.peak_error_mrad)),
        ]
        for phase in metrics.phases
        for one in phase.tasks
    ]
    head = ["stack", "task", "error [mm]", "[mrad]", "peak [mm]", "[mrad]"]
    return table(head, rows, "tasks") if rows else Markup()


def run_table(metrics: Metrics) -> Markup:
    """Return the counts of the whole run."""
    rows = [
        ["Ticks", f"{metrics.ticks}"],
        ["Late ticks (realtime only)", f"{metrics.late_ticks}"],
        ["Ticks without a command in time", f"{metrics.missing_ticks}"],
        ["Ticks in which the plant held the last command", f"{metrics.holding_ticks}"],
        ["Ticks in which the plant braked", f"{metrics.braking_ticks}"],
        ["Ticks whose state is not in the bag", f"{metrics.states_not_in_bag}"],
        ["Ticks whose command is not in the bag", f"{metrics.commands_not_in_bag}"],
        ["Solutions that failed or fell back", f"{metrics.solver_failures}"],
        ["Ticks damped near a singularity", f"{100.0 * metrics.damped_share:.1f} %"],
        ["Peak jerk / limit", number(metrics.peak_jerk_ratio, 3)],
        ["Messages recorded", f"{sum(metrics.messages.values())}"],
        ["Messages lost by the recorder", f"{metrics.recorder_lost}"],
    ]
    for name, times in metrics.solve_us.items():
        text = f"{number(times['median'], 0)} / {number(times['p99'], 0)} µs"
        rows.append([f"Solve time of {name}, median / p99", text])
    return table(["", ""], rows, "run")


def messages_table(metrics: Metrics) -> Markup:
    """Return the number of messages of every topic."""
    rows = [[Markup("<code>{}</code>").format(k), f"{v}"] for k, v in metrics.messages.items()]
    return table(["topic", "messages"], rows, "messages")


def number(value: float | None, digits: int) -> str:
    """Return a number, or a dash."""
    return "–" if value is None else f"{value:.{digits}f}"


def _numbers(values: PerRobot | None, robots: Sequence[str], digits: int) -> list[str]:
    """Return one cell per robot."""
    return [number((values or {}).get(name), digits) for name in robots]


def table(head: Sequence[str], rows: Sequence[Sequence[str]], kind: str) -> Markup:
    """Return a table; cells are plain text, or Markup."""
    return render("table.html", head=head, rows=rows, kind=kind)
