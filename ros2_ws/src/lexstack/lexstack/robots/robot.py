"""One robot: its pinocchio model, its limits, and where its parts lie in its own vector."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from lexstack.errors import ModelError
from lexstack.limits.joint_limits import JointLimits
from lexstack.options import shown
from lexstack.robots.assembly import BASE_JOINTS, build_robot
from lexstack.robots.collision_geometry import SphereModel
from lexstack.robots.kinematics import Pose
from lexstack.robots.options import RobotConfig
from lexstack.types import Matrix, Vector

BASE = slice(0, 3)
"""The platform's joints in a robot's own vectors."""

ARM = slice(3, None)
"""The arm's joints in them."""

_PRISMATIC = ("JointModelPX", "JointModelPY", "JointModelPZ")


class RobotModel:
    """Kinematics and limits of one mobile manipulator.

    Attributes:
        name: the robot's name, unique in its team.
        config: what it was built from.
        pinocchio: the model, base x, y, yaw in the world frame and then the arm.
        joints: names of its joints in the order of its part of chi.
        limits: shape (n,) each; bases have no position limits.
        spheres: that stand for it where distances are kept.
    """

    def __init__(self, name: str, config: RobotConfig) -> None:
        """Build the model; raises ModelError where configuration and description disagree."""
        self.name = name
        self.config = config
        self.pinocchio: pin.Model = build_robot(config)
        self.joints: tuple[str, ...] = (*BASE_JOINTS, *config.arm.joints)
        self.limits = _limits(config)
        self.spheres = SphereModel(name, self.pinocchio, config.spheres)
        self._data: pin.Data = self.pinocchio.createData()
        self._tool: int = self.pinocchio.getFrameId("tool")

    @property
    def n(self) -> int:
        """Number of joints, base included."""
        return len(self.joints)

    @property
    def prismatic(self) -> tuple[bool, ...]:
        """Whether each joint slides, in the order of ``joints``.

        Its position is then in m and its velocity in m/s, of the others in rad and rad/s.
        """
        slides = [False] * self.n
        for joint in self.pinocchio.joints[1:]:
            name = joint.shortname()
            slides[joint.idx_v] = name in _PRISMATIC or "Prismatic" in name
        return tuple(slides)

    def home(self, base: tuple[float, float, float]) -> Vector:
        """Return the home configuration with the base at x [m], y [m], yaw [rad], shape (n,)."""
        return np.array([*base, *self.config.arm.home])

    @property
    def mid_range(self) -> Vector:
        """The middle of the arm's position limits, (q_max + q_min) / 2, rad."""
        return 0.5 * (self.limits.position_lower[ARM] + self.limits.position_upper[ARM])

    @property
    def posture(self) -> Vector:
        """Where the arm rests: the posture of its file, or mid-range where it has none, rad."""
        posture = self.config.arm.posture
        return self.mid_range if posture is None else np.array(posture)

    def tool(self, q: Vector) -> tuple[Pose, Matrix]:
        """Return the tool's pose and its Jacobian (6, n), LOCAL_WORLD_ALIGNED, at q (n,)."""
        return self.at(q, self._tool)

    def frame(self, name: str) -> int:
        """Return the number of a frame in ``pinocchio``; raises ModelError where there is none."""
        if not self.pinocchio.existFrame(name):
            known = ", ".join(sorted({frame.name for frame in self.pinocchio.frames}))
            raise ModelError(f"{self.name}: unknown frame {shown(name)}; known: {known}")
        return int(self.pinocchio.getFrameId(name))

    def centre_of_mass(self, q: Vector) -> tuple[Vector, Matrix]:
        """Return the centre of mass in the world (3,), m, and its Jacobian (3, n) at q (n,)."""
        jacobian = pin.jacobianCenterOfMass(self.pinocchio, self._data, q, False)
        return self._data.com[0].copy(), np.array(jacobian)

    @property
    def mass(self) -> float:
        """The mass of all bodies of the model [kg]."""
        return float(sum(inertia.mass for inertia in self.pinocchio.inertias))

    def at(self, q: Vector, frame: int) -> tuple[Pose, Matrix]:
        """Return a frame's pose and its Jacobian (6, n), LOCAL_WORLD_ALIGNED, at q (n,)."""
        jacobian = pin.computeFrameJacobian(
            self.pinocchio, self._data, q, frame, pin.LOCAL_WORLD_ALIGNED
        )
        # computeFrameJacobian places the joints but not the frame.
        pose = pin.updateFramePlacement(self.pinocchio, self._data, frame)
        return Pose(pose.translation.copy(), pose.rotation.copy()), jacobian


def _limits(config: RobotConfig) -> JointLimits:
    """Return the limits of base and arm as one set of vectors."""
    base, arm = config.base, config.arm
    unlimited = np.full(3, np.inf)
    return JointLimits(
        position_lower=np.concatenate([-unlimited, arm.position_lower]),
        position_upper=np.concatenate([unlimited, arm.position_upper]),
        velocity=np.concatenate([base.velocity, arm.velocity]),
        acceleration=np.concatenate([base.acceleration, arm.acceleration]),
        jerk=np.concatenate([base.jerk, arm.jerk]),
    )
