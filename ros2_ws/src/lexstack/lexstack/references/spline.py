"""Splines of bases and joints: through values at times, at rest before and after.

The spline has degree 5 and no velocity or acceleration at either end, so that position, velocity
and acceleration are continuous for all times. It is scipy's; pink, mink and placo leave
interpolation between targets to their users. Where velocities are given too, it is the quintic of
``hermite``. It may then begin in motion, as one that is planned on the way does: before its first
time it goes straight on.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from lexstack.errors import InputError
from lexstack.options import shown
from lexstack.references.hermite import hermite
from lexstack.types import Matrix, Vector

_LONGEST = 1e6  # s, of a trajectory


@dataclass(frozen=True, slots=True, eq=False)
class Spline:
    """A ``Trajectory`` through values at times.

    Attributes:
        times: shape (N,), N >= 2, increasing, simulated time [s].
        values: shape (N, m): m and rad.
        rates: velocities there, shape (N, m), m/s and rad/s, zero at the end; None: what is smooth.
    """

    times: Vector
    values: Matrix
    rates: Matrix | None = None
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
        rates = checked_rates(self.rates, "rates", values.shape)
        times.setflags(write=False)
        values.setflags(write=False)
        curve = quintic(times, values) if rates is None else hermite(times, values, rates)
        for name, value in (
            ("times", times),
            ("values", values),
            ("rates", rates),
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
            first, rate = np.asarray(self.values[0]), self._first
            return first if rate is None else first + (stamp - self.times[0]) * rate
        return np.asarray(self._curve(stamp))

    def rate(self, stamp: float) -> Vector | None:
        """Return the derivative at a time [s], shape (m,); None before and after."""
        if stamp <= self.times[0]:
            return self._first
        return None if stamp >= self.end else np.asarray(self._slope(stamp))

    @property
    def _first(self) -> Vector | None:
        """The velocity with which it begins, shape (m,); None: it begins at rest."""
        return self.rates[0] if self.rates is not None and self.rates[0].any() else None


def base_spline(times: Vector, places: Matrix, rates: Matrix | None = None) -> Spline:
    """Return the spline of a base through x [m], y [m], yaw [rad] at times, shape (N, 3).

    Each yaw is taken in the turn that is nearest to the one before it.

    Raises:
        InputError: times or places that make none.
    """
    places = np.array(places, dtype=np.float64)
    if places.ndim != 2 or places.shape[1] != 3:
        raise InputError(f"places: expected rows of x, y, yaw, got shape {places.shape}")
    places[:, 2] = np.unwrap(places[:, 2])
    return Spline(times, places, rates)


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


def checked_rates(values: object, name: str, shape: tuple[int, ...]) -> Matrix | None:
    """Return velocities as a new read-only array of a shape, or None for none.

    Raises:
        InputError: another shape, a number that is not finite, or a last row that is not zero.
    """
    if values is None:
        return None
    rates = np.array(values, dtype=np.float64)
    if rates.shape != shape or not np.isfinite(rates).all():
        raise InputError(f"{name}: expected finite numbers, shape {shape}, got {rates.shape}")
    if rates[-1].any():
        raise InputError(f"{name}[{len(rates) - 1}]: must be zero: the reference rests at the end")
    rates.setflags(write=False)
    return rates


def load() -> None:
    """Load what trajectories need of scipy: in the middle of a run it would be 30 late ticks."""
    import scipy.interpolate  # noqa: PLC0415
    import scipy.spatial.transform  # noqa: F401, PLC0415
