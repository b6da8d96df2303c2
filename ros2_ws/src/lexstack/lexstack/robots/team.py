"""All robots, stacked in the configured order: what chi is about."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cached_property, partial

import numpy as np

from lexstack.compiled import kernel
from lexstack.errors import ConfigurationError
from lexstack.limits.joint_limits import JointLimits
from lexstack.options import shown
from lexstack.robots.chains import Chains
from lexstack.robots.collision_geometry import Indices, Spheres
from lexstack.robots.kinematics import Frames, Kinematics, Pose
from lexstack.robots.obstacles import Obstacles
from lexstack.robots.options import Vector3
from lexstack.robots.robot import RobotModel
from lexstack.types import Matrix, RobotState, Vector

NO_POSITION = 0.0
"""Stands for the position of a velocity that has none, where limits ask for one: all are kept."""


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
        """Return the entries of some robots in chi, by the robots' places in the order."""
        return np.concatenate(
            [np.arange(self.slices[robot].start, self.slices[robot].stop) for robot in robots]
        )

    def home(self, bases: Mapping[str, Vector3] | None = None) -> Vector:
        """Return every arm at its home, shape (nq,).

        Args:
            bases: x [m], y [m], yaw [rad] by robot; where one is left out, the origin.
        """
        places = bases or {}
        origin = (0.0, 0.0, 0.0)
        return np.concatenate([robot.home(places.get(robot.name, origin)) for robot in self.robots])

    def tools(self, q: Vector) -> tuple[Pose, ...]:
        """Return each robot's tool pose at the stacked configuration q, shape (nq,)."""
        return tuple(
            robot.tool(q[part])[0] for robot, part in zip(self.robots, self.q_slices, strict=True)
        )

    def kinematics(self, state: RobotState) -> Kinematics:
        """Return poses and Jacobians at the measured configuration of ``state``."""
        fast = kernel("lexstack.robots.kernel.chain")
        if fast is not None and self._chains is not None:
            tools, jacobians = self._chains.tools(state.q, fast)
        else:
            results = [
                robot.tool(state.q[part])
                for robot, part in zip(self.robots, self.q_slices, strict=True)
            ]
            tools = tuple(pose for pose, _ in results)
            jacobians = tuple(jacobian for _, jacobian in results)
        return Kinematics(
            state,
            tools,
            jacobians,
            self.spheres,
            Frames(partial(self._frame, state.q)),
            self._unicycles,
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

    def at_rest(self, q: Vector) -> RobotState:
        """Return the state of tick 0 at a configuration, shape (nq,)."""
        return RobotState.at_rest(q, self.n)

    def after(self, state: RobotState, chi: Vector, dt: float | None = None) -> RobotState:
        """Return the next tick's state of robots that follow a command exactly; dt: the team's."""
        dt, tick = self.dt if dt is None else dt, state.tick + 1
        q, q_star = (self.integrate(place, chi, dt) for place in (state.q, state.q_star))
        return RobotState(tick, tick * dt, q, chi, q_star, chi)

    def joint_positions(self, q: Vector) -> Vector:
        """Return the position that each entry of chi is the velocity of, shape (n,).

        The limits of positions are kept by it. v and w of a differential base are the velocities of
        no coordinates, and have no such limits: ``NO_POSITION`` stands in their places.
        """
        if self.nq == self.n:
            return q
        return np.where(self._has_position, q[self._position_of], NO_POSITION)

    def spheres(self, q: Vector) -> Spheres:
        """Return all collision spheres at the stacked configuration q, shape (nq,)."""
        results = [
            robot.spheres.at(q[part])
            for robot, part in zip(self.robots, self.q_slices, strict=True)
        ]
        radii, owners, moved_by, follows = self._fixed
        if self._unicycles:
            follows = self._follows(q)
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
    def _chains(self) -> Chains | None:
        """The chains of all robots, where they can be compiled."""
        return Chains.of(self.robots)

    @cached_property
    def _unicycles(self) -> frozenset[int]:
        """The places of the robots on differential bases."""
        return frozenset(i for i, robot in enumerate(self.robots) if robot.differential)

    @cached_property
    def _position_of(self) -> Indices:
        """Where in q the position of each entry of chi is; of those without one, anywhere."""
        places: Indices = np.zeros(self.n, dtype=np.intp)
        for robot, at, part in zip(self.robots, self.q_slices, self.slices, strict=True):
            places[part] = np.arange(at.stop - robot.n, at.stop)
        return places

    @cached_property
    def _has_position(self) -> Indices:
        """Whether each entry of chi is the derivative of an entry of q."""
        return np.concatenate(
            [np.arange(robot.n) >= 2 * robot.differential for robot in self.robots]
        )

    def _follows(self, q: Vector) -> Matrix:
        """Return ``Spheres.follows`` where some robots are on differential bases."""
        follows = np.zeros((sum(robot.pinocchio.nv for robot in self.robots), self.n))
        row = 0
        for robot, at, part in zip(self.robots, self.q_slices, self.slices, strict=True):
            rates = robot.rate_matrix(q[at])
            every = slice(row, row + robot.pinocchio.nv)
            follows[every, part] = rates if robot.map is None else robot.map.matrix @ rates
            row = every.stop
        return follows

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
            if not self._unicycles:  # else it depends on q
                follows[every, part] = np.eye(robot.n) if robot.map is None else robot.map.matrix
        radii = np.concatenate([robot.spheres.radii for robot in self.robots])
        for array in (radii, owners, moved_by, follows):
            array.setflags(write=False)
        mapped = any(robot.map is not None for robot in self.robots)
        return radii, owners, moved_by, follows if mapped else None
