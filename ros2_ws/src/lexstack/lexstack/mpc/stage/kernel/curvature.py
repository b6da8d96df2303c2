"""Derivatives of a level's cost by the states and inputs of all stages, in one call."""

from __future__ import annotations

import numpy as np

from lexstack.compiled import compiled, entry
from lexstack.mpc.stage.kernel.barriers import push, slope
from lexstack.mpc.stage.kernel.chain import slopes
from lexstack.mpc.stage.kernel.errors import jacobian
from lexstack.mpc.stage.kernel.values import (
    A3,
    A4,
    BASE_POSE,
    COORDINATES,
    I1,
    I2,
    KIND,
    Array,
    Chain,
    Limits,
    M,
    Places,
    Scene,
    Stages,
    V,
)
from lexstack.types import Matrix, Vector


@compiled
def add_rows(
    rows: Matrix, first: int, weights: Vector, error: Vector, slant: Vector, curved: Matrix
) -> None:
    """Add J^T W e and the upper half of J^T W J, with J the rows from the first on."""
    n = rows.shape[1]
    for r in range(error.size):
        row, weight = rows[first + r], weights[r]
        force = weight * error[r]
        for a in range(n):
            if row[a] == 0.0:
                continue
            slant[a] += force * row[a]
            heavy = weight * row[a]
            for b in range(a, n):
                curved[a, b] += heavy * row[b]


@compiled
def add_spheres(
    chain: Chain,
    scene: Scene,
    limits: Limits,
    at: Stages,
    k: int,
    forces: Matrix,
    stiffness: Array,
    rows: Matrix,
    slant: Vector,
    curved: Matrix,
) -> None:
    """Add what the distances have at stage k: J^T f and the upper half of J^T K J per sphere."""
    first = chain.bodies.size - scene.reach.shape[0]
    n = slant.size
    push(scene, limits, at, k, first, forces, stiffness)
    for s in range(scene.reach.shape[0]):
        force, stiff = forces[s], stiffness[s]
        if stiff[0, 0] == 0.0 and stiff[1, 1] == 0.0 and stiff[2, 2] == 0.0:
            continue
        slopes(chain, at, k, first + s, rows)
        for a in range(n):
            x, y, z = rows[0, a], rows[1, a], rows[2, a]
            slant[a] += force[0] * x + force[1] * y + force[2] * z
            heavy_x = stiff[0, 0] * x + stiff[0, 1] * y + stiff[0, 2] * z
            heavy_y = stiff[1, 0] * x + stiff[1, 1] * y + stiff[1, 2] * z
            heavy_z = stiff[2, 0] * x + stiff[2, 1] * y + stiff[2, 2] * z
            for b in range(a, n):
                curved[a, b] += heavy_x * rows[0, b] + heavy_y * rows[1, b] + heavy_z * rows[2, b]


@compiled
def add_limits(
    limits: Limits,
    k: int,
    q: Vector,
    v: Vector,
    u: Vector,
    slant: Vector,
    forces: Array,
    stiffness: Array,
) -> None:
    """Add the slopes of positions; write those of velocities and inputs, and all curvatures.

    Args:
        limits: of the joints.
        k: the stage.
        q: there, shape (n_q,).
        v: likewise, shape (n,).
        u: likewise.
        slant: by the positions, shape (n_q,).
        forces: by velocities and inputs, shape (2, N, n).
        stiffness: by positions, velocities and inputs, shape (3, N, n).
    """
    mu, zeta, count, n = limits.settings[0], limits.settings[1], limits.bounded.size, v.size
    first = q.size - n
    for j in range(n):
        stiffness[0, k, j] = 0.0
    for i in range(limits.lower.size):
        if i < count:
            value = q[first + limits.bounded[i]]
        elif i < count + n:
            value = v[i - count]
        else:
            value = u[i - count - n]
        above, bend_above = slope(limits.upper[i] - value, mu, zeta)
        below, bend_below = slope(value - limits.lower[i], mu, zeta)
        if i < count:
            j = limits.bounded[i]
            slant[first + j] += below - above
            stiffness[0, k, j] = bend_above + bend_below
        else:
            which, j = (0, i - count) if i < count + n else (1, i - count - n)
            forces[which, k, j] = below - above
            stiffness[1 + which, k, j] = bend_above + bend_below


@entry(
    f"void({I2}, {A4}, {M}, {I1}, {M}, {A3}, {I1}, {V}, {V}, {M}, {V}, {A3}, {M}, {I1}, {V}, "
    f"{I1}, {I1}, {M}, {M}, {M}, {M}, {M}, {V}, {A4}, {A3}, {A3}, {A4}, "
    "float64[:, ::1], float64[:, :, ::1], float64[:, :, ::1], float64[:, :, ::1])"
)
def curve(
    joints: Places,
    turning: Array,
    fixed: Matrix,
    bodies: Places,
    offsets: Matrix,
    attitudes: Array,
    bounded: Places,
    lower: Vector,
    upper: Vector,
    weights: Matrix,
    settings: Vector,
    centers: Array,
    reach: Matrix,
    lifted: Places,
    heights: Vector,
    layout: Places,
    places: Places,
    task_weights: Matrix,
    errors: Matrix,
    q: Matrix,
    v: Matrix,
    u: Matrix,
    previous: Vector,
    rotations: Array,
    origins: Array,
    points: Array,
    frames: Array,
    slant: Matrix,
    curved: Array,
    forces: Array,
    stiffness: Array,
) -> None:
    """Write gradient and Gauss-Newton Hessian of a level's cost by the states and inputs.

    Args:
        joints: with all up to ``attitudes`` a ``Chain``.
        turning: see there.
        fixed: see there.
        bodies: see there.
        offsets: see there.
        attitudes: see there.
        bounded: with all up to ``settings`` ``Limits``.
        lower: see there.
        upper: see there.
        weights: see there.
        settings: see there.
        centers: with all up to ``heights`` a ``Scene``.
        reach: see there.
        lifted: see there.
        heights: see there.
        layout: of the task, shape (5,).
        places: its coordinates, if it has some.
        task_weights: shape (N, s).
        errors: shape (N, s).
        q: states 0 to N, shape (N + 1, n_q).
        v: likewise, shape (N + 1, n).
        u: inputs, shape (N, n).
        previous: the input before, shape (n,).
        rotations: with all up to ``frames`` ``Stages``.
        origins: see there.
        points: see there.
        frames: see there.
        slant: by the positions, shape (N, n_q); written.
        curved: of task and distances, by the positions twice, shape (N, n_q, n_q); written.
        forces: by velocities and inputs, shape (2, N, n); written.
        stiffness: of the limits' barriers, diagonals by positions (the last n), velocities and
            inputs, shape (3, N, n); written. The second derivative of the effort never changes.
    """
    chain = Chain(joints, turning, fixed, bodies, offsets, attitudes)
    limits = Limits(bounded, lower, upper, weights, settings)
    scene = Scene(centers, reach, lifted, heights)
    at = Stages(rotations, origins, points, frames)
    stages, n = u.shape
    size = q.shape[1]
    work = np.empty((2, 3, 3))
    rows = np.empty((6, size))
    pushes = np.empty((reach.shape[0], 3))
    springs = np.empty((reach.shape[0], 3, 3))
    slant[:] = 0.0
    curved[:] = 0.0
    kind = layout[KIND]
    for k in range(stages):
        if kind in (COORDINATES, BASE_POSE):
            for r in range(errors.shape[1]):
                a = places[r]
                slant[k, a] += task_weights[k, r] * errors[k, r]
                curved[k, a, a] += task_weights[k, r]
        else:
            begin = jacobian(chain, at, layout, k, errors[k], work, rows)
            add_rows(rows, begin, task_weights[k], errors[k], slant[k], curved[k])
        if reach.shape[0]:
            add_spheres(chain, scene, limits, at, k, pushes, springs, rows[:3], slant[k], curved[k])
        add_limits(limits, k, q[k + 1], v[k + 1], u[k], slant[k], forces, stiffness)
        for a in range(size):
            for b in range(a):
                curved[k, a, b] = curved[k, b, a]
        for j in range(n):
            before = previous[j] if k == 0 else u[k - 1, j]
            change = weights[2, j] * (u[k, j] - before)
            if k + 1 < stages:
                change -= weights[2, j] * (u[k + 1, j] - u[k, j])
            forces[0, k, j] += weights[0, j] * v[k + 1, j]
            forces[1, k, j] += weights[1, j] * u[k, j] + change
