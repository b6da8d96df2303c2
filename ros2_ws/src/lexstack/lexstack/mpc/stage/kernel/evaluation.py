"""An iterate of the MPC: where inputs lead, and what that costs, in one call."""

from __future__ import annotations

import math

import numpy as np

from lexstack.compiled import compiled, entry
from lexstack.mpc.stage.kernel.barriers import sum_of, take_distances, take_limits
from lexstack.mpc.stage.kernel.chain import place
from lexstack.mpc.stage.kernel.errors import error
from lexstack.mpc.stage.kernel.values import (
    A3,
    A4,
    I1,
    I2,
    ROW,
    ROWS,
    Array,
    Chain,
    Limits,
    M,
    Places,
    Scene,
    Stages,
    Tasks,
    V,
)
from lexstack.types import Matrix, Vector


@compiled
def roll_out(u: Matrix, step: float, nodes: Matrix, q: Matrix, v: Matrix) -> None:
    """Write the states 1 to N: those of a double integrator, a differential base by quadrature.

    Args:
        u: inputs, shape (N, n).
        step: s.
        nodes: places and weights on [0, 1] of a quadrature over a stage, shape (m, 2).
        q: the first row is the start, shape (N + 1, n_q).
        v: likewise, shape (N + 1, n).
    """
    n = v.shape[1]
    first = q.shape[1] - n
    for k in range(u.shape[0]):
        for j in range(n):
            v[k + 1, j] = v[k, j] + step * u[k, j]
        for j in range(first, n):  # of a differential base, v is no coordinate's
            q[k + 1, first + j] = q[k, first + j] + step * (v[k, j] + 0.5 * step * u[k, j])
        if first:
            x, y = 0.0, 0.0
            for m in range(nodes.shape[0]):
                s = step * nodes[m, 0]
                yaw = q[k, 2] + s * (v[k, 1] + 0.5 * s * u[k, 1])
                way = step * nodes[m, 1] * (v[k, 0] + s * u[k, 0])
                x += way * math.cos(yaw)
                y += way * math.sin(yaw)
            q[k + 1, 0] = q[k, 0] + x
            q[k + 1, 1] = q[k, 1] + y


@compiled
def effort(weights: Matrix, v: Matrix, u: Matrix, previous: Vector) -> float:
    """Return the control effort H(10) of v at the states 0 to N and u, the input before apart."""
    total = 0.0
    for k in range(u.shape[0]):
        for j in range(u.shape[1]):
            before = previous[j] if k == 0 else u[k - 1, j]
            change = u[k, j] - before
            total += (
                weights[0, j] * v[k + 1, j] * v[k + 1, j]
                + weights[1, j] * u[k, j] * u[k, j]
                + weights[2, j] * change * change
            )
    return 0.5 * total


@entry(
    f"void({I2}, {A4}, {M}, {I1}, {M}, {A3}, {I1}, {V}, {V}, {M}, {V}, {A3}, {M}, {I1}, {V}, "
    f"{I2}, {I1}, {V}, {V}, float64, {M}, {V}, {M}, "
    "float64[:, ::1], float64[:, ::1], float64[:, :, :, ::1], float64[:, :, ::1], "
    "float64[:, :, ::1], float64[:, :, :, ::1], float64[::1], float64[::1])"
)
def evaluate(
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
    references: Vector,
    task_weights: Vector,
    step: float,
    nodes: Matrix,
    previous: Vector,
    u: Matrix,
    q: Matrix,
    v: Matrix,
    rotations: Array,
    origins: Array,
    points: Array,
    frames: Array,
    errors: Vector,
    costs: Vector,
) -> None:
    """Roll inputs out and write states, places, errors and costs; see ``values`` for the first.

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
        layout: with all up to ``task_weights`` ``Tasks``.
        places: see there.
        references: see there.
        task_weights: see there.
        step: length of a stage [s].
        nodes: of the quadrature of a differential base, shape (m, 2).
        previous: the input before, shape (n,).
        u: the inputs, shape (N, n).
        q: the first row is the start; the others are written, shape (N + 1, n_q).
        v: likewise, shape (N + 1, n).
        rotations: with all up to ``frames`` ``Stages``; written.
        origins: written.
        points: written; the last ones are the spheres.
        frames: written.
        errors: (N, s) of each task, flat; written.
        costs: that all levels share, then of each task; written.
    """
    chain = Chain(joints, turning, fixed, bodies, offsets, attitudes)
    limits = Limits(bounded, lower, upper, weights, settings)
    scene = Scene(centers, reach, lifted, heights)
    tasks = Tasks(layout, places, references, task_weights)
    at = Stages(rotations, origins, points, frames)
    stages, first = u.shape[0], bodies.size - reach.shape[0]
    work = np.empty((2, 3, 3))
    inside, near = (0.0, 0.0, 1.0), (0.0, 0.0, 1.0)
    roll_out(u, step, nodes, q, v)
    costs[:] = 0.0
    for k in range(stages):
        place(chain, q[k + 1], at, k)
        inside = take_limits(limits, q[k + 1], v[k + 1], u[k], inside)
        near = take_distances(scene, limits, at, k, first, near)
        for t in range(layout.shape[0]):
            rows = layout[t, ROWS]
            begin = layout[t, ROW] * stages + k * rows
            found = errors[begin : begin + rows]
            error(tasks, t, k, q[k + 1], at, work, found)
            for a in range(rows):
                costs[1 + t] += 0.5 * task_weights[begin + a] * found[a] * found[a]
    costs[0] = (
        effort(weights, v, u, previous) + settings[0] * sum_of(inside) + settings[2] * sum_of(near)
    )
