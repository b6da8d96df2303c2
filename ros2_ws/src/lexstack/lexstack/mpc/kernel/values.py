"""What the compiled functions take: one QP by stages and joints, and their workspace."""

from __future__ import annotations

from typing import NamedTuple

from numpy import bool_, float64, int64
from numpy.typing import NDArray

Array = NDArray[float64]
Places = NDArray[int64]
Flags = NDArray[bool_]


class Weights(NamedTuple):
    """The part of the Hessian that is each joint's own: see ``riccati``.

    Attributes:
        inputs: U, shape (N, n).
        velocities: V at the states 1 to N, shape (N, n).
        positions: Q at the states 1 to N, shape (N, n).
        last: T of q_N + kappa v_N, shape (n,).
        change: W, shape (n,).
    """

    inputs: Array
    velocities: Array
    positions: Array
    last: Array
    change: Array


class Gains(NamedTuple):
    """B factored: feedback K, shape (3, N, n), and variances 1 / h, shape (N, n)."""

    feedback: Array
    variances: Array


class Qp(NamedTuple):
    """One QP in the change d of the inputs, shape (N, n), with what it leads to.

    The cost is that of ``weights``, sum (r.q)^2 / 2 over the first rows, and the gradient; it has
    limits on each u, v, q and q_N + kappa v_N, and bounds on the other rows.

    Attributes:
        dt: s.
        kappa: shape (n,), s.
        gradient: shape (N, n).
        weights: of the joints.
        rows: in the positions of one state, shape (m, n); first those of the cost.
        stages: of which state, 0 the state 1, shape (m,).
        wide: rows in the positions of all states, shape (w, N, n): bounded, after the others.
        soft: how many rows are of the cost.
        fixed: inputs that the limits leave no choice, which ``pinned`` has set; shape (N, n).
        pinned: their changes, 0 elsewhere; shape (N, n).
        low: of u, v, q, and of the last row, shape (3 N + 1, n).
        high: likewise.
        lower: of the bounded rows, shape (m - soft + w,).
        upper: likewise.
    """

    dt: float
    kappa: Array
    gradient: Array
    weights: Weights
    rows: Array
    stages: Places
    wide: Array
    soft: int
    fixed: Flags
    low: Array
    high: Array
    lower: Array
    upper: Array
