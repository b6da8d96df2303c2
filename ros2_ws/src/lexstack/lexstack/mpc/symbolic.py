"""Forward kinematics and Jacobians of one robot in CasADi, made from its pinocchio model."""

from __future__ import annotations

import casadi as ca
import pinocchio as pin

from lexstack.mpc.stage.chain import Axis, BodyPoint, axis_of, rounded, sphere_of
from lexstack.robots import RobotModel
from lexstack.robots.assembly import TOOL
from lexstack.types import Vector


def stage_function(
    robot: RobotModel, spheres: tuple[int, ...] = (), frames: tuple[str, ...] = (TOOL,)
) -> ca.Function:
    """Return the kinematics at one configuration as a CasADi function of q, shape (n_q,).

    Its outputs are first, for each frame: position (3,) and rotation (9,), by rows, in the world,
    and jacobian (n_q, 6), the transposed derivative by q, linear then angular,
    LOCAL_WORLD_ALIGNED; ``position0``, ``rotation0``, ``jacobian0``, ``position1`` ... Then
    ``centers`` (3 s,) of the chosen spheres; ``slopes`` (n_q, 3 s), their transposed Jacobians.

    Only joints that carry one of them are part of the code.

    Args:
        robot: the model, all joints of one degree of freedom.
        spheres: places in the robot's configured list.
        frames: names, as ``RobotModel.frame`` knows them.

    Raises:
        ModelError: a joint has no constant axis, a sphere's link or a frame is not there.
    """
    model = robot.pinocchio
    axes = [axis_of(robot, joint) for joint in range(1, model.njoints)]
    independent = ca.SX.sym("q", robot.nq)
    q = independent
    if robot.map is not None:
        q = ca.mtimes(ca.sparsify(ca.DM(robot.map.matrix)), q) + ca.DM(robot.map.offset)
    rotations, origins = _placements(model, axes, q)
    points = [sphere_of(robot, place) for place in spheres]
    centers = [_place(rotations, origins, point) for point in points]
    slopes = [_columns(model, axes, rotations, origins, point).T for point in points]
    follows = None if robot.map is None else ca.sparsify(ca.DM(robot.map.matrix.T))
    outputs, names = [], []
    for i, name in enumerate(frames):
        frame = model.frames[robot.frame(name)]
        origin = BodyPoint(frame.parentJoint, frame.placement.translation)
        columns = _columns(model, axes, rotations, origins, origin)
        jacobian = ca.horzcat(columns.T, _angular(model, axes, rotations, origin.joint).T)
        turned = rotations[origin.joint] @ frame.placement.rotation
        outputs += [
            _place(rotations, origins, origin),
            ca.reshape(turned.T, 9, 1),
            jacobian if follows is None else ca.mtimes(follows, jacobian),
        ]
        names += [f"position{i}", f"rotation{i}", f"jacobian{i}"]
    if follows is not None:
        slopes = [ca.mtimes(follows, slope) for slope in slopes]
    outputs += [
        ca.vertcat(*centers) if centers else ca.SX(0, 1),
        ca.horzcat(*slopes) if slopes else ca.SX(robot.nq, 0),
    ]
    dense = ca.cse([ca.densify(output) for output in outputs])
    return ca.Function("stage", [independent], dense, ["q"], [*names, "centers", "slopes"])


def _placements(model: pin.Model, axes: list[Axis], q: ca.SX) -> tuple[list[ca.SX], list[ca.SX]]:
    """Return rotation and origin of each joint's frame in the world; index 0 is the world."""
    rotations, origins = [ca.SX.eye(3)], [ca.SX.zeros(3)]
    for joint, axis in enumerate(axes, start=1):
        parent = model.parents[joint]
        fixed = model.jointPlacements[joint]
        rotation = ca.mtimes(rotations[parent], ca.sparsify(ca.DM(rounded(fixed.rotation))))
        origin = origins[parent] + ca.mtimes(rotations[parent], ca.DM(fixed.translation))
        if axis.turns:
            rotation = ca.mtimes(rotation, _turn(axis.direction, q[axis.column]))
        else:
            origin += ca.mtimes(rotation, ca.DM(axis.direction)) * q[axis.column]
        rotations.append(rotation)
        origins.append(origin)
    return rotations, origins


def _turn(axis: Vector, angle: ca.SX) -> ca.SX:
    """Return the rotation about a unit axis, Rodrigues' formula."""
    a = ca.sparsify(ca.DM(axis))
    cross = ca.sparsify(ca.DM(pin.skew(axis)))
    outer = ca.sparsify(ca.mtimes(a, a.T))
    c = ca.cos(angle)
    return c * (ca.DM.eye(3) - outer) + outer + ca.sin(angle) * cross


def _place(rotations: list[ca.SX], origins: list[ca.SX], point: BodyPoint) -> ca.SX:
    """Return where a point is in the world, shape (3,)."""
    return origins[point.joint] + ca.mtimes(
        rotations[point.joint], ca.sparsify(ca.DM(point.offset))
    )


def _columns(
    model: pin.Model,
    axes: list[Axis],
    rotations: list[ca.SX],
    origins: list[ca.SX],
    point: BodyPoint,
) -> ca.SX:
    """Return the velocity of a point per joint velocity, shape (3, n), world frame."""
    where = _place(rotations, origins, point)
    result = ca.SX(3, model.nq)
    for joint in list(model.supports[point.joint])[1:]:
        axis = axes[joint - 1]
        direction = ca.mtimes(rotations[joint], ca.sparsify(ca.DM(axis.direction)))
        arm = where - origins[joint]
        result[:, axis.column] = ca.cross(direction, arm) if axis.turns else direction
    return result


def _angular(model: pin.Model, axes: list[Axis], rotations: list[ca.SX], body: int) -> ca.SX:
    """Return the angular velocity of a body per joint velocity, shape (3, n), world frame."""
    result = ca.SX(3, model.nq)
    for joint in list(model.supports[body])[1:]:
        axis = axes[joint - 1]
        if axis.turns:
            result[:, axis.column] = ca.mtimes(rotations[joint], ca.DM(axis.direction))
    return result
