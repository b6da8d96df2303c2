"""Centre of mass of a robot at a point of the world.

    S J_c chi -> S sat(gain (c_d - c))

with S the axes that are kept. pink and mink: ``ComTask``; placo: ``CoMTask``. The rows have no
``Curve``: near a singularity the level is not damped for their sake.
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
from lexstack.types import LinearTask


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
        self._columns = team.slices[robot]
        self._place = team.q_slices[robot]
        self._n = team.n
        self._parameters = parameters
        self._rows = list(kept_rows(parameters.mask))
        self._target = np.array(parameters.target)

    @classmethod
    def from_config(
        cls, team: Team, robot: int, parameters: dict[str, Any], where: str
    ) -> CentreOfMass:
        """Return the task that a stack file describes; raises ConfigurationError."""
        return cls(team, robot, build(CentreOfMassParameters, parameters, where), where)

    def linearise(self, kinematics: Kinematics, references: References) -> LinearTask:
        """Return a row for each axis that is kept [m/s], axes of the world."""
        centre, jacobian = self._model.centre_of_mass(kinematics.state.q[self._place])
        error = (self._target - centre)[self._rows]
        matrix = np.zeros((len(self._rows), self._n))
        matrix[:, self._columns] = jacobian[self._rows]
        target = saturated(self._parameters.gain * error, self._parameters.max_linear)
        return LinearTask.equality(self.name, matrix, target)
