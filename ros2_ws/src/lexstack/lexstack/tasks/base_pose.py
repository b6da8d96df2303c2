"""Base pose, T(26) to T(30) with the sign and the gain put right."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from lexstack.compiled import kernel
from lexstack.errors import ConfigurationError, ModelError
from lexstack.options import Positive, build
from lexstack.references import References
from lexstack.robots import Kinematics, Team
from lexstack.robots.spatial import wrap
from lexstack.tasks.unicycle_base import UnicycleBase
from lexstack.types import Curve, LinearTask

KERNEL = "lexstack.tasks.kernel.linear"


@dataclass(frozen=True, slots=True)
class BaseParameters:
    """Parameters of the task ``base``."""

    gain: Positive = 1.0  # lambda [1/s]


class Base:
    """Phi chi -> x_dot_d + lambda (x_d - x*), with the integrated base pose x* and yaw wrapped."""

    def __init__(self, team: Team, robot: int, parameters: BaseParameters) -> None:
        """Make the task of the robot at place ``robot``; raises ModelError where it has no base."""
        if team.robots[robot].differential:
            raise ModelError(f"robot {team.names[robot]}: drives with v and w: see UnicycleBase")
        if not team.robots[robot].has_base:
            raise ModelError(f"robot {team.names[robot]}: has no base, which the task 'base' moves")
        self.name = f"{team.names[robot]}/base"
        self.robots = (robot,)
        self._robot = robot
        base, start = team.robots[robot].base, team.slices[robot].start
        self._columns = slice(start + base.start, start + base.stop)
        self._matrix = np.eye(3, team.n, start)
        self._matrix.setflags(write=False)  # solvers may remember it
        self._gain = parameters.gain
        self._curve = Curve(parameters.gain, (robot,), (team.slices[robot],))

    @classmethod
    def from_config(
        cls, team: Team, robot: int, parameters: dict[str, Any], where: str
    ) -> Base | UnicycleBase:
        """Return the task that a stack file describes; raises ConfigurationError.

        Of a differential base it is ``UnicycleBase``.
        """
        chosen = build(BaseParameters, parameters, where)
        try:
            if team.robots[robot].differential:
                return UnicycleBase(team, robot, chosen.gain)
            return cls(team, robot, chosen)
        except ModelError as error:
            raise ConfigurationError(f"{where.removesuffix(': parameters')}: {error}") from error

    def linearise(self, kinematics: Kinematics, references: References) -> LinearTask:
        """Return 3 rows: x and y [m/s], yaw [rad/s], in the world frame."""
        goal, q_star = references.base[self._robot], kinematics.state.q_star
        fast, target = kernel(KERNEL), np.empty(3)
        if fast is not None and goal.dtype is q_star.dtype is target.dtype:
            fast.towards(goal, q_star, self._columns.start, self._gain, 2, target)
        else:
            error = goal - q_star[self._columns]
            error[2] = wrap(error[2])
            target = self._gain * error
        feed = references.motion.bases.get(self._robot)
        return LinearTask.equality(self.name, self._matrix, target, self._curve, feed)
