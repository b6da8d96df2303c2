"""What every task is: a name, and a linearisation at the present state."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

from lexstack.references import References
from lexstack.robots import Kinematics, Team
from lexstack.types import LinearTask


class Task(Protocol):
    """One objective on chi, for one robot of a team or for several at once."""

    @property
    def name(self) -> str:
        """Name, unique within a stack, e.g. ``robot_a/ee_pose``."""
        ...

    @property
    def robots(self) -> tuple[int, ...]:
        """Places in the team of the robots whose joints it moves: more than one are coupled."""
        ...

    def linearise(self, kinematics: Kinematics, references: References) -> LinearTask:
        """Return the rows of this task at the present state, A of shape (m, n)."""
        ...


# (team, robot's place in it, parameters of the stack file, where they stand) -> task
TaskFactory = Callable[[Team, int, dict[str, Any], str], Task]
"""Makes the task of one robot: team, place of the robot in it, parameters, origin for errors."""
