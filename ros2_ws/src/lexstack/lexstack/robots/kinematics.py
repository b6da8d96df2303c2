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
    """

    state: RobotState
    tools: tuple[Pose, ...]
    jacobians: tuple[Matrix, ...]
    spheres_at: Callable[[Vector], Spheres]

    @cached_property
    def spheres(self) -> Spheres:
        """The collision spheres at the measured q, made when first asked for."""
        return self.spheres_at(self.state.q)
