"""How x and y of a differential base follow its inputs: as in ``lexstack.mpc.unicycle_horizon``.

In stage i the base drives sum w_m V_m cos Y_m and sum w_m V_m sin Y_m, over the nodes s_m of the
quadrature. V_m moves with the input a_j by dt where j < i, and by s_m in its own stage; Y_m moves
with b_j by dt^2 (i - j - 1/2) + s_m dt, and by s_m^2 / 2. So a stage has ten sums over its nodes,
and its derivative by every input is a combination of them.
"""

from __future__ import annotations

import math

import numpy as np

from lexstack.compiled import entry
from lexstack.mpc.stage.kernel.values import Array, M
from lexstack.types import Matrix


@entry(f"void({M}, {M}, {M}, float64, {M}, float64[:, :, :, ::1])")
def drive_slopes(q: Matrix, v: Matrix, u: Matrix, step: float, nodes: Matrix, drive: Array) -> None:
    """Write d(x_k, y_k) / d(a_j, b_j), the derivatives of what ``roll_out`` sums.

    Args:
        q: states 0 to N, shape (N + 1, n + 1).
        v: likewise, shape (N + 1, n).
        u: inputs, shape (N, n).
        step: s.
        nodes: places and weights on [0, 1] of the quadrature, shape (m, 2).
        drive: shape (N, 2, N, 2); written.
    """
    stages = u.shape[0]
    drive[:] = 0.0
    along = np.empty((2, 2))  # sums of w (cos, sin) s^0 and s^1
    across = np.empty((2, 3))  # sums of w V (-sin, cos) s^0, s^1 and s^2
    for i in range(stages):
        along[:] = 0.0
        across[:] = 0.0
        for m in range(nodes.shape[0]):
            s, weight = step * nodes[m, 0], step * nodes[m, 1]
            yaw = q[i, 2] + s * (v[i, 1] + 0.5 * s * u[i, 1])
            way = weight * (v[i, 0] + s * u[i, 0])
            cosine, sine = math.cos(yaw), math.sin(yaw)
            along[0, 0] += weight * cosine
            along[0, 1] += weight * cosine * s
            along[1, 0] += weight * sine
            along[1, 1] += weight * sine * s
            across[0, 0] -= way * sine
            across[0, 1] -= way * sine * s
            across[0, 2] -= way * sine * s * s
            across[1, 0] += way * cosine
            across[1, 1] += way * cosine * s
            across[1, 2] += way * cosine * s * s
        for c in range(2):
            for j in range(i):
                age = step * (i - j - 0.5)
                drive[i, c, j, 0] = drive[i - 1, c, j, 0] + step * along[c, 0]
                drive[i, c, j, 1] = drive[i - 1, c, j, 1] + step * (
                    age * across[c, 0] + across[c, 1]
                )
            drive[i, c, i, 0] = along[c, 1]
            drive[i, c, i, 1] = 0.5 * across[c, 2]
