"""The MPC in a run: the sequences of its robots, planned every few ticks."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from lexstack.mpc import Architecture, HtmpcConfig, Progress, SequenceRunner, SequenceTask
from lexstack.robots import Team
from lexstack.transition.sources.mpc_plans import HeardPlan
from lexstack.types import RobotState


class RunPlans:
    """The sequences of a run.

    Attributes:
        progress: after the last plan of each robot, by its name.
    """

    def __init__(self, team: Team, every: int) -> None:
        """Plan every so many ticks."""
        self.progress: dict[str, Progress] = {}
        self._team = team
        self._every = every
        self._runners: dict[int, tuple[SequenceRunner, HtmpcConfig]] = {}

    def begin(
        self,
        robot: int,
        tasks: tuple[SequenceTask, ...],
        architecture: Architecture,
        config: HtmpcConfig,
        state: RobotState,
        blend: float,
    ) -> None:
        """Begin a sequence; its first plan comes at the next tick that is due for plans."""
        known = self._runners.get(robot)
        if known is None or known[1] is not config:
            known = SequenceRunner(self._team, robot, config, blend), config
            self._runners[robot] = known
        known[0].begin(tasks, architecture, state)

    def at(self, state: RobotState) -> Iterator[HeardPlan]:
        """Return the plans that arrive before a tick."""
        if state.tick % self._every:
            return
        for robot, (runner, _) in self._runners.items():
            found = self.progress[self._team.names[robot]] = runner.step(state)
            plan = found.plan
            times = plan.step * np.arange(len(plan.v), dtype=np.float64)
            if plan.solved:
                yield HeardPlan(robot, state.tick, times, plan.v)
