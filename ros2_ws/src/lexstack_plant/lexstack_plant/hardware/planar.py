"""Poses and twists of platforms in the plane."""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, sin

import numpy as np

from lexstack.types import Vector


def composed(first: Sequence[float] | Vector, second: Sequence[float] | Vector) -> Vector:
    """Return the planar pose of a frame that is at ``second`` in a frame at ``first``, (3,)."""
    c, s = cos(first[2]), sin(first[2])
    return np.array(
        [
            first[0] + c * second[0] - s * second[1],
            first[1] + s * second[0] + c * second[1],
            first[2] + second[2],
        ]
    )


def inverse(pose: Sequence[float] | Vector) -> Vector:
    """Return the planar pose of the outer frame in the one at ``pose``, shape (3,)."""
    c, s = cos(pose[2]), sin(pose[2])
    return np.array([-c * pose[0] - s * pose[1], s * pose[0] - c * pose[1], -pose[2]])


def turned(twist: Vector, angle: float) -> Vector:
    """Return a planar twist (3,) along axes that are turned by ``-angle`` [rad]."""
    c, s = cos(angle), sin(angle)
    return np.array([c * twist[0] - s * twist[1], s * twist[0] + c * twist[1], twist[2]])
