"""The bounds that an active set chooses from, in the few dimensions that they span.

With d = d_0 - H^-1 A' y, d_0 the least of the cost alone, the values of all bounded rows are

    A d = A d_0 - G y,    G = A H^-1 A' = K - T' T,    T = R^-T (S B^-1 A'),    K = A B^-1 A'

with S the cost's rows that couple joints and R the Cholesky factor of S B^-1 S' + 1: of ``schur``,
continued to the bounded rows. So neither d nor H is needed to find out which bounds hold. Limits
enter one by one, where a d exceeds them, each with one Riccati solution of its own joint.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from lexstack.compiled import compiled
from lexstack.mpc.kernel.riccati import respond_joint
from lexstack.mpc.kernel.schur import assemble, inner
from lexstack.mpc.kernel.values import Array, Gains, Places, Qp


class Pool(NamedTuple):
    """Bounded rows, at most as many as there is space for.

    Attributes:
        gram: G, shape (c, c).
        coupled: T by rows, shape (c, soft).
        places: which bound: row n + joint of a limit, or that after the last limit, shape (c,).
        of_bound: where in the pool a bound is, or -1, shape (M,).
        joined: what K takes of the first rows, those of the cost and all bounded ones:
            soft + bounded rows; the matrix of ``schur``.
    """

    gram: Array
    coupled: Array
    places: Places
    of_bound: Places
    joined: Array


@compiled
def begun(qp: Qp, gains: Gains, capacity: int) -> Pool:
    """Return the pool of all bounded rows, without limits."""
    stages, n = qp.gradient.shape
    hard = (3 * stages + 1) * n
    size = len(qp.rows) + len(qp.wide)
    bounded = size - qp.soft
    inverse = np.zeros(size)
    inverse[: qp.soft] = 1.0
    joined = np.empty((size, size))
    assemble(qp, gains, inverse, joined)
    return Pool(
        np.empty((bounded + capacity, bounded + capacity)),
        np.empty((bounded + capacity, qp.soft)),
        np.arange(hard, hard + bounded + capacity),
        np.concatenate((np.full(hard, -1), np.arange(bounded))),
        joined,
    )


@compiled
def reduce(qp: Qp, pool: Pool) -> bool:
    """Factor the cost's rows and fill G of the bounded ones; False: not positive definite."""
    size = len(pool.joined)
    matrix = pool.joined
    for i in range(size):
        row = matrix[i]
        before = row[i]
        k, last = 0, min(i, qp.soft)
        while k + 3 < last:
            a, b, c, d = matrix[k, i], matrix[k + 1, i], matrix[k + 2, i], matrix[k + 3, i]
            first, second, third, fourth = matrix[k], matrix[k + 1], matrix[k + 2], matrix[k + 3]
            for j in range(i, size):
                row[j] -= a * first[j] + b * second[j] + c * third[j] + d * fourth[j]
            k += 4
        while k < last:
            a = matrix[k, i]
            above = matrix[k]
            for j in range(i, size):
                row[j] -= a * above[j]
            k += 1
        if i < qp.soft:
            if not row[i] > 1e-15 * before:
                return False
            scale = 1.0 / np.sqrt(row[i])
            for j in range(i, size):
                row[j] *= scale
    for i in range(qp.soft, size):
        for j in range(i, size):
            pool.gram[i - qp.soft, j - qp.soft] = matrix[i, j]
            pool.gram[j - qp.soft, i - qp.soft] = matrix[i, j]
        for k in range(qp.soft):
            pool.coupled[i - qp.soft, k] = matrix[k, i]
    return True


@compiled
def add_limit(qp: Qp, gains: Gains, pool: Pool, count: int, bound: int) -> None:
    """Put a limit in place ``count`` of the pool."""
    stages, n = qp.gradient.shape
    row, joint = bound // n, bound % n
    hard = (3 * stages + 1) * n
    force, motion = np.zeros((3, stages)), np.empty((3, stages))
    if row == 3 * stages:
        force[1, stages - 1] = qp.kappa[joint]
        force[2, stages - 1] = 1.0
    else:
        force[row // stages, row % stages] = 1.0
    respond_joint(qp.dt, gains, force, motion, joint)
    size = len(qp.rows) + len(qp.wide)
    across = np.empty(size)
    for i in range(len(qp.rows)):
        across[i] = qp.rows[i, joint] * motion[2, qp.stages[i]]
    for w in range(len(qp.wide)):
        total = 0.0
        for k in range(stages):
            total += qp.wide[w, k, joint] * motion[2, k]
        across[len(qp.rows) + w] = total
    own = pool.coupled[count]
    for i in range(qp.soft):
        own[i] = across[i]
    for i in range(qp.soft):
        factor = pool.joined[i]
        value = own[i] / factor[i]
        own[i] = value
        for j in range(i + 1, qp.soft):
            own[j] -= value * factor[j]
    pool.places[count] = bound
    pool.of_bound[bound] = count
    for p in range(count + 1):
        other = pool.places[p]
        value = 0.0
        if other >= hard:
            value = across[qp.soft + other - hard]
        elif other % n == joint:
            at = other // n
            if at == 3 * stages:
                value = motion[2, stages - 1] + qp.kappa[joint] * motion[1, stages - 1]
            else:
                value = motion[at // stages, at % stages]
        if qp.soft:
            value -= inner(own, pool.coupled[p])
        pool.gram[count, p] = value
        pool.gram[p, count] = value
