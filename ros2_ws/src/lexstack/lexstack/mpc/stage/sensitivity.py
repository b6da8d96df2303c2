"""How the positions follow the inputs, S_k = dq_k/du, by compiled code."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lexstack.mpc.double_integrator import Horizon, LinearSensitivity
from lexstack.mpc.unicycle_horizon import QUADRATURE, UnicycleHorizon, UnicycleSensitivity
from lexstack.types import Matrix

Array = NDArray[np.float64]

NO_DRIVE: Array = np.zeros((0, 2, 0, 2))
"""Of a robot without a differential base."""


class CompiledLinearSensitivity(LinearSensitivity):
    """That of the double integrator."""

    __slots__ = ()

    def rows(self, slopes: Array) -> Matrix:
        """Return rows in the inputs (N r, N n) of rows in the positions, (N, r, n)."""
        return _rows(slopes, NO_DRIVE, self.horizon.step, slopes.shape[2])


class CompiledUnicycleSensitivity(UnicycleSensitivity):
    """That of a robot on a differential base."""

    __slots__ = ()

    def rows(self, slopes: Array) -> Matrix:
        """Return rows in the inputs (N r, N n) of rows in the positions, (N, r, n + 1)."""
        return _rows(slopes, self.drive, self.horizon.step, slopes.shape[2] - 1)


def sensitivity_of(
    horizon: Horizon, q: Matrix, v: Matrix, u: Matrix
) -> CompiledLinearSensitivity | CompiledUnicycleSensitivity:
    """Return S_k at an iterate: states 0 to N, and inputs, as ``Iterate`` has them."""
    if not isinstance(horizon, UnicycleHorizon):
        return CompiledLinearSensitivity(horizon)
    stages = len(u)
    drive = np.empty((stages, 2, stages, 2))
    entries()[0](q, v, np.ascontiguousarray(u), horizon.step, QUADRATURE, drive)
    return CompiledUnicycleSensitivity(horizon, drive)


def _rows(slopes: Array, drive: Array, step: float, n: int) -> Matrix:
    """Return rows in the inputs (N r, N n) of rows in the positions, (N, r, n_q)."""
    stages, count = slopes.shape[:2]
    rows = np.empty((stages, count, stages, n))
    entries()[1](np.ascontiguousarray(slopes), drive, step, rows)
    return rows.reshape(stages * count, stages * n)


@cache
def entries() -> tuple[Any, ...]:
    """Return the compiled functions; the first call loads numba."""
    from lexstack.mpc.stage.kernel import condensing, driving  # noqa: PLC0415

    return driving.drive_slopes, condensing.condense_rows
