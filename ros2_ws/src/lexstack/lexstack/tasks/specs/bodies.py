"""Tasks on joints, on bases, and on a robot as a whole."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from lexstack.errors import InputError
from lexstack.tasks.base_pose import BaseParameters
from lexstack.tasks.centre_of_mass import CentreOfMassParameters
from lexstack.tasks.joint_coupling import JointCouplingParameters
from lexstack.tasks.manipulability import ManipulabilityParameters
from lexstack.tasks.posture import PostureParameters
from lexstack.tasks.relative_pose import RelativePoseParameters
from lexstack.tasks.specs.goals import VectorGoal, is_motion, numbers
from lexstack.tasks.specs.spec import Targeted, TaskSpec
from lexstack.tasks.velocity_damping import VelocityDampingParameters
from lexstack.types import Vector


@dataclass(frozen=True, eq=False)
class Posture(Targeted[VectorGoal], TaskSpec, PostureParameters):
    """The arm goes to a configuration: Gamma chi -> q_dot_d + gain (q_d - q*), T(22) to T(25).

    The target is the first field, or given later by ``set_target``: positions (n_arm,) [rad, m], or
    a trajectory of them such as a ``Spline``.

    pink and mink: ``PostureTask``; placo: ``JointsTask``.

    Attributes:
        target: [rad, m]; None: the robot's own posture; ``mid_range``: the middle of its limits.
        gain: lambda [1/s].
        joints: names of the arm's joints that have a row; empty: all.
        weights: of the squared residual of each row; empty: all 1.
    """

    kind = "posture"

    # As in a file; a program may give an array too, of which a tuple is kept.
    target: Literal["mid_range"] | tuple[float, ...] | Vector | None = None  # type: ignore[assignment]

    def _checked(self, target: Any) -> Any:
        if is_motion(target):
            return target
        return numbers(target, (np.size(target),), f"{self.label}: target")


@dataclass(frozen=True, eq=False)
class BasePose(Targeted[VectorGoal], TaskSpec, BaseParameters):
    """The base goes to a place: Phi chi -> x_dot_d + gain (x_d - x*), T(26) to T(30).

    Targets: x [m], y [m], yaw [rad] in the world, or a trajectory of them such as ``base_spline``.
    Until one is given, a run holds the base where it is, and ``solve_hqp`` asks for rest.

    pink: ``FrameTask`` of the root joint; mink: ``FrameTask`` of the base's body.

    Attributes:
        gain: lambda [1/s].
    """

    kind = "base"

    def _checked(self, target: Any) -> Any:
        return target if is_motion(target) else numbers(target, (3,), f"{self.label}: target")


@dataclass(frozen=True, eq=False)
class VelocityDamping(TaskSpec, VelocityDampingParameters):
    """What no level above uses stays still: W chi -> 0, the second level of T(36).

    pink and mink: ``DampingTask``; placo: ``RegularizationTask``.

    Attributes:
        base_cost: of 1 m/s or 1 rad/s of a joint of the base.
        arm_cost: of 1 rad/s of a joint of the arm.
    """

    kind = "velocity_damping"


@dataclass(frozen=True, eq=False)
class JointCoupling(TaskSpec, JointCouplingParameters):
    """A linear combination of joints stays at a value: c . chi -> gain (value - c . q*).

    pink: ``JointCouplingTask``; placo: ``GearTask``; mink: ``EqualityConstraintTask``.

    Attributes:
        joints: c: a coefficient of each joint that is coupled, by its name.
        value: of c . q* [rad, m].
        gain: 1/s.
    """

    kind = "joint_coupling"


@dataclass(frozen=True, eq=False)
class CentreOfMass(TaskSpec, CentreOfMassParameters):
    """The centre of mass goes over a point: S J_c chi -> S sat(gain (c_d - c)).

    pink and mink: ``ComTask``; placo: ``CoMTask``.

    Attributes:
        target: c_d [m], in the world.
        mask: which of x, y, z have a row.
        gain: 1/s.
        max_linear: what |gain e| stays below [m/s].
    """

    kind = "centre_of_mass"


@dataclass(frozen=True, eq=False)
class Manipulability(TaskSpec, ManipulabilityParameters):
    """The arm turns away from its singularities: Gamma chi -> sat(gain d log w / dq).

    w is the root of det(J J^T) of a frame's Jacobian, by the arm's joints.

    pink and placo: ``ManipulabilityTask``; mink has none.

    Attributes:
        frame: of the robot: a link or joint of its description, or ``tool``.
        rows: of the Jacobian that count: ``position``, ``orientation`` or ``pose``.
        gain: rad2/s.
        max_speed: what the norm of the joints' velocities stays below [rad/s].
    """

    kind = "manipulability"


@dataclass(frozen=True, eq=False)
class RelativePose(TaskSpec, RelativePoseParameters):
    """Two frames keep their pose to each other: two hands hold one box, or two arms of one robot.

    J_b chi - G J_a chi -> sat(gain e), with G the motion of the box's other end: wherever a task
    below takes frame a, frame b goes along. For two tools without ``pose`` it is the pose at the
    start of a run.

    pink, mink and placo: ``RelativeFrameTask``.

    Attributes:
        other: name of the robot of frame b; empty: the same robot.
        frame: a, of the robot: a link or joint of its description, or ``tool``.
        other_frame: b, of the other robot.
        pose: of b in a; None: as their references are to each other.
        axes: of error, mask and gain: ``world``, ``local`` (those of a), or another frame.
        mask: which of x, y, z, and of the turns about x, y, z, have a row.
        gain: K_p [1/s]: a number, six on the diagonal, or six rows of six.
        max_linear: what |gain e| of the position stays below [m/s].
        max_angular: what |gain e| of the orientation stays below [rad/s].
    """

    kind = "relative_pose"

    def __post_init__(self) -> None:
        """Check the fields; raises ConfigurationError, and InputError without a robot."""
        super().__post_init__()
        if self.other and not self.robot:
            raise InputError("RelativePose: robot: the name of one of the two robots is missing")
