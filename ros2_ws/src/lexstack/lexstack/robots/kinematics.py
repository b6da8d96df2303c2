"""Poses and Jacobians of all robots at one state."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

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


@dataclass(frozen=True)  # without slots, where cached_property could not keep a value
class Kinematics:
    """Proof that forward kinematics ran for ``state``: only a Team makes it.

    Attributes:
        state: the state that it holds for; poses and Jacobians are at the measured q.
        tools: pose of each robot's tool frame.
        jacobians: each robot's tool Jacobian, shape (6, n_robot): linear then angular velocity,
            at the tool's origin, axes parallel to the world (LOCAL_WORLD_ALIGNED).
        spheres_at: returns the collision spheres at a configuration, shape (n,).
        frames: looks up other frames than the tools, each once; use ``frame``.
        unicycles: places in the team of the robots whose first two columns are the forward speed
            and the yaw rate of a differential base. These two do not commute: how Jacobians change
            along chi is not quite that of a chain of joints.
    """

    state: RobotState
    tools: tuple[Pose, ...]
    jacobians: tuple[Matrix, ...]
    spheres_at: Callable[[Vector], Spheres]
    frames: Frames
    unicycles: frozenset[int] = frozenset()

    @cached_property
    def spheres(self) -> Spheres:
        """The collision spheres at the measured q, made when first asked for."""
        return self.spheres_at(self.state.q)

    def frame(self, robot: int, name: str) -> tuple[Pose, Matrix]:
        """Return the pose of any frame of a robot, and its Jacobian, as ``jacobians`` has them.

        Args:
            robot: its place in the team.
            name: ``tool``, one of the robot's ``tools``, or any link or joint of its URDF.

        Raises:
            ModelError: the robot has no such frame.
        """
        if name == "tool":
            return self.tools[robot], self.jacobians[robot]
        return self.frames(robot, name)


class Frames:
    """Frames at one state: each is worked out when it is first asked for, and kept."""

    __slots__ = ("_find", "_found")

    def __init__(self, find: Callable[[int, str], tuple[Pose, Matrix]]) -> None:
        """Remember what to call for a frame that is not known yet."""
        self._find = find
        self._found: dict[tuple[int, str], tuple[Pose, Matrix]] = {}

    def __call__(self, robot: int, name: str) -> tuple[Pose, Matrix]:
        """Return a frame's pose and Jacobian; raises ModelError where there is no such frame."""
        key = robot, name
        if key not in self._found:
            self._found[key] = self._find(robot, name)
        return self._found[key]
