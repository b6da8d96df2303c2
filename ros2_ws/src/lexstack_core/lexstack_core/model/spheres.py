"""Collision spheres: where they are, and how fast they move along a direction, all at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from lexstack_core.config.robot import SphereConfig
from lexstack_core.errors import ModelError
from lexstack_core.linear import Matrix, Vector

Indices = NDArray[np.intp]


@dataclass(frozen=True, slots=True, eq=False)
class Spheres:
    """All spheres of all robots at one state, in the world frame.

    Attributes:
        centers: shape (s, 3), m.
        radii: shape (s,), m.
        owners: the place in the team of the robot that each sphere belongs to, shape (s,).
        moved_by: 1 where a joint of chi moves a sphere, else 0, shape (s, n).
        twists: per joint of chi the velocity of the body behind it, linear at the world's origin
            and then angular, as if that body reached there, shape (6, n).
    """

    centers: Matrix
    radii: Vector
    owners: Indices
    moved_by: Matrix
    twists: Matrix

    def rows(self, spheres: Indices, directions: Matrix) -> Matrix:
        """Return d(u . c)/dq, the rows of chi for the speed of centers c along directions u.

        A point p of a body that moves with (v, w) at the origin has the velocity v + w x p.

        Args:
            spheres: which, shape (m,).
            directions: one per sphere, shape (m, 3), world frame.

        Returns:
            shape (m, n).
        """
        wrenches = np.empty((len(spheres), 6))
        wrenches[:, :3] = directions
        wrenches[:, 3:] = np.cross(self.centers[spheres], directions)
        rows: Matrix = wrenches @ self.twists
        rows *= self.moved_by[spheres]
        return rows


class SphereModel:
    """The spheres of one kind of robot.

    Attributes:
        radii: shape (s,), m.
        names: e.g. ``panda_link3[1]``, the second sphere of that link.
        links: the link of each.
        moved_by: 1 where a joint of the robot moves a sphere, else 0, shape (s, n_robot).
    """

    def __init__(self, robot: str, model: pin.Model, configs: tuple[SphereConfig, ...]) -> None:
        """Place the spheres on the joints; raises ModelError for a link that is not there."""
        self._model = model
        self._data: pin.Data = model.createData()
        self.links = tuple(config.link for config in configs)
        self.names = tuple(
            f"{link}[{self.links[:i].count(link)}]" for i, link in enumerate(self.links)
        )
        self.radii: Vector = np.array([config.radius for config in configs])
        self.moved_by: Matrix = np.zeros((len(configs), model.nv))
        joints, centers = [], []
        for i, config in enumerate(configs):
            if not model.existFrame(config.link, pin.FrameType.BODY):
                where = f"robot {robot}: spheres[{i}].link"
                raise ModelError(f"{where}: no link {config.link!r}")
            frame = model.frames[model.getFrameId(config.link, pin.FrameType.BODY)]
            joint = frame.parentJoint
            joints.append(joint)
            centers.append(frame.placement.act(np.array(config.xyz)))
            columns = [model.joints[k].idx_v for k in model.supports[joint] if k > 0]
            self.moved_by[i, columns] = 1.0
        self._joints = sorted(set(joints))
        self._place = np.array([self._joints.index(joint) for joint in joints], dtype=np.intp)
        self._centers: Matrix = np.array(centers).reshape(-1, 3, 1)

    def at(self, q: Vector) -> tuple[Matrix, Matrix]:
        """Return the centers (s, 3) in the world frame, and ``Spheres.twists`` (6, n_robot)."""
        twists = pin.computeJointJacobians(self._model, self._data, q)
        if not self._joints:
            return np.empty((0, 3)), twists.copy()
        places = np.array([self._data.oMi[joint].homogeneous for joint in self._joints])
        chosen = places[self._place]
        centers = (chosen[:, :3, :3] @ self._centers)[:, :, 0] + chosen[:, :3, 3]
        return centers, twists.copy()
