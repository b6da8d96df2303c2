"""Directions: what tasks on axes of frames share."""

from __future__ import annotations

import math

import numpy as np

from lexstack.errors import ConfigurationError
from lexstack.options import Range
from lexstack.robots.options import Vector3
from lexstack.types import Matrix, Vector

_NONE = 1e-9  # shorter than this a vector has no direction


def check_direction(where: str, **values: Vector3) -> None:
    """Raise ConfigurationError for a vector without a direction."""
    for name, value in values.items():
        for i, component in enumerate(value):
            Range().check(component, f"{where}: {name}[{i}]")
        if math.hypot(*value) < _NONE:
            raise ConfigurationError(f"{where}: {name}: must not be zero, got {value}")


def unit(vector: Vector3) -> Vector:
    """Return a vector of length 1, shape (3,)."""
    return np.array(vector) / math.hypot(*vector)


def across(axis: Vector, rotation: Matrix) -> Matrix:
    """Return two orthonormal directions across a unit axis, shape (2, 3).

    They are made of the frame's own axes, so that they turn with the frame and do not jump.

    Args:
        axis: in the world, fixed in the frame, shape (3,).
        rotation: of the frame, shape (3, 3).
    """
    local = rotation.T @ axis
    helper = rotation[:, int(np.argmin(np.abs(local)))]
    first = np.cross(axis, helper)
    first /= math.sqrt(float(first @ first))
    return np.array([first, np.cross(axis, first)])


def turn_between(axis: Vector, direction: Vector) -> Vector:
    """Return the rotation vector that turns a unit axis into a unit direction, shape (3,), rad.

    Where the two are opposite, it is half a turn about any direction across.
    """
    turn = np.cross(axis, direction)
    sine, cosine = math.sqrt(float(turn @ turn)), float(axis @ direction)
    if sine < _NONE:
        if cosine > 0.0:
            return np.asarray(turn)
        return np.asarray(math.pi * across(axis, np.eye(3))[0])
    return np.asarray((math.atan2(sine, cosine) / sine) * turn)
