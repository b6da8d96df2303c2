"""The piecewise quintic through values with given velocities: its jerk is continuous.

On an interval of the length h, with D = p_1 - p_0,

    p(u) = p_0 + v_0 u + a_0 u^2 / 2 + c_3 u^3 + c_4 u^4 + c_5 u^5

    c_3 =  10 D / h^3 - (6 v_0 + 4 v_1) / h^2 - (3 a_0 - a_1) / (2 h)
    c_4 = -15 D / h^4 + (8 v_0 + 7 v_1) / h^3 + (3 a_0 - 2 a_1) / (2 h^2)
    c_5 =   6 D / h^5 - 3 (v_0 + v_1) / h^4   - (a_0 - a_1) / (2 h^3)

has the positions, velocities and accelerations of its ends. The accelerations are free: they are
those for which the third derivative does not jump, and zero at both ends. That is one equation for
each point in between, and three unknowns in each.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from lexstack.types import Matrix, Vector


def hermite(times: Vector, values: Matrix, rates: Matrix) -> Any:
    """Return scipy's piecewise polynomial through values (N, m) with rates (N, m) at times (N,)."""
    from scipy.interpolate import PPoly  # noqa: PLC0415  # loads in 0.3 s: when asked

    h = np.diff(times)[:, None]
    steps = np.diff(values, axis=0)
    bends = _accelerations(h, steps, rates)
    v0, v1, a0, a1 = rates[:-1], rates[1:], bends[:-1], bends[1:]
    coefficients = (
        6.0 * steps / h**5 - 3.0 * (v0 + v1) / h**4 - (a0 - a1) / (2.0 * h**3),
        -15.0 * steps / h**4 + (8.0 * v0 + 7.0 * v1) / h**3 + (3.0 * a0 - 2.0 * a1) / (2.0 * h**2),
        10.0 * steps / h**3 - (6.0 * v0 + 4.0 * v1) / h**2 - (3.0 * a0 - a1) / (2.0 * h),
        0.5 * a0,
        v0,
        values[:-1],
    )
    return PPoly(np.array(coefficients), times)


def _accelerations(h: Matrix, steps: Matrix, rates: Matrix) -> Matrix:
    """Return the accelerations at all points, shape (N, m); ``h`` has shape (N - 1, 1)."""
    bends = np.zeros_like(rates)
    if len(rates) < 3:
        return bends
    from scipy.linalg import solve_banded  # noqa: PLC0415  # as above

    before, after = h[:-1], h[1:]
    right = 60.0 * (steps[1:] / after**3 - steps[:-1] / before**3)
    right -= (36.0 * rates[1:-1] + 24.0 * rates[2:]) / after**2
    right += (24.0 * rates[:-2] + 36.0 * rates[1:-1]) / before**2
    bands = np.zeros((3, len(right)))
    bands[0, 1:] = -3.0 / after[:-1, 0]
    bands[1] = 9.0 / before[:, 0] + 9.0 / after[:, 0]
    bands[2, :-1] = -3.0 / before[1:, 0]
    bends[1:-1] = solve_banded((1, 1), bands, right)
    return bends
