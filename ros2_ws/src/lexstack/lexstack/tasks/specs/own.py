"""A task that a program writes itself: a function from the configuration to rows on chi."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from lexstack.errors import InputError
from lexstack.references import References
from lexstack.robots import Configuration, Kinematics, Team
from lexstack.types import LinearTask, Matrix, Vector

Rows = Callable[[Configuration], tuple[Matrix, Vector] | tuple[Matrix, Vector, Vector]]
"""Returns the Jacobian J (m, n_robot), and the velocity that is asked for (m,): J chi -> b; or its
lower and its upper end: lower <= J chi <= upper."""


@dataclass(frozen=True, eq=False)
class OwnTask:
    """A task of one's own: ``rows`` is called at every tick, with its robot's configuration.

    pink, mink and placo: a subclass of ``Task`` with an error and a Jacobian.

    Attributes:
        name: unique within a stack.
        rows: from a configuration to (J, b) or (J, lower, upper); J has the robot's columns of chi.
        robot: name of the robot that it is about; empty: one such task for every robot.
        weight: of its squared residual within its level.
    """

    name: str
    rows: Rows
    robot: str = ""
    weight: float = 1.0

    @property
    def label(self) -> str:
        """What errors call it."""
        return f"OwnTask({self.name!r})"


class RowsTask:
    """An own task of one robot of a team."""

    def __init__(self, team: Team, robot: int, spec: OwnTask) -> None:
        """Make the task of the robot at place ``robot``."""
        self.name = f"{team.names[robot]}/{spec.name}"
        self.robots = (robot,)
        self._spec = spec
        self._team = team
        one = len(team.robots) == 1
        self._alone = team if one else Team((team.robots[robot],), team.dt, team.obstacles)

    def linearise(self, kinematics: Kinematics, references: References) -> LinearTask:
        """Return its rows; raises InputError where their shapes do not fit."""
        part = self._team.slices[self.robots[0]]
        found = self._spec.rows(Configuration(self._alone, self._own(kinematics)))
        jacobian, *ends = (np.atleast_1d(np.asarray(each, dtype=np.float64)) for each in found)
        jacobian = np.atleast_2d(jacobian)
        m, columns = len(jacobian), part.stop - part.start
        if jacobian.shape != (m, columns) or any(end.shape != (m,) for end in ends):
            got = ", ".join(str(each.shape) for each in (jacobian, *ends))
            raise InputError(
                f"{self._spec.label}: rows: expected shapes (m, {columns}), (m,), got {got}"
            )
        matrix = np.zeros((m, self._team.n))
        matrix[:, part] = jacobian
        return LinearTask(self.name, matrix, ends[0], ends[-1])

    def _own(self, kinematics: Kinematics) -> Kinematics:
        """Return the kinematics of its robot alone."""
        if self._alone is self._team:
            return kinematics
        (robot,) = self.robots
        state, part, place = kinematics.state, self._team.slices[robot], self._team.q_slices[robot]
        own = replace(
            state,
            q=state.q[place],
            v=state.v[part],
            q_star=state.q_star[place],
            command=state.command[part],
        )
        return self._alone.kinematics(own)
