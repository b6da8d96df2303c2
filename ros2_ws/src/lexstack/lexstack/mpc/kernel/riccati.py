"""One joint at a time: B^-1 of effort, barriers and limits by a scalar Riccati recursion, in O(N).

A joint by itself is a double integrator. Its part B of the Hessian is the quadratic cost

    sum_k  Q_k q_k^2 + V_k v_k^2 + U_k u_k^2 + W (u_k - u_{k-1})^2  + T (q_N + kappa v_N)^2

of its inputs, so min u.B u / 2 - f.u is a linear-quadratic control problem with the state
x = (q, v, the input before) and one input:

    x_{k+1} = A x_k + b u_k,    A = [[1, dt, 0], [0, 1, 0], [0, 0, 0]],    b = (dt^2 / 2, dt, 1)

The recursion gives u_k = -K_k x_k - (b.p_{k+1} - f_k) / h_k with h_k the curvature in u_k: this is
B^-1 f in O(N). As B = L' diag(h) L with u = -K x + w for w = L u, the inputs of the closed loop
under independent noise w of variances 1 / h_k have the covariance B^-1; the covariances of its
positions are C B^-1 C', in O(N^2) and without a matrix of the inputs.

An input that is fixed has the gain 0 and the variance 0.
"""

from __future__ import annotations

import numpy as np

from lexstack.compiled import compiled
from lexstack.mpc.kernel.values import Array, Flags, Gains, Weights


@compiled
def factor(dt: float, kappa: Array, weights: Weights, fixed: Flags, gains: Gains) -> None:
    """Fill gains K, shape (3, N, n), and variances 1 / h, shape (N, n)."""
    stages, n = weights.inputs.shape
    half = 0.5 * dt * dt
    cost = np.zeros((6, n))  # P: qq, qv, vv, and with the input before: qp, vp, pp
    for j in range(n):
        cost[0, j] = weights.positions[stages - 1, j] + weights.last[j]
        cost[1, j] = kappa[j] * weights.last[j]
        cost[2, j] = weights.velocities[stages - 1, j] + kappa[j] * kappa[j] * weights.last[j]
    for k in range(stages - 1, -1, -1):
        for j in range(n):
            change = weights.change[j]
            qq, qv, vv = cost[0, j], cost[1, j], cost[2, j]
            qp, vp = cost[3, j], cost[4, j]
            along_q = half * qq + dt * qv + qp
            along_v = half * qv + dt * vv + vp
            along_p = half * qp + dt * vp + cost[5, j]
            curvature = half * along_q + dt * along_v + along_p + weights.inputs[k, j] + change
            inverse = 0.0 if fixed[k, j] else 1.0 / curvature
            by_q, by_v = along_q, dt * along_q + along_v
            gains.feedback[0, k, j] = inverse * by_q
            gains.feedback[1, k, j] = inverse * by_v
            gains.feedback[2, k, j] = -inverse * change
            gains.variances[k, j] = inverse
            cost[0, j] = qq - by_q * by_q * inverse
            cost[1, j] = dt * qq + qv - by_q * by_v * inverse
            cost[2, j] = dt * dt * qq + 2.0 * dt * qv + vv - by_v * by_v * inverse
            cost[3, j] = by_q * change * inverse
            cost[4, j] = by_v * change * inverse
            cost[5, j] = change - change * change * inverse
            if k > 0:
                cost[0, j] += weights.positions[k - 1, j]
                cost[2, j] += weights.velocities[k - 1, j]


@compiled
def respond(dt: float, gains: Gains, force: Array, motion: Array) -> None:
    """Fill B^-1 (f_u + D' f_v + C' f_q), with the velocities and positions that it leads to.

    Args:
        dt: s.
        gains: of ``factor``.
        force: f_u, f_v, f_q, shape (3, N, n).
        motion: u, and v and q at the states 1 to N, likewise.
    """
    _, stages, n = force.shape
    half = 0.5 * dt * dt
    slope = np.zeros((3, n))
    feedback, variances = gains.feedback, gains.variances
    for k in range(stages - 1, -1, -1):
        for j in range(n):
            along_q = slope[0, j] - force[2, k, j]
            along_v = slope[1, j] - force[1, k, j]
            along_u = half * along_q + dt * along_v + slope[2, j] - force[0, k, j]
            motion[0, k, j] = -variances[k, j] * along_u
            slope[0, j] = along_q - feedback[0, k, j] * along_u
            slope[1, j] = dt * along_q + along_v - feedback[1, k, j] * along_u
            slope[2, j] = -feedback[2, k, j] * along_u
    state = np.zeros((3, n))
    for k in range(stages):
        for j in range(n):
            q, v, before = state[0, j], state[1, j], state[2, j]
            u = motion[0, k, j] - (
                feedback[0, k, j] * q + feedback[1, k, j] * v + feedback[2, k, j] * before
            )
            q += dt * v + half * u
            v += dt * u
            motion[0, k, j], motion[1, k, j], motion[2, k, j] = u, v, q
            state[0, j], state[1, j], state[2, j] = q, v, u


@compiled
def covariances(dt: float, gains: Gains, result: Array) -> None:
    """Fill C B^-1 C' of every joint, shape (N, N, n)."""
    stages, n = gains.variances.shape
    half = 0.5 * dt * dt
    feedback = gains.feedback
    spread = np.zeros((6, n))  # covariance of the state: qq, qv, vv, qp, vp, pp
    state = np.empty((3, n))
    for k in range(stages):
        for j in range(n):
            a, b, c = feedback[0, k, j], feedback[1, k, j], feedback[2, k, j]
            qq, qv, vv = spread[0, j], spread[1, j], spread[2, j]
            qp, vp, pp = spread[3, j], spread[4, j], spread[5, j]
            # The input's covariances with the state, and its own variance; noise included.
            uq = -(a * qq + b * qv + c * qp)
            uv = -(a * qv + b * vv + c * vp)
            up = -(a * qp + b * vp + c * pp)
            uu = -(a * uq + b * uv + c * up) + gains.variances[k, j]
            drift = qv + dt * vv  # of q + dt v with v
            reach = uq + dt * uv  # with u
            spread[0, j] = qq + 2.0 * dt * qv + dt * dt * vv + 2.0 * half * reach + half * half * uu
            spread[1, j] = drift + dt * reach + half * uv + half * dt * uu
            spread[2, j] = vv + 2.0 * dt * uv + dt * dt * uu
            spread[3, j] = reach + half * uu
            spread[4, j] = uv + dt * uu
            spread[5, j] = uu
            state[0, j], state[1, j], state[2, j] = spread[0, j], spread[1, j], spread[3, j]
            result[k, k, j] = spread[0, j]
        for later in range(k + 1, stages):
            for j in range(n):
                q, v = state[0, j], state[1, j]
                u = -(
                    feedback[0, later, j] * q
                    + feedback[1, later, j] * v
                    + feedback[2, later, j] * state[2, j]
                )
                q += dt * v + half * u
                result[k, later, j] = q
                result[later, k, j] = q
                state[0, j], state[1, j], state[2, j] = q, v + dt * u, u


@compiled
def respond_joint(dt: float, gains: Gains, force: Array, motion: Array, joint: int) -> None:
    """Do what ``respond`` does for one joint, all shapes (3, N)."""
    stages = force.shape[1]
    half = 0.5 * dt * dt
    by_q, by_v, by_p = 0.0, 0.0, 0.0
    feedback, variances = gains.feedback, gains.variances
    for k in range(stages - 1, -1, -1):
        along_q, along_v = by_q - force[2, k], by_v - force[1, k]
        along_u = half * along_q + dt * along_v + by_p - force[0, k]
        motion[0, k] = -variances[k, joint] * along_u
        by_q = along_q - feedback[0, k, joint] * along_u
        by_v = dt * along_q + along_v - feedback[1, k, joint] * along_u
        by_p = -feedback[2, k, joint] * along_u
    q, v, before = 0.0, 0.0, 0.0
    for k in range(stages):
        u = motion[0, k] - (
            feedback[0, k, joint] * q + feedback[1, k, joint] * v + feedback[2, k, joint] * before
        )
        q += dt * v + half * u
        v += dt * u
        before = u
        motion[0, k], motion[1, k], motion[2, k] = u, v, q
