"""A case under one method: the closed loop, and the figures of its rows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lexstack.robots import Team
from lexstack.transition import Source
from lexstack.types import Vector
from lexstack_config.parts import build_team
from lexstack_experiments.experiments.method_cases import Case, Row
from lexstack_experiments.ideal import IdealPlant
from lexstack_experiments.loop import Loop
from lexstack_experiments.oracle import level_excess
from lexstack_experiments.probes import counting_controller
from lexstack_experiments.runs import analysed, with_method

Mask = NDArray[np.bool_]
_AFTER = 0.5  # s


@dataclass(frozen=True, slots=True)
class MethodFigures:
    """The figures of one row under one method.

    The first four are peaks from a switch until ``_AFTER`` after its blend, all later switches of
    the row included: what comes then is the stack's own motion.

    Attributes:
        base: peak acceleration of a base along x or y [m/s^2].
        arm: peak acceleration of an arm joint [rad/s^2].
        acceleration: peak acceleration over the joint's limit.
        jerk: peak jerk over the joint's limit.
        ee_rms: distance of the tools from where they are without any switch [mm], or None where
            the references of level 1 jump.
        ee_peak: its largest value [mm], or None.
        excess: level 1's residual beyond the oracle's in the same box [m/s, rad/s], largest over
            the ticks at which level 1 goes on as it was.
        stepped: the same over the blend of a switch at which level 1's references jump, or None.
        empty: ticks with an empty box.
        settled: from the last switch until all errors stay in their band [s], or None.
        qps: levels that the controller solved per tick of a blend, mean; None without a blend.
        median: wall time of a tick of a blend [us]; None without a blend.
        p99: the same, 99th percentile.
    """

    base: float
    arm: float
    acceleration: float
    jerk: float
    ee_rms: float | None
    ee_peak: float | None
    excess: float
    stepped: float | None
    empty: int
    settled: float | None
    qps: float | None
    median: float | None
    p99: float | None


Rows = dict[str, dict[str, MethodFigures]]
"""Figures by row and method."""


class Play:
    """A case played with one method in the ideal plant."""

    def __init__(self, case: Case, method: str) -> None:
        """Run the whole case."""
        resolved = with_method(case.resolved, method)
        controller, tally = counting_controller(resolved)
        team = build_team(resolved)
        self.loop = Loop(resolved, IdealPlant(resolved, team), controller)
        self.loop.link = case.link()
        levels = [0]
        for tick in range(round(resolved.scenario.duration * resolved.scenario.rate)):
            for target in case.stream(tick / resolved.scenario.rate):
                self.loop.add_target(target)
            self.loop.step()
            levels.append(tally.levels)
        self.qps: Vector = np.diff(levels).astype(np.float64)
        self.measured = analysed(self.loop)

    def figures(self, row: Row, still: Play) -> MethodFigures:
        """Return a row's figures; ``still`` is the same case without any switch."""
        time_series, team = self.measured.time_series, self.loop.parts.team
        ticks = self._between(row.start, row.end)
        blend = ticks & self._blending()
        moved = ticks & _longer(blend, _AFTER * self.loop.resolved.scenario.rate)
        ratios = time_series.acceleration_ratio[moved if moved.any() else ticks]
        jerks = time_series.jerk_ratio[moved if moved.any() else ticks]
        rates = ratios * team.limits.acceleration
        times = 1e6 * self.measured.run.chi["robot_a"].solve_time[blend]
        any_blend = bool(blend.any())
        excess, stepped = self._excess(row)
        away = 1e3 * np.linalg.norm(time_series.ee - still.measured.time_series.ee, axis=2)[ticks]
        return MethodFigures(
            base=float(rates[:, _joints(team, slice(0, 2))].max()),
            arm=float(rates[:, _joints(team, slice(3, None))].max()),
            acceleration=float(ratios.max()),
            jerk=float(jerks.max()),
            ee_rms=None if row.steps else float(np.sqrt(np.mean(away**2))),
            ee_peak=None if row.steps else float(away.max()),
            excess=excess,
            stepped=stepped,
            empty=self._empty(ticks),
            settled=self._settled(row),
            qps=float(np.mean(self.qps[blend])) if any_blend else None,
            median=float(np.median(times)) if any_blend else None,
            p99=float(np.percentile(times, 99)) if any_blend else None,
        )

    def _excess(self, row: Row) -> tuple[float, float | None]:
        """Return the largest excess while level 1 goes on, and while it is led to a new place."""
        ticks = self._between(row.start, row.end)
        duration = self.loop.resolved.scenario.transition.duration
        if not row.steps:
            return self._largest_excess(ticks), None
        led = self._between(row.start, row.start + duration)
        return self._largest_excess(ticks & ~led), self._largest_excess(led)

    def _largest_excess(self, ticks: Mask) -> float:
        """Return the largest excess of level 1 over the oracle at some ticks, 0 without any."""
        record, parts = self.loop.record, self.loop.parts
        worst = 0.0
        for k in np.flatnonzero(ticks):
            command = record.commands[k]
            kinematics = parts.team.kinematics(record.states[k])
            level = parts.stacks[command.stack].levels[0]
            tasks = level.linearise(kinematics, record.references[k])
            worst = max(worst, level_excess(tasks, command.chi, command.bounds))
        return worst

    def _settled(self, row: Row) -> float | None:
        """Return when the row's last switch has settled, counted from its trigger [s]."""
        inside = [p for p in self.measured.metrics.phases if row.start <= p.start_s < row.end]
        return inside[-1].settled_s if inside else None

    def _between(self, start: float, end: float) -> Mask:
        """Return which ticks lie in [start, end) [s]."""
        time, slack = self.measured.time_series.time, 1e-6
        return np.asarray((time >= start - slack) & (time < end - slack))

    def _blending(self) -> Mask:
        """Return at which ticks the controller follows a source."""
        commands = self.loop.record.commands
        return np.array([c.transition.source is not Source.NONE for c in commands])

    def _empty(self, ticks: Mask) -> int:
        """Return how many ticks have an empty box."""
        commands = self.loop.record.commands
        return sum(commands[k].bounds.empty > 0 for k in np.flatnonzero(ticks))


def _longer(mask: Mask, ticks: float) -> Mask:
    """Return a mask whose stretches end ``ticks`` later."""
    kernel = np.ones(round(ticks) + 1)
    return np.asarray(np.convolve(mask, kernel)[: mask.size] > 0.5)


def _joints(team: Team, part: slice) -> list[int]:
    """Return the same part of each robot's joints."""
    return [i for robot in team.slices for i in range(robot.start, robot.stop)[part]]
