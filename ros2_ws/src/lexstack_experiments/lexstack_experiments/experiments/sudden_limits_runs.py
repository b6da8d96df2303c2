"""A case of sudden limits under one law: the closed loop and its figures."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lexstack.limits import Bounds, BoundsProvider, JointLimits, Motion
from lexstack.types import Matrix, RobotState, Vector
from lexstack_config.parts import Parts, build_controller
from lexstack_experiments.baselines.printed_law import PrintedLaw
from lexstack_experiments.experiments.sudden_limits_cases import STACK, Case, Law
from lexstack_experiments.experiments.sudden_limits_least import KEPT, least_ticks
from lexstack_experiments.ideal import IdealPlant
from lexstack_experiments.loop import Loop
from lexstack_experiments.measuring import after_last


@dataclass(frozen=True, slots=True)
class LimitFigures:
    """The figures of a case under one law.

    Attributes:
        empty: ticks with an empty box.
        acceleration: peak of the command's acceleration over the limit in force.
        jerk: peak of its jerk over the limit in force.
        velocity: peak of the command over the larger of its limit and what it was at the trigger.
        outside: from the trigger until all joints are inside for good [s]; None: never.
        least: what no motion within the limits falls below [s].
        late: ticks by which the joint is late that is later than it must be by most; None: never.
        violation: furthest that a joint is outside when it need not be any more [m, rad].
        away: furthest distance of a tool from where it is without the switch [mm].
    """

    empty: int
    acceleration: float
    jerk: float
    velocity: float
    outside: float | None
    least: float
    late: int | None
    violation: float
    away: float


class Watched:
    """A law that remembers what it said.

    Attributes:
        limits: in force, by tick.
    """

    def __init__(self, law: BoundsProvider) -> None:
        """Watch ``law``."""
        self.law = law
        self.limits: list[JointLimits] = []

    @property
    def dt(self) -> float:
        """The control period [s]."""
        return self.law.dt

    def at(
        self, state: RobotState, wanted: JointLimits, sent: Vector | None, *, jerk: bool
    ) -> tuple[JointLimits, Bounds]:
        """Return what the law says."""
        limits, box = self.law.at(state, wanted, sent, jerk=jerk)
        self.limits.append(limits)
        return limits, box


class Play:
    """A case played under one law.

    Attributes:
        loop: the closed loop, after its run.
        law: what kept the limits.
        new: the limits that were asked for.
        trigger: the tick at which they were.
        end: the tick up to which the case is looked at.
    """

    def __init__(self, case: Case, law: Law) -> None:
        """Run the whole case."""
        resolved = case.resolved
        parts = Parts.of(resolved)
        self.law = Watched(law.make(parts, resolved.scenario.transition.duration))
        controller = build_controller(resolved, parts, box=self.law)
        self.loop = Loop(
            resolved, None if case.mujoco else IdealPlant(resolved, parts.team), controller
        )
        self.loop.run()
        own, asked = parts.team.limits, parts.stacks[STACK].limits
        self.new = own if asked is None else asked
        self.trigger = round(case.start * resolved.scenario.rate)
        self.end = round(case.end * resolved.scenario.rate)
        self._jerk = case.jerk

    @property
    def q(self) -> Matrix:
        """q* of every tick, shape (T, n)."""
        return np.array([state.q_star for state in self.loop.record.states])

    @property
    def chi(self) -> Matrix:
        """The command of every tick, shape (T, n)."""
        return np.array([command.chi for command in self.loop.record.commands])

    def least(self) -> NDArray[np.int64]:
        """Return the least ticks until each joint is inside, shape (n,)."""
        state, dt = self.loop.record.states[self.trigger], self.loop.parts.dt
        before = self.loop.record.states[self.trigger - 1].command
        acceleration = (state.command - before) / dt if self._jerk else None
        return least_ticks(Motion(state.q_star, state.command, dt, acceleration), self.new)

    def outside(self) -> Matrix:
        """Return how far each joint is outside the new limits from the trigger on, (ticks, n)."""
        q = self.q[self.trigger : self.end]
        out = np.maximum(q - self.new.position_upper, self.new.position_lower - q)
        return np.where(out > KEPT, out, 0.0)

    def figures(self, still: Play) -> LimitFigures:
        """Return the figures; ``still`` is the same case without any switch, under our law."""
        dt, out, least = self.loop.parts.dt, self.outside(), self.least()
        taken = np.array([after_last(column) for column in (out > 0.0).T])
        never = bool((out[-1] > 0.0).any())
        ticks = np.arange(len(out))[:, None]
        rates = np.array([limits.acceleration for limits in self.law.limits])
        jerks = np.array([limits.jerk for limits in self.law.limits])
        acceleration = np.diff(self.chi, axis=0, prepend=np.zeros((1, rates.shape[1]))) / dt
        jerk = np.diff(acceleration, axis=0, prepend=np.zeros((1, rates.shape[1]))) / dt
        now = slice(self.trigger, self.end)
        fastest = np.maximum(self.new.velocity, np.abs(self.chi[self.trigger - 1]))
        tools = self._tools() - still._tools()
        return LimitFigures(
            empty=len(self.empty_ticks()),
            acceleration=float((np.abs(acceleration) / rates).max()),
            jerk=float((np.abs(jerk) / jerks)[now].max()),
            velocity=float((np.abs(self.chi[now]) / fastest).max()),
            outside=None if never else float(taken.max() * dt),
            least=float(least.max() * dt),
            late=None if never else int((taken - least).max()),
            violation=float(np.where(ticks >= least, out, 0.0).max()),
            away=float(1e3 * np.linalg.norm(tools[now], axis=2).max()),
        )

    def empty_ticks(self) -> list[int]:
        """Return the ticks with an empty box, as a printed law told or as the box was used."""
        if isinstance(self.law.law, PrintedLaw):
            return self.law.law.empty_ticks
        return [command.tick for command in self.loop.record.commands if command.bounds.empty]

    def _tools(self) -> NDArray[np.float64]:
        """Return where the tools are, (ticks, N, 3) [m]."""
        team = self.loop.parts.team
        states = self.loop.record.states
        return np.array([[pose.position for pose in team.tools(state.q)] for state in states])
