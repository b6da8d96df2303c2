"""A level's QP by its structure: the compiled kernel, and the condensed QP for what it leaves.

It never makes the Hessian of all inputs: see ``kernel`` and docs/htmpc.md.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from functools import cache

import numpy as np

from lexstack.compiled import available
from lexstack.mpc.hard_limits import HeldLimits
from lexstack.mpc.level_problem import Quadratic
from lexstack.mpc.limited_qp import EMPTY, ActiveSet, LimitedQp, condensed_qp
from lexstack.mpc.linear_rows import LinearRows
from lexstack.types import Matrix, Vector

_UNSOLVED = 0
# About the time of ten factorisations of the interior point method, which needs 10 to 20.
_CHANGES, _CHANGES_PER_STAGE = 60, 6


@cache
def load_kernel() -> Callable[..., int] | None:
    """Return the kernel, at the first call compiled or loaded as it was compiled before.

    Without numba it is None, with a warning: every QP is condensed then.
    """
    if not available():
        warnings.warn("numba is not installed: the MPC condenses its QPs", stacklevel=2)
        return None
    from lexstack.mpc.kernel.method import solve_level  # noqa: PLC0415 - compiles it

    return solve_level


class StructuredQp:
    """One QP, and those with the same rows and Hessian that are near to it.

    Attributes:
        left: how many solves the kernel left to the condensed QP.
    """

    def __init__(
        self,
        quadratic: Quadratic,
        rows: LinearRows,
        hard: HeldLimits | None,
        u: Matrix,
        first: ActiveSet = EMPTY,
        most: int | None = None,
    ) -> None:
        """Take the QP of a level.

        Args:
            quadratic: its cost at an iterate.
            rows: the constraints of the levels above.
            hard: limits, or None.
            u: the inputs, shape (N, n).
            first: what probably holds.
            most: changes of it before the interior point method takes the active set's place.
        """
        self._most = _CHANGES + _CHANGES_PER_STAGE * len(u) if most is None else most
        self._quadratic, self._rows, self._hard, self._u = quadratic, rows, hard, u
        self._first = first
        self._condensed: LimitedQp | None = None
        self.left = 0
        program = quadratic.program
        effort = program.effort
        positions, velocities, inputs = quadratic.barriers
        stages, n = u.shape
        own = np.empty((3, stages, n))
        np.add(inputs, effort.input, out=own[0])
        np.add(velocities, effort.velocity, out=own[1])
        own[2] = positions
        coupled = [
            slopes for slopes, summed in zip(rows.slopes, rows.summed, strict=True) if not summed
        ]
        self._wide = np.array(
            [
                slopes[:, 0]
                for slopes, summed in zip(rows.slopes, rows.summed, strict=True)
                if summed
            ]
        ).reshape(-1, stages, n)
        self._slopes = np.empty((stages, 0, n))
        if coupled:
            # Contiguous, as the kernel takes them: a constant Jacobian is broadcast.
            self._slopes = np.ascontiguousarray(np.concatenate(coupled, axis=1))
        self._fixed = np.zeros((stages, n), dtype=np.bool_)
        if rows.moving is not None:
            self._fixed[:, rows.moving == 0.0] = True
        limits = np.empty((2, 3 * stages + 1, n))
        kappa = np.zeros(n)
        if hard is None:
            limits[0], limits[1] = -np.inf, np.inf
        else:
            values = hard.values(u)
            # A step of zero stays allowed, whatever rounding did to u.
            np.minimum(hard.lower - values, 0.0, out=limits[0])
            np.maximum(hard.upper - values, 0.0, out=limits[1])
            kappa = hard.kappa
        self._limits = limits
        self._parts = (np.ascontiguousarray(quadratic.coupled), own, effort.change)
        self._step, self._kappa = program.horizon.step, kappa
        # Signs of what probably holds; the kernel makes multipliers of them.
        self._held = np.zeros((3 * stages + 1, n))
        self._held[first.places[0], first.places[1]] = first.sides
        fits = first.constraints.size == rows.lower.size
        self._multipliers = self._by_stage(first.constraints if fits else np.zeros(rows.lower.size))

    def solve(self, lower: Vector, upper: Vector) -> tuple[Vector, str]:
        """Return d, shape (N n,), and the solver's word; bounds of the constraints, (g,)."""
        shape = self._u.shape
        gradient = self._quadratic.gradient.reshape(shape)
        if self._solved(gradient, np.zeros(shape), lower, upper):
            return self._direction.reshape(-1), "solved"
        condensed, word = self._other()
        return (
            (np.zeros(self._u.size), word) if condensed is None else condensed.solve(lower, upper)
        )

    def nearest(self, point: Vector, lower: Vector, upper: Vector) -> tuple[Vector, str]:
        """Return the allowed d nearest to a point (N n,) in H's metric, and the solver's word."""
        shape = self._u.shape
        if self._solved(np.zeros(shape), point.reshape(shape), lower, upper):
            return self._direction.reshape(-1), "solved"
        condensed, word = self._other()
        return (point, word) if condensed is None else condensed.nearest(point, lower, upper)

    @property
    def active_set(self) -> ActiveSet:
        """What held at the last solution."""
        if self._condensed is not None:
            return self._condensed.active_set
        places = np.array(np.nonzero(self._held))
        return ActiveSet(
            self._by_constraint(np.sign(self._multipliers)),
            places,
            np.sign(self._held[places[0], places[1]]),
        )

    def along(self, step: Vector) -> Vector:
        """Return E d for a step, shape (g,)."""
        horizon = self._quadratic.program.horizon
        positions = horizon.to_position @ step.reshape(self._u.shape)
        if self._rows.moving is not None:
            positions *= self._rows.moving
        parts = [
            np.array([np.vdot(slopes[:, 0], positions)])
            if summed
            else (slopes @ positions[:, :, None]).reshape(-1)
            for slopes, summed in zip(self._rows.slopes, self._rows.summed, strict=True)
        ]
        return np.concatenate((np.zeros(0), *parts))

    def _solved(self, gradient: Matrix, point: Matrix, lower: Vector, upper: Vector) -> bool:
        """Solve by the kernel, unless it left one of these QPs before; return whether it has."""
        call = load_kernel()
        if call is None or self.left:
            return False
        self._direction = np.empty(self._u.shape)
        return (
            call(
                self._step,
                self._kappa,
                gradient,
                point,
                *self._parts,
                self._slopes,
                self._wide,
                np.array((self._by_stage(lower), self._by_stage(upper))),
                self._limits,
                self._fixed,
                self._direction,
                self._held,
                self._multipliers,
                self._most,
            )
            != _UNSOLVED
        )

    def _other(self) -> tuple[LimitedQp | None, str]:
        """Return the condensed QP, or why there is none."""
        self.left += 1
        word = "solved"
        if self._condensed is None:
            self._condensed, word = condensed_qp(
                self._quadratic, self._rows, self._hard, self._u, self._first
            )
        return self._condensed, word

    def _by_stage(self, values: Vector) -> Vector:
        """Return values of constraints (g,) in the kernel's order: by states, then what is wide."""
        single, wide, start = [], [np.zeros(0)], 0
        stages = len(self._u)
        for slopes, summed in zip(self._rows.slopes, self._rows.summed, strict=True):
            size = 1 if summed else slopes.shape[1] * stages
            part = values[start : start + size]
            start += size
            if summed:
                wide.append(part)
            else:
                single.append(part.reshape(stages, -1))
        both = np.concatenate(single, axis=1).reshape(-1) if single else np.zeros(0)
        return np.concatenate((both, *wide))

    def _by_constraint(self, values: Vector) -> Vector:
        """Return values in the kernel's order in that of the constraints; undoes ``_by_stage``."""
        order = self._by_stage(np.arange(values.size, dtype=np.float64)).astype(np.intp)
        result = np.empty(values.size)
        result[order] = values
        return result


def structured_qp(
    quadratic: Quadratic,
    rows: LinearRows,
    hard: HeldLimits | None,
    u: Matrix,
    first: ActiveSet = EMPTY,
) -> tuple[StructuredQp, str]:
    """Return the QP of a level at inputs u (N, n), as ``condensed_qp`` does."""
    return StructuredQp(quadratic, rows, hard, u, first), "solved"
