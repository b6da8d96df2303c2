"""Splines of bases and joints: through values at times, at rest before and after.

The spline has degree 5 and no velocity or acceleration at either end, so that position, velocity
and acceleration are continuous for all times. It is scipy's; pink, mink and placo leave
interpolation between targets to their users.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from lexstack.errors import InputError
from lexstack.options import shown
from lexstack.types import Matrix, Vector

_LONGEST = 1e6  # s, of a trajectory


@dataclass(frozen=True, slots=True, eq=False)
class Spline:
    """A ``Trajectory`` through values at times.

    Attributes:
        times: shape (N,), N >= 2, increasing, simulated time [s].
        values: shape (N, m): m and rad.
    """

    times: Vector
    values: Matrix
    _curve: Any = field(init=False, repr=False)
    _slope: Any = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Find the spline; raises InputError for times or values that make none."""
        times = checked_times(self.times)
        values = np.array(self.values, dtype=np.float64)
        if values.ndim != 2 or len(values) != len(times) or not np.isfinite(values).all():
            raise InputError(
                f"values: expected {len(times)} rows of finite numbers, got shape {values.shape}"
            )
        times.setflags(write=False)
        values.setflags(write=False)
        curve = quintic(times, values)
        for name, value in (
            ("times", times),
            ("values", values),
            ("_curve", curve),
            ("_slope", curve.derivative()),
        ):
            object.__setattr__(self, name, value)

    @property
    def end(self) -> float:
        """The time from which it rests [s]."""
        return float(self.times[-1])

    def at(self, stamp: float) -> Vector:
        """Return the value at a time [s], shape (m,); the first one before, the last one after."""
        if stamp >= self.end:
            return np.asarray(self.values[-1])
        if stamp <= self.times[0]:
            return np.asarray(self.values[0])
        return np.asarray(self._curve(stamp))

    def rate(self, stamp: float) -> Vector | None:
        """Return the derivative at a time [s], shape (m,); None before and after."""
        if not self.times[0] < stamp < self.end:
            return None
        return np.asarray(self._slope(stamp))


def base_spline(times: Vector, places: Matrix) -> Spline:
    """Return the spline of a base through x [m], y [m], yaw [rad] at times, shape (N, 3).

    Each yaw is taken in the turn that is nearest to the one before it.

    Raises:
        InputError: times or places that make none.
    """
    places = np.array(places, dtype=np.float64)
    if places.ndim != 2 or places.shape[1] != 3:
        raise InputError(f"places: expected rows of x, y, yaw, got shape {places.shape}")
    places[:, 2] = np.unwrap(places[:, 2])
    return Spline(times, places)


def quintic(times: Vector, values: Matrix) -> Any:
    """Return scipy's spline of degree 5 through values (N, m), at rest at both ends."""
    from scipy.interpolate import make_interp_spline  # noqa: PLC0415  # loads in 0.3 s: when asked

    zeros = np.zeros(values.shape[1])
    rest = ((1, zeros), (2, zeros))
    spline = make_interp_spline(times - times[0], values, k=5, bc_type=(rest, rest))
    spline.t = spline.t + times[0]  # better conditioned from zero on
    return spline


def checked_times(values: object) -> Vector:
    """Return times as a new array, shape (N,).

    Raises:
        InputError: fewer than two, or times that do not increase.
    """
    times = np.array(values, dtype=np.float64)
    if times.ndim != 1 or times.size < 2 or not (np.abs(times) < _LONGEST).all():
        raise InputError(f"times: expected two or more finite numbers [s], got {shown(values)}")
    late = np.flatnonzero(np.diff(times) <= 0.0)
    if late.size:
        k = int(late[0]) + 1
        raise InputError(f"times[{k}]: {times[k]:g} s is not after {times[k - 1]:g} s")
    return times
