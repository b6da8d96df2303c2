"""A robot as a program has it: made from its URDF in one line, asked by name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from lexstack.limits.joint_limits import JointLimits
from lexstack.options import build
from lexstack.robots.configuration import Configuration
from lexstack.robots.from_urdf import robot_from_urdf
from lexstack.robots.obstacles import Obstacles
from lexstack.robots.options import (
    AnyBase,
    FrameConfig,
    ObstacleConfig,
    RobotConfig,
    SphereConfig,
)
from lexstack.robots.robot import RobotModel
from lexstack.robots.team import Team
from lexstack.types import Vector

FIXED = "fixed"
"""The base of a robot that stands on a table or hangs on a wall."""


class Robot:
    """One robot: its joints, its limits, and where its frames are.

    Attributes:
        model: the whole of it: pinocchio's model, mass matrix, spheres.
    """

    def __init__(self, model: RobotModel) -> None:
        """Take a robot that is built; ``from_urdf`` builds one."""
        self.model = model
        self._team = Team((model,), 0.01)  # for kinematics, which do not depend on the period

    @classmethod
    def from_urdf(
        cls,
        description: str | Path | pin.Model,
        base: str | AnyBase = FIXED,
        *,
        name: str = "robot",
        tool: str | None = None,
        tools: Mapping[str, str] | None = None,
        place: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0),
        spheres: Sequence[SphereConfig | Mapping[str, Any]] = (),
        **arm: Any,
    ) -> Robot:
        """Return the robot that a URDF describes.

        Limits of position, velocity and torque are the URDF's. Accelerations are by default those
        that reach full velocity in 0.4 s, jerks those that reach full acceleration in 0.01 s.

        Args:
            description: a path, ``package://NAME/...``, a text, a path below example-robot-data's
                ``robots`` folder, or a model of pinocchio.
            base: ``fixed``, ``holonomic``, ``differential``, a ``BaseConfig`` or a
                ``DifferentialConfig``. On a platform the first link is mounted in the middle of its
                top, unless ``mount`` says where; with ``chassis_mass=0`` the platform is in the
                URDF.
            name: by which tasks and limits name it where there are several.
            tool: the link of the default end effector; default: the last one of the only chain.
            tools: other names for links.
            place: x, y, z [m], yaw [rad] of the mounting of a robot without a base.
            spheres: that stand for it where distances are kept: link, xyz [m], radius [m] each.
            arm: values of the section ``arm`` of a robot's file, such as ``home={"elbow": 1.5}``,
                ``acceleration=5.0``, ``joints=[...]`` or ``fixed={"finger": 0.0}``.

        Raises:
            ConfigurationError: a value is missing or wrong; the text names key and joint.
            ModelError: a frame is not there.
        """
        platform = _base(base, name)
        if platform is not None and platform.chassis_mass and "mount" not in arm:
            top = platform.chassis_height + 0.5 * platform.chassis_size[2]
            arm["mount"] = FrameConfig("base", (0.0, 0.0, top))
        return cls(
            robot_from_urdf(
                description,
                name=name,
                base=platform,
                tool=tool,
                tools=tools,
                place=place,
                spheres=[build(SphereConfig, s, f"robot {name}: spheres") for s in spheres],
                **{key: _plain(value) for key, value in arm.items()},
            )
        )

    @classmethod
    def from_config(
        cls,
        config: RobotConfig,
        name: str = "robot",
        place: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0),
    ) -> Robot:
        """Return the robot of a configuration, as ``mobile_manipulator`` makes one."""
        return cls(RobotModel(name, config, place))

    @property
    def name(self) -> str:
        """Its name."""
        return self.model.name

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of its controlled joints, in the order of its velocity."""
        return self.model.joints

    @property
    def n_q(self) -> int:
        """Length of its configuration q."""
        return self.model.nq

    @property
    def n_v(self) -> int:
        """Length of its velocity, which is what is commanded."""
        return self.model.n

    @property
    def limits(self) -> JointLimits:
        """Of its joints, shape (n_v,) each."""
        return self.model.limits

    @property
    def home(self) -> Vector:
        """Where it starts, shape (n_q,), m and rad."""
        return self.model.home()

    @property
    def frames(self) -> tuple[str, ...]:
        """Names that tasks on frames may have: of joints, of links, and ``tool``."""
        return tuple(dict.fromkeys(frame.name for frame in self.model.pinocchio.frames))

    def configuration(
        self,
        q: object,
        velocity: object = None,
        *,
        time: float = 0.0,
        obstacles: Mapping[str, ObstacleConfig] | None = None,
    ) -> Configuration:
        """Return the robot at a configuration: its poses and Jacobians, for tasks and for you.

        Args:
            q: shape (n_q,), m and rad; a joint that turns without limits has one unwrapped angle.
            velocity: that was commanded last, shape (n_v,), m/s and rad/s. Where it is known,
                ``solve_hqp`` keeps accelerations within their limits; else velocities and
                positions alone.
            time: for trajectories and obstacles that move [s].
            obstacles: that are in the way, by name.

        Raises:
            InputError: a shape is wrong, or a number is not finite.
        """
        team = self._team
        if obstacles is not None:
            team = Team((self.model,), team.dt, Obstacles(obstacles))
        return Configuration.of(team, q, velocity, time)

    def integrate(self, q: Vector, velocity: Vector, dt: float) -> Vector:
        """Return where the robot is after dt [s] at a velocity from q, shape (n_q,)."""
        return self.model.integrate(q, velocity, dt)

    def __repr__(self) -> str:
        """Return what it is, in one line."""
        return f"Robot({self.name!r}, joints: {', '.join(self.joints)})"


@dataclass(frozen=True)
class _Base:
    """A base by its type, as robot files have it."""

    base: AnyBase


def _base(base: str | AnyBase, name: str) -> AnyBase | None:
    """Return the configuration of a base, None for a robot without one."""
    if not isinstance(base, str):
        return base
    return None if base == FIXED else build(_Base, {"base": {"type": base}}, f"robot {name}").base


def _plain(value: Any) -> Any:
    """Return an array as a list, anything else as it is."""
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else value
