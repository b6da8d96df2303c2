"""The cost and the hard rows of one QP, as the methods need them: values, forces, residuals."""

from __future__ import annotations

import numpy as np

from lexstack.compiled import compiled
from lexstack.mpc.kernel.schur import add_rows, along, row_values
from lexstack.mpc.kernel.values import Array, Qp, Weights


@compiled
def limit_values(qp: Qp, motion: Array, result: Array) -> None:
    """Fill the values of u, v, q and q_N + kappa v_N, shape (3 N + 1, n), from (3, N, n)."""
    _, stages, n = motion.shape
    for k in range(stages):
        for j in range(n):
            result[k, j] = motion[0, k, j]
            result[stages + k, j] = motion[1, k, j]
            result[2 * stages + k, j] = motion[2, k, j]
    for j in range(n):
        result[3 * stages, j] = motion[2, -1, j] + qp.kappa[j] * motion[1, -1, j]


@compiled
def add_limits(qp: Qp, multipliers: Array, scale: float, force: Array) -> None:
    """Add scale y of the limits, shape (3 N + 1, n), to what acts on u, v and q, (3, N, n)."""
    _, stages, n = force.shape
    for k in range(stages):
        for j in range(n):
            force[0, k, j] += scale * multipliers[k, j]
            force[1, k, j] += scale * multipliers[stages + k, j]
            force[2, k, j] += scale * multipliers[2 * stages + k, j]
    for j in range(n):
        force[1, -1, j] += scale * qp.kappa[j] * multipliers[3 * stages, j]
        force[2, -1, j] += scale * multipliers[3 * stages, j]


@compiled
def add_cost(qp: Qp, motion: Array, values: Array, scale: float, force: Array) -> None:
    """Add scale (H d) to what acts on u, v and q; ``values`` are A q of all rows, (m + w,)."""
    _, stages, n = force.shape
    weights = qp.weights
    for k in range(stages):
        for j in range(n):
            u = motion[0, k, j]
            turn = u - (motion[0, k - 1, j] if k > 0 else 0.0)
            after = motion[0, k + 1, j] - u if k + 1 < stages else 0.0
            force[0, k, j] += scale * (
                weights.inputs[k, j] * u + weights.change[j] * (turn - after)
            )
            force[1, k, j] += scale * weights.velocities[k, j] * motion[1, k, j]
            force[2, k, j] += scale * weights.positions[k, j] * motion[2, k, j]
    pull = np.zeros(values.size)
    pull[: qp.soft] = values[: qp.soft]
    add_rows(qp, pull, scale, force[2])


@compiled
def on_inputs(qp: Qp, force: Array) -> Array:
    """Return f_u + D' f_v + C' f_q, shape (N, n), 0 for fixed inputs: a residual to be small."""
    _, stages, n = force.shape
    dt = qp.dt
    result = np.empty((stages, n))
    slope = np.zeros((2, n))
    for k in range(stages - 1, -1, -1):
        for j in range(n):
            q, v = slope[0, j] + force[2, k, j], slope[1, j] + force[1, k, j]
            total = force[0, k, j] + dt * v + 0.5 * dt * dt * q
            result[k, j] = 0.0 if qp.fixed[k, j] else total
            slope[0, j], slope[1, j] = q, v + dt * q
    return result


@compiled
def rolled(qp: Qp, u: Array, motion: Array) -> None:
    """Fill u, and the v and q that it leads to from rest at 0, shape (3, N, n)."""
    stages, n = u.shape
    dt = qp.dt
    for k in range(stages):
        for j in range(n):
            q = motion[2, k - 1, j] if k > 0 else 0.0
            v = motion[1, k - 1, j] if k > 0 else 0.0
            motion[0, k, j] = u[k, j]
            motion[2, k, j] = q + dt * v + 0.5 * dt * dt * u[k, j]
            motion[1, k, j] = v + dt * u[k, j]


@compiled
def all_values(qp: Qp, motion: Array, result: Array) -> None:
    """Fill what all bounds are on: limits, then bounded rows; ``result`` of shape (M,)."""
    stages, n = qp.gradient.shape
    hard = (3 * stages + 1) * n
    limit_values(qp, motion, result[:hard].reshape(3 * stages + 1, n))
    rows = np.empty(len(qp.rows) + len(qp.wide))
    row_values(qp, motion[2], rows)
    result[hard:] = rows[qp.soft :]


@compiled
def add_multipliers(qp: Qp, y: Array, scale: float, force: Array) -> None:
    """Add scale A'y of limits and bounded rows, shape (M,), to what acts on u, v and q."""
    stages, n = qp.gradient.shape
    hard = (3 * stages + 1) * n
    add_limits(qp, y[:hard].reshape(3 * stages + 1, n), scale, force)
    rows = np.zeros(len(qp.rows) + len(qp.wide))
    rows[qp.soft :] = y[hard:]
    add_rows(qp, rows, scale, force[2])


@compiled
def steepness(qp: Qp, motion: Array, y: Array, force: Array) -> float:
    """Fill -(g + H d + A'y) as what acts on u, v and q; return its largest part by inputs."""
    force[:] = 0.0
    for k in range(len(qp.gradient)):
        for j in range(qp.kappa.size):
            force[0, k, j] = -qp.gradient[k, j]
    rows = np.empty(len(qp.rows) + len(qp.wide))
    row_values(qp, motion[2], rows)
    add_cost(qp, motion, rows, -1.0, force)
    add_multipliers(qp, y, -1.0, force)
    return float(np.abs(on_inputs(qp, force)).max())


@compiled
def value(qp: Qp, motion: Array) -> float:
    """Return g.d + d.H d / 2."""
    force = np.zeros(motion.shape)
    rows = np.empty(len(qp.rows) + len(qp.wide))
    row_values(qp, motion[2], rows)
    add_cost(qp, motion, rows, 1.0, force)
    total = along(qp.gradient, motion[0])
    for i in range(3):
        total += 0.5 * along(force[i], motion[i])
    return total


@compiled
def weighted(qp: Qp, sigma: Array) -> Weights:
    """Return the joints' weights with those of their limits, shape (3 N + 1, n), added."""
    stages = len(qp.gradient)
    own = qp.weights
    return Weights(
        own.inputs + sigma[:stages],
        own.velocities + sigma[stages : 2 * stages],
        own.positions + sigma[2 * stages : 3 * stages],
        own.last + sigma[3 * stages],
        own.change,
    )
