"""Whether a differential base can follow a trajectory: it never moves to its side."""

from __future__ import annotations

import math

import numpy as np

from lexstack.errors import InputError
from lexstack.references.base_twist import BaseTwist
from lexstack.references.trajectory import Trajectory
from lexstack.types import Vector

_SAMPLES = 200
_LONGEST = 600.0  # s, of a trajectory that never rests
_SHARE, _SLACK = 0.05, 0.01  # of the speed, and m/s: what a spline through such places may add


def check_drives(twist: BaseTwist) -> None:
    """Raise InputError for a twist that would move a differential base to its side."""
    if not twist.turning or twist.value[1] != 0.0:
        raise InputError(
            "base_target: a differential base cannot move to its side: its twist is told in the "
            "frame NAME/base, with linear.y 0"
        )


def check_along_heading(path: Trajectory[Vector], begin: float) -> None:
    """Raise InputError where a trajectory of a base moves to its side.

    Args:
        path: x, y [m], yaw [rad].
        begin: simulated time from which it holds [s].
    """
    end = path.end if math.isfinite(path.end) else begin + _LONGEST
    for stamp in np.linspace(begin, max(begin, end), _SAMPLES).tolist():
        rate = path.rate(stamp)
        if rate is None:
            continue
        yaw = float(path.at(stamp)[2])
        side = math.cos(yaw) * rate[1] - math.sin(yaw) * rate[0]
        if abs(side) > _SLACK + _SHARE * math.hypot(rate[0], rate[1]):
            raise InputError(
                f"base_target: a differential base cannot move to its side, which the trajectory "
                f"does with {side:.3g} m/s at {stamp:.3f} s: its yaw must be its direction"
            )
