"""Centre of mass of a robot at a point of the world.

    S J_c chi -> S sat(gain (c_d - c))

with S the axes that are kept. pink and mink: ``ComTask``; placo: ``CoMTask``. A joint i turns what
it carries as a whole, so that the column of a joint j that it carries turns with it,
d J_c,j / dq_i = w_i x J_c,j, and the columns of other branches do not.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from lexstack.errors import ConfigurationError
from lexstack.options import Finite3, Positive, build
from lexstack.references import References
from lexstack.robots import Kinematics, Team
from lexstack.tasks.frame_pose import saturated
from lexstack.tasks.frame_task import check_mask, kept_rows
from lexstack.types import Curve, FrameRows, LinearTask


@dataclass(frozen=True, slots=True)
class CentreOfMassParameters:
    """Parameters of the task ``centre_of_mass``."""

    target: Finite3  # c_d [m], in the world
    mask: tuple[bool, bool, bool] = (True, True, False)  # x, y, z
    gain: Positive = 1.0  # 1/s
    max_linear: Positive = 0.5  # m/s, saturation of |gain e|

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for a value out of range."""
        check_mask(where, self.mask)


class CentreOfMass:
    """S J_c chi -> S sat(gain (c_d - c)), at the measured configuration."""

    def __init__(
        self, team: Team, robot: int, parameters: CentreOfMassParameters, where: str
    ) -> None:
        """Make the task of the robot at place ``robot``; raises for one without mass."""
        self.name = f"{team.names[robot]}/centre_of_mass"
        self.robots = (robot,)
        self._model = team.robots[robot]
        if not self._model.mass > 0.0:
            raise ConfigurationError(f"{where}: robot {self._model.name!r} has no mass")
        self._columns, self._places = team.slices[robot], team.q_slices[robot]
        self._n = team.n
        self._parameters = parameters
        self._rows = list(kept_rows(parameters.mask))
        self._axes = np.eye(6)[self._rows]
        limits, sizes = (parameters.max_linear,), (len(self._rows),)
        columns = (self._columns,)
        self._curve = Curve(parameters.gain, (robot,), columns, (1.0,), limits, sizes=sizes)
        self._target = np.array(parameters.target)

    @classmethod
    def from_config(
        cls, team: Team, robot: int, parameters: dict[str, Any], where: str
    ) -> CentreOfMass:
        """Return the task that a stack file describes; raises ConfigurationError."""
        return cls(team, robot, build(CentreOfMassParameters, parameters, where), where)

    def linearise(self, kinematics: Kinematics, references: References) -> LinearTask:
        """Return a row for each axis that is kept [m/s], axes of the world."""
        q = kinematics.state.q[self._places]
        centre, motion = self._model.mass_motion(q)
        error = (self._target - centre)[self._rows]
        matrix, tree = np.zeros((len(self._rows), self._n)), self._model.tree_at(q)
        rows = motion[self._rows]
        matrix[:, self._columns] = rows if tree.follows is None else rows @ tree.follows
        target = saturated(self._parameters.gain * error, self._parameters.max_linear)
        frame = FrameRows(self._axes, motion, tree=tree)
        return LinearTask.equality(self.name, matrix, target, self._curve, frame=frame)
