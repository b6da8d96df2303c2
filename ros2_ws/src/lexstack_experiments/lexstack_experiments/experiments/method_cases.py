"""The cases on which transition methods are compared: what happens, and which rows it makes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from lexstack.control import Link
from lexstack.references import Target
from lexstack.robots import Pose
from lexstack.transition import quintic
from lexstack.types import Vector
from lexstack_config.parts import build_team, home_of
from lexstack_config.resolved import ResolvedScenario
from lexstack_config.scenario import EventConfig
from lexstack_experiments.links import Delayed, Frozen, Lost
from lexstack_experiments.runs import changed, scenario_of

Stream = Callable[[float], list[Target]]
"""The references that are sent at a time [s]."""

_STRETCHED = (0.0, 0.0, 0.0, -0.07, 0.0, 1.5708, 0.7854)  # rad, the elbow at its limit
_PAPER = ("posture_mid_range", "reach_base", "track")  # T's stacks: all have level 1 in common
_HEARD = 0.15  # s, how old solver's chi may be where it is late


@dataclass(frozen=True, slots=True)
class Row:
    """A part of a case that makes a row of the table.

    Attributes:
        name: of the row.
        start: s, the first switch in it.
        end: s, not part of it.
        steps: whether the references of level 1 jump at ``start``.
    """

    name: str
    start: float
    end: float
    steps: bool = False


def _direct() -> Link:
    """Return a link on which nothing happens to the solver's messages."""
    return lambda sample: sample


def _silent(_time: float) -> list[Target]:
    """Return no references."""
    return []


@dataclass(frozen=True, slots=True)
class Case:
    """One closed loop.

    Attributes:
        about: what happens, in words.
        resolved: the scenario with its switches.
        rows: what is looked at.
        link: makes what becomes of the solver's messages.
        stream: references sent at every tick.
    """

    about: str
    resolved: ResolvedScenario
    rows: tuple[Row, ...]
    link: Callable[[], Link] = _direct
    stream: Stream = _silent


def cases(config: Path, seed: int) -> list[Case]:
    """Return all cases; the seed draws the order of stacks in the pre-emption."""
    resolved = scenario_of(config)
    one = _switches(resolved, 10.0, (1.0, "reach_base"))
    late = changed(
        one, mode="realtime", timeouts=replace(one.scenario.timeouts, source_stale=_HEARD)
    )
    mid = round((1.0 + 0.5 * resolved.scenario.transition.duration) * resolved.scenario.rate)

    def delayed(ticks: int) -> Case:
        row = Row(f"solver {round(1e3 * ticks / resolved.scenario.rate)} ms late", 1.0, 10.0)
        return Case("switch (A), the solver's chi comes late", late, (row,), lambda: Delayed(ticks))

    return [
        _sequence(resolved),
        _moving(resolved),
        _preempted(resolved, seed),
        delayed(2),
        delayed(10),
        Case(
            "the solver falls silent in mid-blend",
            one,
            (Row("solver lost", 1.0, 10.0),),
            lambda: Lost(mid),
        ),
        Case(
            "from mid-blend on the solver repeats its last chi as if it were new",
            one,
            (Row("solver frozen", 1.0, 10.0),),
            lambda: Frozen(mid),
        ),
        _stretched(resolved, "reach_base"),
        _stretched(resolved, "posture_mid_range"),
        Case(
            "the new stack's position limits exclude where the joints are",
            _switches(resolved, 8.0, (1.0, "confined")),
            (Row("sudden limits", 1.0, 8.0),),
        ),
    ]


def _sequence(resolved: ResolvedScenario) -> Case:
    """Return the paper's sequence, one row per switch."""
    first, second, third = (event.at for event in resolved.scenario.events)
    rows = (
        Row("(A) track to base", first, second),
        Row("(B) base to posture", second, third),
        Row("(C) posture to track", third, resolved.scenario.duration, steps=True),
    )
    return Case("the paper's sequence", resolved, rows)


def _moving(resolved: ResolvedScenario) -> Case:
    """Return switches in mid-motion, while both tools' references run along a figure of eight."""
    tools = _tools(resolved)

    def stream(time: float) -> list[Target]:
        turn = 2.0 * np.pi / 5.0 * _ramped(time, 1.0)
        offset = np.array([0.12 * np.sin(turn), 0.0, 0.08 * np.sin(2.0 * turn)])
        return _moved(tools, offset, time)

    switches = _switches(resolved, 13.0, (3.0, "reach_base"), (8.0, "posture_mid_range"))
    about = "both tools move at up to 0.25 m/s"
    return Case(about, switches, (Row("tools moving", 3.0, 13.0),), stream=stream)


def _preempted(resolved: ResolvedScenario, seed: int) -> Case:
    """Return a switch every 0.4 s for 4 s, each before the last one has ended, then base."""
    rng = np.random.default_rng(seed)
    names = ["reach_base"]
    for _ in range(9):
        names.append(str(rng.choice([n for n in _PAPER if n != names[-1]])))
    if names[-1] == "reach_base":
        names[-1] = "track" if names[-2] != "track" else "posture_mid_range"
    times = [round(1.0 + 0.4 * i, 6) for i in range(len(names) + 1)]
    switches = _switches(resolved, 14.0, *zip(times, [*names, "reach_base"], strict=True))
    return Case("a new switch every 0.4 s", switches, (Row("pre-empted", 1.0, 14.0),))


def _stretched(resolved: ResolvedScenario, stack: str) -> Case:
    """Return a switch to a stack while both arms come down from full stretch upwards."""
    robots = {
        name: replace(robot, arm=replace(robot.arm, home=_STRETCHED))
        for name, robot in resolved.robots.items()
    }
    start = _switches(replace(resolved, robots=robots), 10.0, (1.0, stack))
    tools = _tools(start)

    def stream(time: float) -> list[Target]:
        down = 0.5 * quintic(min(max((time - 0.5) / 3.0, 0.0), 1.0))
        return _moved(tools, np.array([0.0, 0.0, -down]), time)

    about = f"both arms start stretched upwards, the tools come down by 0.5 m, switch to {stack}"
    row = Row(f"singular, {stack.removesuffix('_mid_range')}", 1.0, 10.0)
    return Case(about, start, (row,), stream=stream)


def _switches(
    resolved: ResolvedScenario, duration: float, *switches: tuple[float, str]
) -> ResolvedScenario:
    """Return the scenario with these switches (time [s], stack) and nothing else happening."""
    events = tuple(EventConfig(at=time, switch=stack) for time, stack in switches)
    return changed(resolved, events=events, duration=duration)


def _tools(resolved: ResolvedScenario) -> tuple[Pose, ...]:
    """Return where the tools start."""
    team = build_team(resolved)
    return team.tools(home_of(team, resolved))


def _moved(tools: tuple[Pose, ...], offset: Vector, time: float) -> list[Target]:
    """Return the tools' references moved by ``offset`` [m], from ``time`` [s] on."""
    return [
        Target(time, robot, ee=Pose(tool.position + offset, tool.rotation))
        for robot, tool in enumerate(tools)
    ]


def _ramped(time: float, ramp: float) -> float:
    """Return the integral of a speed that rises smoothly from 0 to 1 within ``ramp`` [s]."""
    s = min(time / ramp, 1.0)
    return ramp * s * s * s * (1.0 - 0.5 * s) + max(time - ramp, 0.0)
