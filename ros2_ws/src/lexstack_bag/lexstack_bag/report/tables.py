"""The report's tables, as HTML."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from lexstack_bag.goals import goals_of
from lexstack_bag.metrics import Metrics, PerRobot
from lexstack_bag.relations import TITLES

_WORDS = {
    True: '<span class="yes">reached</span>',
    False: '<span class="no">not reached</span>',
    None: '<span class="none">not in this run</span>',
}


def goals_table(metrics: Metrics) -> str:
    """Return the table paper | ours."""
    rows = [
        [
            escape(goal.quantity),
            escape(goal.paper),
            goal.goal,
            f"<b>{escape(goal.ours)}</b>",
            _WORDS[goal.reached],
        ]
        for goal in goals_of(metrics)
    ]
    return table(["", "paper", "goal", "ours", ""], rows, "goals")


def phases_table(metrics: Metrics) -> str:
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
        row = [f"<b>{escape(phase.stack)}</b>", f"{phase.start_s:.2f}"]
        row += [number(phase.settled_s, 2), number(phase.transition_s, 2)]
        row += _numbers(phase.ee_error_mm, robots, 3)
        row += _numbers(phase.ee_peak_error_mm, robots, 2)
        row += _numbers(phase.base_error_mm, robots, 2)
        row += [number(phase.peak_acceleration_ratio, 3)]
        for key in more:
            row += _numbers(getattr(phase, key), robots, 2)
        rows.append(row)
    return table(head, rows, "phases")


def run_table(metrics: Metrics) -> str:
    """Return the counts of the whole run."""
    rows = [
        ["Ticks", f"{metrics.ticks}"],
        ["Late ticks (realtime only)", f"{metrics.late_ticks}"],
        ["Ticks without a command", f"{metrics.missing_ticks}"],
        ["Solutions that failed or fell back", f"{metrics.solver_failures}"],
        ["Ticks damped near a singularity", f"{100.0 * metrics.damped_share:.1f} %"],
        ["Peak jerk / limit", number(metrics.peak_jerk_ratio, 3)],
        ["Messages recorded", f"{sum(metrics.messages.values())}"],
        ["Messages lost by the recorder", f"{metrics.recorder_lost}"],
    ]
    for name, times in metrics.solve_us.items():
        text = f"{number(times['median'], 0)} / {number(times['p99'], 0)} µs"
        rows.append([f"Solve time of {escape(name)}, median / p99", text])
    return table(["", ""], rows, "run")


def messages_table(metrics: Metrics) -> str:
    """Return the number of messages of every topic."""
    rows = [[f"<code>{escape(k)}</code>", f"{v}"] for k, v in metrics.messages.items()]
    return table(["topic", "messages"], rows, "messages")


def number(value: float | None, digits: int) -> str:
    """Return a number, or a dash."""
    return "–" if value is None else f"{value:.{digits}f}"


def _numbers(values: PerRobot | None, robots: Sequence[str], digits: int) -> list[str]:
    """Return one cell per robot."""
    return [number((values or {}).get(name), digits) for name in robots]


def table(head: Sequence[str], rows: Sequence[Sequence[str]], kind: str) -> str:
    """Return a table; cells are HTML."""
    top = "".join(f"<th>{cell}</th>" for cell in head) if any(head) else ""
    body = "".join("<tr>" + "".join(f"<td>{cell}</td>" for cell in row) + "</tr>" for row in rows)
    head_html = f"<thead><tr>{top}</tr></thead>" if top else ""
    return (
        f'<div class="scroll"><table class="{kind}">{head_html}<tbody>{body}</tbody></table></div>'
    )
