"""Poses and Jacobians of all robots at one state."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from lexstack.robots.collision_geometry import Spheres
from lexstack.types import Matrix, RobotState, Vector


@dataclass(frozen=True, slots=True)
class Pose:
    """A pose in the world frame.

    Attributes:
        position: shape (3,), m.
        rotation: shape (3, 3), its columns the axes of the moved frame in the world.
    """

    position: Vector
    rotation: Matrix


@dataclass(frozen=True, slots=True)
class Kinematics:
    """Proof that forward kinematics ran for ``state``: only a Team makes it.

    Attributes:
        state: the state that it holds for; poses and Jacobians are at the measured q.
        tools: pose of each robot's tool frame.
        jacobians: each robot's tool Jacobian, shape (6, n_robot): linear then angular velocity,
            at the tool's origin, axes parallel to the world (LOCAL_WORLD_ALIGNED).
        spheres: returns the collision spheres at the measured q; made when first asked for.
        frames: looks up other frames than the tools, each once; use ``frame``.
    """

    state: RobotState
    tools: tuple[Pose, ...]
    jacobians: tuple[Matrix, ...]
    spheres: Callable[[], Spheres]
    frames: Frames

    def frame(self, robot: int, name: str) -> tuple[Pose, Matrix]:
        """Return the pose of any frame of a robot, and its Jacobian, as ``jacobians`` has them.

        Args:
            robot: its place in the team.
            name: ``tool``, or any link or joint of the robot's description.

        Raises:
            ModelError: the robot has no such frame.
        """
        if name == "tool":
            return self.tools[robot], self.jacobians[robot]
        return self.frames(robot, name)


class Frames:
    """Frames at one state: each is worked out when it is first asked for, and kept."""

    __slots__ = ("_known", "_make")

    def __init__(self, make: Callable[[int, str], tuple[Pose, Matrix]]) -> None:
        """Remember what to call."""
        self._make = make
        self._known: dict[tuple[int, str], tuple[Pose, Matrix]] = {}

    def __call__(self, robot: int, name: str) -> tuple[Pose, Matrix]:
        """Return the pose and the Jacobian of a frame."""
        if (robot, name) not in self._known:
            self._known[robot, name] = self._make(robot, name)
        return self._known[robot, name]


class Once:
    """A function without arguments that is called when first needed, and never again."""

    __slots__ = ("_make", "_value")

    def __init__(self, make: Callable[[], Spheres]) -> None:
        """Remember what to call."""
        self._make = make
        self._value: Spheres | None = None

    def __call__(self) -> Spheres:
        """Return its value."""
        if self._value is None:
            self._value = self._make()
        return self._value
