"""All robots, stacked in the configured order: what chi is about."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cached_property, partial

import numpy as np

from lexstack.errors import ConfigurationError
from lexstack.limits.joint_limits import JointLimits
from lexstack.options import shown
from lexstack.robots.collision_geometry import Indices, Spheres
from lexstack.robots.kinematics import Frames, Kinematics, Once, Pose
from lexstack.robots.obstacles import Obstacles
from lexstack.robots.options import Vector3
from lexstack.robots.robot import RobotModel
from lexstack.types import Matrix, RobotState, Vector


class Team:
    """The robots, which part of chi belongs to whom, and what is in their way.

    Attributes:
        robots: in the configured order.
        names: their names.
        slices: each robot's part of chi.
        q_slices: each robot's part of q.
        n: length of chi.
        nq: length of q.
        limits: of all joints, shape (n,) each.
        dt: control period [s].
        obstacles: that distances are kept to.
    """

    def __init__(
        self, robots: tuple[RobotModel, ...], dt: float, obstacles: Obstacles | None = None
    ) -> None:
        """Stack the robots; their names must differ."""
        self.robots = robots
        self.dt = dt
        self.obstacles = Obstacles({}) if obstacles is None else obstacles
        self.names = tuple(robot.name for robot in robots)
        if len(set(self.names)) != len(robots):
            raise ConfigurationError(f"robots: names must differ, got {', '.join(self.names)}")
        ends = np.cumsum([robot.n for robot in robots])
        self.slices = tuple(
            slice(int(end) - robot.n, int(end)) for end, robot in zip(ends, robots, strict=True)
        )
        self.n = int(ends[-1])
        starts = np.cumsum([0, *(robot.nq for robot in robots)]).tolist()
        self.q_slices = tuple(map(slice, starts[:-1], starts[1:]))
        self.nq: int = starts[-1]
        self.limits = JointLimits.joined(robot.limits for robot in robots)

    def index(self, name: str) -> int:
        """Return a robot's place in the order; raises ConfigurationError listing the known."""
        if name not in self.names:
            raise ConfigurationError(f"unknown robot {shown(name)}; known: {', '.join(self.names)}")
        return self.names.index(name)

    def columns(self, robots: Iterable[int]) -> Indices:
        """Return the joints of some robots in chi, by the robots' places in the order."""
        return np.concatenate(
            [np.arange(self.slices[robot].start, self.slices[robot].stop) for robot in robots]
        )

    def home(self, bases: Mapping[str, Vector3] | None = None) -> Vector:
        """Return every arm at its home, shape (n,).

        Args:
            bases: x [m], y [m], yaw [rad] by robot; where one is left out, the origin.
        """
        places = bases or {}
        origin = (0.0, 0.0, 0.0)
        return np.concatenate([robot.home(places.get(robot.name, origin)) for robot in self.robots])

    def tools(self, q: Vector) -> tuple[Pose, ...]:
        """Return each robot's tool pose at the stacked configuration q, shape (n,)."""
        return tuple(
            robot.tool(q[part])[0] for robot, part in zip(self.robots, self.q_slices, strict=True)
        )

    def kinematics(self, state: RobotState) -> Kinematics:
        """Return poses and Jacobians at the measured configuration of ``state``."""
        results = [
            robot.tool(state.q[part])
            for robot, part in zip(self.robots, self.q_slices, strict=True)
        ]
        return Kinematics(
            state,
            tuple(pose for pose, _ in results),
            tuple(jacobian for _, jacobian in results),
            Once(partial(self.spheres, state.q)),
            Frames(partial(self._frame, state.q)),
        )

    def _frame(self, q: Vector, robot: int, name: str) -> tuple[Pose, Matrix]:
        """Return pose and Jacobian of a robot's frame at the stacked configuration q."""
        model = self.robots[robot]
        return model.at(q[self.q_slices[robot]], model.frame(name))

    def base_poses(self, q: Vector) -> tuple[Vector, ...]:
        """Return each robot's ``RobotModel.base_pose`` at the stacked configuration q."""
        return tuple(
            robot.base_pose(q[part]) for robot, part in zip(self.robots, self.q_slices, strict=True)
        )

    def integrate(self, q: Vector, chi: Vector, dt: float) -> Vector:
        """Return where all robots are after they moved at chi for dt [s] from q, shape (nq,)."""
        if self.nq == self.n:
            return q + dt * chi
        return np.concatenate(
            [
                robot.integrate(q[at], chi[part], dt)
                for robot, at, part in zip(self.robots, self.q_slices, self.slices, strict=True)
            ]
        )

    def spheres(self, q: Vector) -> Spheres:
        """Return all collision spheres at the stacked configuration q, shape (n,)."""
        results = [
            robot.spheres.at(q[part])
            for robot, part in zip(self.robots, self.q_slices, strict=True)
        ]
        radii, owners, moved_by, follows = self._fixed
        return Spheres(
            np.concatenate([centers for centers, _ in results], axis=1).T.copy(),
            radii,
            owners,
            moved_by,
            np.concatenate([twists for _, twists in results], axis=1),
            follows,
        )

    @cached_property
    def joint_names(self) -> tuple[str, ...]:
        """Names of all joints in the order of chi: robot, slash, joint."""
        return tuple(f"{robot.name}/{joint}" for robot in self.robots for joint in robot.joints)

    @cached_property
    def _fixed(self) -> tuple[Vector, Indices, Matrix, Matrix | None]:
        """Return what does not move: ``radii``, ``owners``, ``moved_by``, ``follows``."""
        counts = [len(robot.spheres.radii) for robot in self.robots]
        owners = np.repeat(np.arange(len(self.robots)), counts)
        ends = np.cumsum([robot.spheres.moved_by_all.shape[1] for robot in self.robots])
        moved_by = np.zeros((len(owners), int(ends[-1])))
        follows = np.zeros((int(ends[-1]), self.n))
        for i, (robot, part, end) in enumerate(zip(self.robots, self.slices, ends, strict=True)):
            every = slice(end - robot.spheres.moved_by_all.shape[1], end)
            moved_by[owners == i, every] = robot.spheres.moved_by_all
            follows[every, part] = np.eye(robot.n) if robot.map is None else robot.map.matrix
        radii = np.concatenate([robot.spheres.radii for robot in self.robots])
        for array in (radii, owners, moved_by, follows):
            array.setflags(write=False)
        mapped = any(robot.map is not None for robot in self.robots)
        return radii, owners, moved_by, follows if mapped else None
