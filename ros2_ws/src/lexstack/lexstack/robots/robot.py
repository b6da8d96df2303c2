"""One robot: its pinocchio model, its limits, and where its parts lie in its own vector."""

from __future__ import annotations

import difflib
from functools import cached_property

import numpy as np
import pinocchio as pin

from lexstack.errors import ModelError
from lexstack.limits.joint_limits import JointLimits
from lexstack.options import shown
from lexstack.robots.assembly import BASE_JOINTS, DRIVE, TOOL, build_robot, frame_index
from lexstack.robots.collision_geometry import SphereModel
from lexstack.robots.joint_map import JointMap, joint_map
from lexstack.robots.kinematics import Pose
from lexstack.robots.options import DifferentialConfig, RobotConfig
from lexstack.robots.spatial import from_rpy
from lexstack.robots.unicycle import arc, by_chi, rate_matrix
from lexstack.robots.urdf import Description, slides
from lexstack.types import Matrix, Tree, Vector


class RobotModel:
    """Kinematics, inertia and limits of one robot.

    Its q is a plain vector of positions. It has one entry for each of chi, but for a robot on a
    differential base: that is commanded by its forward speed and its yaw rate, and has x, y, yaw in
    its q, so that q is longer by one. A joint that turns without limits has one entry, an unwrapped
    angle: q is never taken modulo 2 pi, and a robot that turned once is at another q than before.

    Attributes:
        name: the robot's name, unique in its team.
        config: what it was built from.
        pinocchio: the model of all joints that move, mimicking ones too; its configuration is
            ``positions(q)``. A base's x, y, yaw in the world frame come first.
        joints: names of the entries of its part of chi: its controlled joints, of a differential
            base ``base_v`` and ``base_w``.
        coordinates: names of the entries of its q.
        limits: shape (n,) each; bases and continuous joints have no position limits.
        differential: whether its base is one.
        base: the base's entries in its part of chi; empty where it has no base.
        arm: all others.
        base_q: the base's entries in its q.
        arm_q: all others.
        map: how the joints of ``pinocchio`` follow q; None: they are q.
        mounting: where the robot's base, or what an arm without base stands on, is at q = 0.
        spheres: that stand for it where distances are kept.
    """

    def __init__(
        self,
        name: str,
        config: RobotConfig,
        place: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0),
        description: Description | None = None,
    ) -> None:
        """Build the model.

        Args:
            name: of the robot.
            config: of its kind.
            place: of a robot without a base: x, y, z [m] and yaw [rad] of its mounting in the
                world. A robot with a base is where its q says.
            description: in place of the URDF that the configuration names.

        Raises:
            ModelError: configuration and description disagree.
        """
        self.name = name
        self.config = config
        x, y, z, yaw = place
        self.mounting = Pose(np.array([x, y, z]), from_rpy((0.0, 0.0, yaw)))
        self._place: Vector = np.array([x, y, yaw])
        if config.base is not None:
            self.mounting = Pose(np.zeros(3), np.eye(3))
        mounting = pin.SE3(self.mounting.rotation, self.mounting.position)
        model, mimics = build_robot(config, mounting, description)
        self.pinocchio: pin.Model = model
        base = () if config.base is None else BASE_JOINTS
        self.differential = isinstance(config.base, DifferentialConfig)
        driven = DRIVE if self.differential else base
        self.coordinates: tuple[str, ...] = (*base, *config.arm.joints)
        self.joints: tuple[str, ...] = (*driven, *config.arm.joints)
        self.base, self.base_q = slice(0, len(driven)), slice(0, len(base))
        self.arm = slice(len(driven), len(self.joints))
        self.arm_q = slice(len(base), len(self.coordinates))
        self.map: JointMap | None = joint_map(model.names[1:], self.coordinates, mimics)
        self.limits = _limits(config)
        self.spheres = SphereModel(name, model, config.spheres, self.map, self.differential)
        self._data: pin.Data = model.createData()
        self._tool: int = model.getFrameId(TOOL)
        self._frames: dict[str, int] = {TOOL: self._tool}

    @property
    def n(self) -> int:
        """Number of velocities that it is commanded by: the length of its part of chi."""
        return len(self.joints)

    @property
    def nq(self) -> int:
        """Length of its q."""
        return len(self.coordinates)

    @property
    def has_base(self) -> bool:
        """Whether it drives."""
        return self.config.base is not None

    @property
    def without_position(self) -> tuple[str, ...]:
        """The names of ``joints`` that are the derivative of no coordinate."""
        return DRIVE if self.differential else ()

    @cached_property
    def prismatic(self) -> tuple[bool, ...]:
        """Whether each entry of chi is in m/s, in the order of ``joints``; else it is in rad/s."""
        drive = (True, False) if self.differential else ()
        return (*drive, *self.sliding[len(self.sliding) - self.n + len(drive) :])

    @cached_property
    def sliding(self) -> tuple[bool, ...]:
        """Whether each entry of q is in m, in the order of ``coordinates``; else it is in rad."""
        model = self.pinocchio
        return tuple(slides(model, model.getJointId(name)) for name in self.coordinates)

    def home(self, base: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Vector:
        """Return the home configuration with the base at x [m], y [m], yaw [rad], shape (nq,).

        A robot without a base stays where it is mounted.
        """
        start = base if self.has_base else ()
        return np.array([*start, *self.config.arm.home])

    def base_pose(self, q: Vector) -> Vector:
        """Return x [m], y [m], yaw [rad] of the base at q, or of the mounting without one."""
        return np.array(q[self.base_q] if self.has_base else self._place, dtype=np.float64)

    @property
    def mid_range(self) -> Vector:
        """The middle of the arm's position limits, (q_max + q_min) / 2, rad.

        Of a joint without limits, where it is at home.
        """
        lower, upper = self.limits.position_lower[self.arm], self.limits.position_upper[self.arm]
        limited = np.isfinite(lower) & np.isfinite(upper)
        middle = 0.5 * (np.where(limited, lower, 0.0) + np.where(limited, upper, 0.0))
        return np.where(limited, middle, self.config.arm.home)

    @property
    def posture(self) -> Vector:
        """Where the arm rests: the posture of its file, or mid-range where it has none, rad."""
        posture = self.config.arm.posture
        return self.mid_range if posture is None else np.array(posture)

    def positions(self, q: Vector) -> Vector:
        """Return the configuration of ``pinocchio`` at q (nq,), mimicking joints included."""
        return q if self.map is None else self.map.positions(q)

    def integrate(self, q: Vector, chi: Vector, dt: float) -> Vector:
        """Return where the robot is after it moved at chi for dt [s] from q, shape (nq,).

        Exact for a chi that is constant over dt: a differential base drives along an arc.
        """
        if not self.differential:
            return q + dt * chi
        moved = arc(q[:3], float(chi[0]), float(chi[1]), dt)
        return np.concatenate((moved, q[3:] + dt * chi[2:]))

    def rate_matrix(self, q: Vector) -> Matrix:
        """Return G(q) of H(4) with q' = G(q) chi, shape (nq, n): of most robots the identity."""
        return rate_matrix(self.n, float(q[2])) if self.differential else np.eye(self.n)

    def _by_chi(self, matrix: Matrix, q: Vector) -> Matrix:
        """Return the columns (m, n) of chi for those of all joints of ``pinocchio``, (m, n_all)."""
        if self.map is not None:
            matrix = matrix @ self.map.matrix
        return by_chi(matrix, float(q[2])) if self.differential else matrix

    def mass_matrix(self, q: Vector) -> Matrix:
        """Return the mass matrix of chi, armatures included, shape (n, n)."""
        mass = np.triu(pin.crba(self.pinocchio, self._data, self.positions(q)))
        full: Matrix = mass + np.triu(mass, 1).T
        if self.differential:
            return self._by_chi(self._by_chi(full, q).T, q)
        return full if self.map is None else self.map.matrix.T @ full @ self.map.matrix

    def frame(self, name: str) -> int:
        """Return the place of a frame in ``pinocchio``: of ``tools``, ``tool``, or of the URDF.

        Raises:
            ModelError: there is no such frame.
        """
        if name not in self._frames:
            found = frame_index(self.pinocchio, name)
            if found is None:
                known = sorted({frame.name for frame in self.pinocchio.frames})
                near = ", ".join(difflib.get_close_matches(name, known)) or ", ".join(known[:10])
                raise ModelError(f"robot {self.name}: no frame {shown(name)}; there is: {near}")
            self._frames[name] = found
        return self._frames[name]

    def tool(self, q: Vector) -> tuple[Pose, Matrix]:
        """Return the tool's pose and its Jacobian (6, n), LOCAL_WORLD_ALIGNED, at q (nq,)."""
        return self.at(q, self._tool)

    def centre_of_mass(self, q: Vector) -> tuple[Vector, Matrix]:
        """Return the centre of mass in the world (3,), m, and its Jacobian (3, n) at q (nq,)."""
        centre, every = self.mass_motion(q)
        return centre, self._by_chi(every[:3], q)

    def mass_motion(self, q: Vector) -> tuple[Vector, Matrix]:
        """Return the centre of mass (3,), m, and how joints move it, shape (6, n_all), at q (n,).

        Of all joints of ``pinocchio``, mimicking ones too: the Jacobian of the centre, then the
        axes of those that turn, both in the world.
        """
        every = self.positions(q)
        found = np.empty((6, self.pinocchio.nv))
        found[:3] = pin.jacobianCenterOfMass(self.pinocchio, self._data, every, False).reshape(
            3, -1
        )
        found[3:] = self._data.J[3:]  # which it fills on its way
        return self._data.com[0].copy(), found

    @cached_property
    def tree(self) -> Tree:
        """How the joints of ``pinocchio`` carry each other, and follow the controlled ones."""
        model = self.pinocchio
        carries = np.zeros((model.nv, model.nv))
        for joint in range(1, model.njoints):
            for above in list(model.supports[joint])[1:]:
                carries[model.joints[above].idx_v, model.joints[joint].idx_v] = 1.0
        carries.setflags(write=False)
        return Tree(carries, None if self.map is None else self.map.matrix)

    def tree_at(self, q: Vector) -> Tree:
        """Return ``tree`` with how its joints follow chi at q (nq,): with the yaw of a base."""
        if not self.differential:
            return self.tree
        follows = np.eye(self.nq) if self.map is None else self.map.matrix
        return Tree(self.tree.carries, by_chi(follows, float(q[2])))

    def all_joints(self, q: Vector, frame: str) -> Matrix:
        """Return a frame's Jacobian on all joints of ``pinocchio`` at q (n,), shape (6, n_all)."""
        every, place = self.positions(q), self.frame(frame)
        found = pin.computeFrameJacobian(
            self.pinocchio, self._data, every, place, pin.LOCAL_WORLD_ALIGNED
        )
        return np.array(found).reshape(6, -1)

    @property
    def mass(self) -> float:
        """The mass of all bodies of the model [kg]."""
        return float(sum(inertia.mass for inertia in self.pinocchio.inertias))

    def at(self, q: Vector, frame: int) -> tuple[Pose, Matrix]:
        """Return a frame's pose and its Jacobian at q (nq,).

        Args:
            q: the configuration, shape (nq,).
            frame: as ``frame`` returned it.

        Returns:
            the pose in the world frame, and the Jacobian (6, n): linear velocity of the frame's
            origin, then angular velocity, axes parallel to the world (LOCAL_WORLD_ALIGNED).
        """
        joints = self.map
        jacobian = pin.computeFrameJacobian(
            self.pinocchio,
            self._data,
            q if joints is None else joints.positions(q),
            frame,
            pin.LOCAL_WORLD_ALIGNED,
        )
        # computeFrameJacobian places the joints but not the frame.
        pose = pin.updateFramePlacement(self.pinocchio, self._data, frame)
        if jacobian.ndim == 1:  # pinocchio's, of a model of one joint
            jacobian = jacobian.reshape(6, 1)
        if joints is not None or self.differential:
            jacobian = self._by_chi(jacobian, q)
        return Pose(pose.translation.copy(), pose.rotation.copy()), jacobian


def _limits(config: RobotConfig) -> JointLimits:
    """Return the limits of base and arm as one set of vectors."""
    base, arm = config.base, config.arm
    if base is None:
        return JointLimits(
            position_lower=np.array(arm.position_lower),
            position_upper=np.array(arm.position_upper),
            velocity=np.array(arm.velocity),
            acceleration=np.array(arm.acceleration),
            jerk=np.array(arm.jerk),
        )
    unlimited = np.full(len(base.velocity), np.inf)
    return JointLimits(
        position_lower=np.concatenate([-unlimited, arm.position_lower]),
        position_upper=np.concatenate([unlimited, arm.position_upper]),
        velocity=np.concatenate([base.velocity, arm.velocity]),
        acceleration=np.concatenate([base.acceleration, arm.acceleration]),
        jerk=np.concatenate([base.jerk, arm.jerk]),
    )
