"""Plans of the HTMPC, sampled at the controller's ticks: they enter like the solver's chi."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from lexstack.robots import Team
from lexstack.transition.options import TransitionOptions
from lexstack.types import Matrix, Vector

_ROUNDING = 1e-9  # s


@dataclass(frozen=True, slots=True, eq=False)
class HeardPlan:
    """One horizon of one robot.

    Attributes:
        robot: its place in the team.
        tick: of the state that it starts from.
        times: after that state, from 0 on, increasing, shape (m,), s.
        velocities: at these times, shape (m, n of the robot), m/s and rad/s, world frame.
    """

    robot: int
    tick: int
    times: Vector
    velocities: Matrix

    def at(self, elapsed: float) -> Vector | None:
        """Return the velocity after ``elapsed`` seconds, shape (n,); None where the plan has ended.

        Linear in between: the plan's accelerations are constant from time to time.
        """
        times = self.times
        if not times[0] - _ROUNDING <= elapsed <= times[-1] + _ROUNDING:
            return None
        i = int(np.clip(np.searchsorted(times, elapsed, side="right"), 1, len(times) - 1))
        share = min(max((elapsed - times[i - 1]) / (times[i] - times[i - 1]), 0.0), 1.0)
        before, after = self.velocities[i - 1], self.velocities[i]
        return np.asarray(before + share * (after - before))


class MpcPlans:
    """The newest plan of every robot."""

    def __init__(self, team: Team, options: TransitionOptions) -> None:
        """Take from the options how often a plan comes, and when one is too old."""
        self._team = team
        self._dt = team.dt
        self._every = options.plan_every
        self._lockstep = options.lockstep
        self._stale = options.plan_stale
        self._plans: dict[int, HeardPlan] = {}

    def hear(self, plan: HeardPlan) -> None:
        """Take a plan, unless a newer one is there."""
        known = self._plans.get(plan.robot)
        if known is None or plan.tick >= known.tick:
            self._plans[plan.robot] = plan

    def sample(self, robots: Iterable[int], tick: int) -> Vector | None:
        """Return the chi of a tick, shape (n,), 0 for other robots; None without fresh plans.

        It is the velocity at the end of the tick: the next plan starts from there. In lockstep
        only the plan that is due counts, so that a run can be repeated to the bit.
        """
        oldest = tick - (tick % self._every if self._lockstep else self._stale)
        chi = np.zeros(self._team.n)
        for robot in robots:
            plan = self._plans.get(robot)
            if plan is None or not oldest <= plan.tick <= tick:
                return None
            velocity = plan.at((tick + 1 - plan.tick) * self._dt)
            if velocity is None:
                return None
            chi[self._team.slices[robot]] = velocity
        return chi
