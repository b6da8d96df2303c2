"""Values of a robot's file that each joint has one of."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from lexstack.errors import ConfigurationError
from lexstack.options import shown

PerJoint = float | tuple[float, ...] | dict[str, float]
"""A value for each joint: the same for all, in the order of ``joints``, or by name."""

_LARGEST = float(np.finfo(np.float64).max)


def per_joint(
    value: PerJoint, joints: tuple[str, ...], default: Callable[[str], float], where: str
) -> tuple[float, ...]:
    """Return a value for each joint; raises ConfigurationError for a name that is none."""
    if isinstance(value, float):
        return (value,) * len(joints)
    if isinstance(value, tuple):
        if len(value) != len(joints):
            raise ConfigurationError(f"{where}: expected {len(joints)} values, got {len(value)}")
        return value
    for name in value:
        if name not in joints:
            raise ConfigurationError(f"{where}: {shown(name)} is no controlled joint")
    return tuple(value[name] if name in value else default(name) for name in joints)


def number(value: float) -> float:
    """Return a model's number; the largest one, pinocchio's for no limit, as infinity."""
    return math.copysign(math.inf, value) if abs(value) >= _LARGEST else float(value)


def zero(lower: float, upper: float) -> float:
    """Return 0 if it is within limits, else their middle."""
    return 0.0 if lower <= 0.0 <= upper else 0.5 * (lower + upper)
