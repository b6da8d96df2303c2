"""A robot's joints and points as arrays, from its pinocchio model: what the compiled code takes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from lexstack.errors import ModelError
from lexstack.mpc.stage.kernel.values import Chain
from lexstack.robots import RobotModel
from lexstack.types import Matrix, Vector

_ROUNDING = 1e-15  # of a fixed rotation: entries that are rounding alone


@dataclass(frozen=True, slots=True)
class Axis:
    """A joint of one degree of freedom: its column, and the axis in its own frame."""

    column: int
    direction: Vector
    turns: bool


@dataclass(frozen=True, slots=True)
class BodyPoint:
    """A point on a joint's body: the joint, and where it is in the joint's frame [m]."""

    joint: int
    offset: Vector


def axis_of(robot: RobotModel, joint: int) -> Axis:
    """Return a joint's axis; raises ModelError where it has none that is constant."""
    model = robot.pinocchio
    kind = model.joints[joint]
    name = model.names[joint]
    if kind.nv != 1 or kind.nq != 1:
        raise ModelError(f"robot {robot.name}: {name}: only joints with one coordinate, not turns")
    data = model.createData()
    jacobian = pin.computeJointJacobian(model, data, pin.neutral(model), joint)
    motion = jacobian[:, kind.idx_v]
    linear, angular = motion[:3], motion[3:]
    if np.any(linear) == np.any(angular):
        raise ModelError(f"robot {robot.name}: {name}: neither slides nor turns about one axis")
    return Axis(kind.idx_v, angular if np.any(angular) else linear, bool(np.any(angular)))


def sphere_of(robot: RobotModel, place: int) -> BodyPoint:
    """Return a configured sphere's centre; raises ModelError for a place that is not there."""
    configs = robot.config.spheres
    if not 0 <= place < len(configs):
        raise ModelError(f"robot {robot.name}: spheres: no entry {place} of {len(configs)}")
    model, config = robot.pinocchio, configs[place]
    frame = model.frames[model.getFrameId(config.link, pin.FrameType.BODY)]
    return BodyPoint(frame.parentJoint, frame.placement.act(np.array(config.xyz)))


def rounded(rotation: Matrix) -> Matrix:
    """Return a fixed rotation; entries that are rounding alone become zeros."""
    return np.where(np.abs(rotation) < _ROUNDING, 0.0, rotation)


def chain_of(robot: RobotModel, spheres: tuple[int, ...], frames: tuple[str, ...]) -> Chain:
    """Return the joints that carry some frames and spheres, and these as points.

    Args:
        robot: the model, all joints of one degree of freedom.
        spheres: places in the robot's configured list.
        frames: names, as ``RobotModel.frame`` knows them.

    Raises:
        ModelError: a joint has no constant axis, a sphere's link or a frame is not there.
    """
    model = robot.pinocchio
    axes = [axis_of(robot, joint) for joint in range(1, model.njoints)]
    framed = [model.frames[robot.frame(name)] for name in frames]
    points = [BodyPoint(frame.parentJoint, frame.placement.translation) for frame in framed]
    points += [sphere_of(robot, place) for place in spheres]
    carrying = sorted({joint for point in points for joint in model.supports[point.joint]} - {0})
    place = {0: -1, **{joint: i for i, joint in enumerate(carrying)}}
    joints = np.zeros((len(carrying), 3), dtype=np.int64)
    turning = np.zeros((len(carrying), 3, 3, 3))
    fixed = np.zeros((len(carrying), 8))
    for i, joint in enumerate(carrying):
        axis, placement = axes[joint - 1], model.jointPlacements[joint]
        column, factor, offset = _followed(robot, axis.column)
        joints[i] = place[model.parents[joint]], axis.turns, column
        fixed[i] = *placement.translation, *axis.direction, factor, offset
        turning[i, 0] = rotation = rounded(placement.rotation)
        if axis.turns:
            turning[i] = _turning(rotation, axis.direction)
    bodies = np.array([place[point.joint] for point in points], dtype=np.int64)
    offsets = np.array([point.offset for point in points]).reshape(-1, 3)
    attitudes = np.array([frame.placement.rotation for frame in framed]).reshape(-1, 3, 3)
    return Chain(joints, turning, fixed, bodies, offsets, attitudes)


def _turning(rotation: Matrix, axis: Vector) -> Matrix:
    """Return A, B and C of the rotation A + cos B + sin C of a joint, shape (3, 3, 3)."""
    outer = np.outer(axis, axis)
    return np.stack((rotation @ outer, rotation @ (np.eye(3) - outer), rotation @ pin.skew(axis)))


def _followed(robot: RobotModel, column: int) -> tuple[int, float, float]:
    """Return the coordinate that a joint of the model follows, with factor and offset."""
    if robot.map is None:
        return column, 1.0, 0.0
    row = robot.map.matrix[column]
    coordinate = int(np.argmax(np.abs(row)))
    return coordinate, float(row[coordinate]), float(robot.map.offset[column])
