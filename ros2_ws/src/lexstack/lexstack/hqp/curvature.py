"""Second derivatives of the tasks along the robots' chains, which Gauss-Newton leaves out.

A level with rows J and error e minimises f = |e|^2 / 2 with de/dq = -J. Its second derivative is

    J^T J + B(e)          B(e) = - sum_r e_r d2x_r/dq2

with x what the rows are the derivative of. For a frame that a chain of joints moves, with the axis
w_i of joint i (0 for a prismatic one) and its linear column v_i of the Jacobian,

    d v_j / dq_i = w_i x v_j          d w_j / dq_i = w_i x w_j   (i < j; half of it, symmetrised)

so with a force f and a moment t along the rows, for i <= j,

    B_ij = w_i . (f x v_j + (t x w_j) / 2)

two products of small matrices, and no finite differences. The rotation between two frames a and b
turns with both of them: with the moment t on b

    B_ij = t . (w_i x w_j) / 2          i that moves a, j that moves b

The forward speed and the yaw rate of a differential base are no joints of a chain: driving along
the heading h = v_1 and turning do not commute. The derivative of h along the turn is w_2 x v_1, as
if the turn came first; that of the turn's column v_2 along the drive is 0, since the axis moves
too. Half of the first is left once symmetrised,

    B_12 = w_2 . (f x v_1) / 2

and all other pairs are those of the chain.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from lexstack.robots import Kinematics
from lexstack.types import FrameRows, LinearTask, Matrix, Vector


def add_curvature(
    into: Matrix,
    task: LinearTask,
    weights: Vector,
    kinematics: Kinematics,
    places: dict[int, slice],
) -> None:
    """Add B(e) of a task to a matrix, in place; nothing where the task is linear in the joints.

    Args:
        into: shape (r, r), over the joints of some robots.
        task: with a curve.
        weights: e of its rows, or what stands for it, shape (m,).
        kinematics: of the state at which the task was made linear.
        places: of each of these robots' joints in ``into``.
    """
    curve = task.curve
    if curve is None:
        return
    if task.frame is not None:
        own = [places[i] for i in curve.robots]
        turning = [i in kinematics.unicycles for i in curve.robots]
        _add_frame(into, task.frame, curve.scale * weights, own, turning)
        return
    for robot, columns, sign in zip(curve.robots, curve.columns, curve.signs, strict=False):
        forces = np.zeros(6)
        forces[: weights.size] = (sign * curve.scale) * weights
        linear = (sign / curve.scale) * task.matrix[:3, columns]
        here = places[robot]
        angular = kinematics.jacobians[robot][3:]
        into[here, here] += chain_curvature(linear, angular, forces)
        if robot in kinematics.unicycles:
            _add_unicycle(into[here, here], linear, angular, forces)
    if len(curve.signs) == 2 and weights.size == 6:
        one, other = curve.robots
        moment = _cross((0.5 * curve.signs[1] * curve.scale) * weights[3:])
        axes = kinematics.jacobians[one][3:], kinematics.jacobians[other][3:]
        block = axes[0].T.dot(moment).dot(axes[1])
        into[places[one], places[other]] -= block
        into[places[other], places[one]] -= block.T


def _add_frame(
    into: Matrix, frame: FrameRows, weights: Vector, places: list[slice], unicycles: list[bool]
) -> None:
    """Add B of rows that say how they come from a frame, in place.

    Args:
        into: as in ``add_curvature``.
        frame: the rows.
        weights: of them, times the scale, shape (m,).
        places: of the joints of the curve's robots.
        unicycles: whether each of these robots has a differential base.
    """
    forces, here = weights @ frame.axes, places[-1]
    linear, angular = np.split(frame.jacobian, 2)
    if frame.tree is not None:
        bent = chain_curvature(linear, angular, forces, frame.tree.carries)
        follows = frame.tree.follows
        into[here, here] += bent if follows is None else follows.T @ bent @ follows
        if unicycles[-1] and follows is not None:
            _add_unicycle(into[here, here], linear @ follows, angular @ follows, forces)
        return
    into[here, here] += chain_curvature(linear, angular, forces)
    if unicycles[-1]:
        _add_unicycle(into[here, here], linear, angular, forces)
    if frame.turning is not None:
        quadratic = np.tensordot(weights, frame.turning, 1)
        into[here, here] += frame.jacobian.T @ quadratic @ frame.jacobian
    if frame.end is not None:
        there, (end, turns) = places[0], np.split(frame.end, 2)
        into[there, there] -= chain_curvature(end, turns, forces)
        if unicycles[0]:
            _add_unicycle(into[there, there], end, turns, -forces)
        block = turns.T.dot(_cross(0.5 * forces[3:])).dot(angular)
        into[there, here] -= block
        into[here, there] -= block.T


def chain_curvature(
    linear: Matrix, axes: Matrix, forces: Vector, carries: Matrix | None = None
) -> Matrix:
    """Return B of one chain, symmetric, shape (n, n).

    Args:
        linear: the frame's linear columns v, shape (3, n), in the order of the chain.
        axes: its angular columns w, shape (3, n).
        forces: f and t, shape (6,), along the rows of the frame's Jacobian.
        carries: of a tree of joints, see ``Tree``; None: they are a chain, or what is not on it has
            no columns.
    """
    turned = _cross(forces[:3]).dot(linear)
    turned += (0.5 * _cross(forces[3:])).dot(axes)
    products: Matrix = axes.T.dot(turned)
    if carries is not None:
        products *= carries
    upper, strictly = _triangles(len(products))
    result: Matrix = products * upper
    result += (products * strictly).T
    return result


def _add_unicycle(block: Matrix, linear: Matrix, axes: Matrix, forces: Vector) -> None:
    """Add to a robot's B, in place, that turning its base turns the direction it drives in.

    Args:
        block: a view of shape (n, n), which begins with the columns of v and w.
        linear: as in ``chain_curvature``.
        axes: as there.
        forces: as there.
    """
    half = 0.5 * float(axes[:, 1].dot(_cross(forces[:3])).dot(linear[:, 0]))
    block[0, 1] += half
    block[1, 0] += half


@lru_cache(maxsize=64)
def _triangles(n: int) -> tuple[Matrix, Matrix]:
    """Return masks of the upper triangle, with and without the diagonal, read-only."""
    masks = np.triu(np.ones((n, n))), np.triu(np.ones((n, n)), 1)
    for mask in masks:
        mask.setflags(write=False)
    return masks


def _cross(vector: Vector) -> Matrix:
    """Return the matrix of ``vector x``, shape (3, 3)."""
    x, y, z = vector.tolist()
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
