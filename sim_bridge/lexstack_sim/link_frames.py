"""The frames of a robot's links in each other, as its description has them."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence

import numpy as np
import pinocchio as pin

from lexstack.robots import RobotModel
from lexstack.types import Matrix, Vector
from lexstack_sim.coordinates import following
from lexstack_sim.urdf import robot_urdf

_LEAST = 1e-9


class Joints:
    """Joints of a description, k of them, and where they put the links that they carry.

    Attributes:
        parents: names of the links that the joints stand on.
        children: names of the links that they carry.
    """

    def __init__(self, elements: Sequence[ET.Element]) -> None:
        """Read elements ``joint`` of a URDF."""
        self.parents = tuple(_text(each, "parent", "link") for each in elements)
        self.children = tuple(_text(each, "child", "link") for each in elements)
        self._slide = np.array([each.get("type") == "prismatic" for each in elements], bool)
        self._places = _rows(elements, "origin", "xyz", "0 0 0")
        rotations = [pin.rpy.rpyToMatrix(rpy) for rpy in _rows(elements, "origin", "rpy", "0 0 0")]
        axes = _rows(elements, "axis", "xyz", "1 0 0")
        # A fixed joint may have none: 0 0 0.
        self._axes = axes / np.maximum(np.linalg.norm(axes, axis=1, keepdims=True), _LEAST)
        self._turns = np.array([pin.Quaternion(r).coeffs() for r in rotations]).reshape(-1, 4)
        self._along = np.array(
            [r @ axis for r, axis in zip(rotations, self._axes, strict=True)]
        ).reshape(-1, 3)

    def at(self, values: Vector) -> tuple[Matrix, Matrix]:
        """Return where the links are in those that the joints stand on.

        Args:
            values: of the joints [m, rad], shape (k,).

        Returns:
            positions [m], shape (k, 3), and quaternions x, y, z, w, shape (k, 4).
        """
        slid = np.where(self._slide, values, 0.0)[:, None]
        half = 0.5 * np.where(self._slide, 0.0, values)[:, None]
        turned = np.concatenate([np.sin(half) * self._axes, np.cos(half)], axis=1)
        return self._places + slid * self._along, _product(self._turns, turned)


class LinkFrames:
    """The tree of links of one robot; its root is ``world``.

    Attributes:
        fixed: joints that do not move; ``fixed_at`` are their values.
        moving: the others.
    """

    def __init__(self, robot: RobotModel) -> None:
        """Read the robot's description."""
        self._robot = robot
        self._following = following(robot)
        mimics = [robot.pinocchio.names[1 + row] for row in self._following]
        places = {name: i for i, name in enumerate((*robot.coordinates, *mimics))}
        locked = robot.config.arm.fixed
        joints = ET.fromstring(robot_urdf(robot)).findall("joint")  # noqa: S314 - our own
        moving = [each for each in joints if each.get("name") in places]
        fixed = [each for each in joints if each.get("name") not in places]
        self.moving, self.fixed = Joints(moving), Joints(fixed)
        self.fixed_at: Vector = np.array([_locked_at(each, locked) for each in fixed])
        self._places = np.array([places[each.get("name", "")] for each in moving], dtype=np.intp)

    def values(self, q: Vector) -> Vector:
        """Return the values of the moving joints at the robot's q, shape (nq,)."""
        joints = self._robot.map
        if joints is not None:
            q = np.concatenate([q, joints.positions(q)[self._following]])
        return q[self._places]


def _locked_at(joint: ET.Element, locked: Mapping[str, float]) -> float:
    """Return where a joint stands that no command moves, or that follows such a joint."""
    name, leader = joint.get("name", ""), _text(joint, "mimic", "joint")
    if name in locked or not leader:
        return locked.get(name, 0.0)
    ratio = float(_text(joint, "mimic", "multiplier", "1"))
    return ratio * locked.get(leader, 0.0) + float(_text(joint, "mimic", "offset", "0"))


def _product(ones: Matrix, others: Matrix) -> Matrix:
    """Return the products of quaternions x, y, z, w, shape (k, 4)."""
    (a, b, c, d), (x, y, z, w) = ones.T, others.T
    return np.stack(
        [
            d * x + a * w + b * z - c * y,
            d * y - a * z + b * w + c * x,
            d * z + a * y - b * x + c * w,
            d * w - a * x - b * y - c * z,
        ],
        axis=1,
    )


def _rows(elements: Sequence[ET.Element], name: str, key: str, default: str) -> Matrix:
    """Return three numbers of an element below each, shape (k, 3)."""
    texts = [_text(each, name, key, default).split() for each in elements]
    return np.array(texts, dtype=np.float64).reshape(-1, 3)


def _text(element: ET.Element, name: str, key: str, default: str = "") -> str:
    """Return an attribute of the element of a name below another one."""
    found = element.find(name)
    return default if found is None else found.get(key, default)
