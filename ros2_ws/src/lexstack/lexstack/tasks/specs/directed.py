"""Tasks that point an axis of a frame, and those that keep a frame within something."""

from __future__ import annotations

from dataclasses import dataclass

from lexstack.tasks.axis_alignment import AxisAlignmentParameters
from lexstack.tasks.collision_avoidance import CollisionAvoidanceParameters
from lexstack.tasks.cone import ConeParameters
from lexstack.tasks.frame_velocity_limit import FrameVelocityLimitParameters
from lexstack.tasks.half_space import HalfSpaceParameters
from lexstack.tasks.look_at import LookAtParameters
from lexstack.tasks.specs.spec import TaskSpec


@dataclass(frozen=True, eq=False)
class AxisAlignment(TaskSpec, AxisAlignmentParameters):
    """An axis of a frame goes along a direction; the turn about it stays free: two rows [rad/s].

    B J_w chi -> B sat(gain e), with e the turn from the axis to the direction the short way.

    mink and placo: ``AxisAlignTask``; pink has none.

    Attributes:
        frame: of the robot: a link or joint of its description, or ``tool``.
        axis: in the frame; its length does not matter.
        direction: in the world; its length does not matter.
        gain: 1/s.
        max_angular: what |gain e| stays below [rad/s].
    """

    kind = "axis_alignment"


@dataclass(frozen=True, eq=False)
class LookAt(TaskSpec, LookAtParameters):
    """An axis of a frame points at a point of the world, from wherever the frame is: two rows.

    B (J_w + [d]x J_v / r) chi -> B sat(gain e), with d the direction to the point and r the
    distance.

    mink: ``LookAtTask``; pink and placo have none.

    Attributes:
        point: m, in the world.
        frame: of the robot: a link or joint of its description, or ``tool``.
        axis: that looks, in the frame; its length does not matter.
        gain: 1/s.
        max_angular: what |gain e| stays below [rad/s].
        nearest: nearer to the point it counts as so far away [m].
    """

    kind = "look_at"


@dataclass(frozen=True, eq=False)
class FrameVelocityLimit(TaskSpec, FrameVelocityLimitParameters):
    """The velocity of a frame stays within limits, axis by axis: -limit <= A J chi <= limit.

    An inequality, kept exactly where the levels above and the joints' limits allow it. pink, mink
    and placo limit the velocities of joints alone.

    Attributes:
        frame: of the robot: a link or joint of its description, or ``tool``.
        axes: of the limits: ``world``, ``local``, or another frame of the robot.
        linear: along x, y, z [m/s]; inf: no limit.
        angular: about x, y, z [rad/s]; inf: no limit.
    """

    kind = "frame_velocity_limit"


@dataclass(frozen=True, eq=False)
class HalfSpace(TaskSpec, HalfSpaceParameters):
    """A frame stays on one side of a plane: n . (J_v chi) >= -w(r), r the room that is left [m].

    w(r) is the largest speed from which the frame can still stop in front of the plane. pink:
    ``PositionBarrier``, along the axes of the world; mink and placo have none for frames.

    Attributes:
        normal: in the world, towards the allowed side; its length does not matter.
        offset: of the plane from the origin, along the normal [m].
        frame: of the robot: a link or joint of its description, or ``tool``.
        margin: to the plane [m].
        deceleration: with which an approach may end [m/s2].
        gain: of the last part of an approach, at most 1/dt [1/s].
    """

    kind = "half_space"


@dataclass(frozen=True, eq=False)
class Cone(TaskSpec, ConeParameters):
    """An axis of a frame stays within a cone about a direction: one inequality row [rad/s].

    (d x a) / |d x a| . (J_w chi) <= w(angle - theta), with theta the angle between them now.

    placo: ``ConeConstraint``; pink and mink have none.

    Attributes:
        angle: between axis and direction, at most [rad].
        frame: of the robot: a link or joint of its description, or ``tool``.
        axis: in the frame; its length does not matter.
        direction: in the world; its length does not matter.
        deceleration: with which an approach may end [rad/s2].
        gain: of the last part of an approach, at most 1/dt [1/s].
    """

    kind = "cone"


@dataclass(frozen=True, eq=False)
class CollisionAvoidance(TaskSpec, CollisionAvoidanceParameters):
    """The spheres of a robot keep their distance: n . (J_i - J_j) chi >= n . v_j - w(r) per pair.

    To obstacles, to other robots, to the floor, and to the robot's own spheres. The room r is the
    distance less the margin, w(r) the largest speed of approach from which it can still stop.

    pink: ``BodySphericalBarrier``, ``SelfCollisionBarrier``; mink: ``CollisionAvoidanceLimit``;
    placo: ``AvoidSelfCollisionsConstraint``.

    Attributes:
        margin: between the surfaces [m].
        influence: pairs whose surfaces are further apart have no effect [m].
        deceleration: with which an approach may end in front of the margin [m/s2].
        gain: of the last part of an approach, at most 1/dt [1/s].
        rows: at most so many pairs, the nearest.
        obstacles: names of obstacles; None: all.
        robots: names of other robots.
        ground: whether the arm keeps away from the floor too.
        itself: whether its own links keep apart, those that can meet.
    """

    kind = "collision_avoidance"
