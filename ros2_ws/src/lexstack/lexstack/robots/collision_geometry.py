"""Collision spheres: where they are, and how fast they move along a direction, all at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from lexstack.errors import ModelError
from lexstack.options import shown
from lexstack.robots.joint_map import JointMap
from lexstack.robots.options import SphereConfig
from lexstack.types import Matrix, Vector

Indices = NDArray[np.intp]

_NEXT, _LAST = np.array([1, 2, 0]), np.array([2, 0, 1])  # of x, y, z
_AXES = (pin.JointModelRX, pin.JointModelRY, pin.JointModelRZ)


@dataclass(frozen=True, slots=True, eq=False)
class Spheres:
    """All spheres of all robots at one state, in the world frame.

    Attributes:
        centers: shape (s, 3), m.
        radii: shape (s,), m.
        owners: the place in the team of the robot that each sphere belongs to, shape (s,).
        moved_by: 1 where a joint moves a sphere, else 0, shape (s, n_all). The joints are those of
            chi and, of robots with mimicking joints, all that move; of a differential base x, y and
            yaw.
        twists: per joint the velocity of the body behind it, linear at the world's origin and
            then angular, as if that body reached there, shape (6, n_all).
        follows: how all joints' velocities follow chi, shape (n_all, n); None: they are chi.
    """

    centers: Matrix
    radii: Vector
    owners: Indices
    moved_by: Matrix
    twists: Matrix
    follows: Matrix | None = None

    def rows(self, spheres: Indices, directions: Matrix) -> Matrix:
        """Return d(u . c)/dq, the rows of chi for the speed of centers c along directions u.

        A point p of a body that moves with (v, w) at the origin has the velocity v + w x p.

        Args:
            spheres: which, shape (m,).
            directions: one per sphere, shape (m, 3), world frame.

        Returns:
            shape (m, n).
        """
        centers = self.centers.take(spheres, axis=0)
        wrenches = np.empty((len(spheres), 6))
        wrenches[:, :3] = directions
        # np.cross would take longer than all the rest of this.
        moments = wrenches[:, 3:]
        np.multiply(centers.take(_NEXT, axis=1), directions.take(_LAST, axis=1), out=moments)
        moments -= centers.take(_LAST, axis=1) * directions.take(_NEXT, axis=1)
        rows: Matrix = wrenches @ self.twists
        rows *= self.moved_by.take(spheres, axis=0)
        return rows if self.follows is None else rows @ self.follows


class SphereModel:
    """The spheres of one kind of robot.

    Reading the place of every body out of pinocchio costs far more than to compute it. So three
    massless joints a_k, about x, y and z, are put on each body that carries spheres. Their columns
    of the Jacobian at the world's origin are a_k and m_k = p x a_k, with p the body's origin, and
    p = sum_k (m_k.z a_k.y, m_k.x a_k.z, m_k.y a_k.x): all spheres in two matrix products.

    Attributes:
        radii: shape (s,), m.
        names: e.g. ``panda_link3[1]``, the second sphere of that link.
        links: the link of each.
        moved_by: 1 where a joint of chi moves a sphere, else 0, shape (s, n_robot).
        moved_by_all: likewise of all joints that move, mimicking ones too, shape (s, n_all).
    """

    def __init__(
        self,
        robot: str,
        model: pin.Model,
        configs: tuple[SphereConfig, ...],
        joints_of: JointMap | None = None,
        differential: bool = False,
    ) -> None:
        """Place the spheres on the joints; raises ModelError for a link that is not there.

        Args:
            robot: its name, for the texts of errors.
            model: all of its joints that move.
            configs: the spheres.
            joints_of: how these joints follow its q; None: they are q.
            differential: whether it drives with v and w, in place of the first three joints.
        """
        self.links = tuple(config.link for config in configs)
        self.names = tuple(
            f"{link}[{self.links[:i].count(link)}]" for i, link in enumerate(self.links)
        )
        self.radii: Vector = np.array([config.radius for config in configs])
        self.moved_by: Matrix = np.zeros((len(configs), model.nv))
        joints, centers = [], []
        for i, config in enumerate(configs):
            joint, center = _placed(config, model, f"robot {robot}: spheres[{i}].link")
            joints.append(joint)
            centers.append(center)
            columns = [model.joints[k].idx_v for k in model.supports[joint] if k > 0]
            self.moved_by[i, columns] = 1.0
        self._map = joints_of
        self.moved_by_all = self.moved_by
        if joints_of is not None:
            moves = (joints_of.matrix != 0.0).astype(np.float64)
            self.moved_by = np.minimum(self.moved_by @ moves, 1.0)
        if differential:
            self.moved_by = self.moved_by[:, 1:]  # what y moves, v does
        self._n = int(model.nv)
        self._turned, self._moved = _sums(joints, centers)
        self._model = _with_axes(model, sorted(set(joints)))
        self._data: pin.Data = self._model.createData()
        self._q: Vector = np.zeros(self._model.nq)

    def at(self, q: Vector) -> tuple[Matrix, Matrix]:
        """Return the centers, shape (3, s) in the world frame, and ``Spheres.twists`` (6, n_all).

        Both hold until the next call.
        """
        n, joints = self._n, self._map
        self._q[:n] = q if joints is None else joints.positions(q)
        jacobian: Matrix = pin.computeJointJacobians(self._model, self._data, self._q)
        moments, axes = jacobian[:3, n:], jacobian[3:, n:]
        places = moments.take(_LAST, axis=0)
        places *= axes.take(_NEXT, axis=0)
        centers = axes @ self._turned
        centers += places @ self._moved
        return centers, jacobian[:, :n]


def _sums(joints: list[int], centers: list[Vector]) -> tuple[Matrix, Matrix]:
    """Return what to multiply the axes and the places of all bodies by to get the centers.

    Args:
        joints: that carries each sphere.
        centers: in the joints' frames, shape (3,) each.

    Returns:
        shape (3 bodies, s) each.
    """
    bodies = sorted(set(joints))
    turned = np.zeros((3 * len(bodies), len(joints)))
    moved = np.zeros_like(turned)
    for i, (joint, center) in enumerate(zip(joints, centers, strict=True)):
        axes = slice(3 * bodies.index(joint), 3 * bodies.index(joint) + 3)
        turned[axes, i] = center
        moved[axes, i] = 1.0
    return turned, moved


def _placed(config: SphereConfig, model: pin.Model, where: str) -> tuple[int, Vector]:
    """Return the joint that carries a sphere, and its center in that joint's frame, shape (3,)."""
    if not model.existFrame(config.link, pin.FrameType.BODY):
        raise ModelError(f"{where}: no link {shown(config.link)}")
    frame = model.frames[model.getFrameId(config.link, pin.FrameType.BODY)]
    return frame.parentJoint, frame.placement.act(np.array(config.xyz))


def _with_axes(model: pin.Model, joints: list[int]) -> pin.Model:
    """Return a model with joints about x, y and z at each of these; they come last in v."""
    result = model.copy()
    for joint in joints:
        for axis in _AXES:
            name = f"{model.names[joint]}/{axis.__name__}"
            result.addJoint(joint, axis(), pin.SE3.Identity(), name)
    return result
