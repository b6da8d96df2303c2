"""H(9) as the paper writes it, in CasADi: for the oracle, and for the paper's own way to solve it.

Written apart from the fast path: it shares the kinematics of a stage and the configuration, nothing
else. Collision spheres are part of it; orientations of the end effector are not.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from lexstack.errors import InputError
from lexstack.mpc import (
    BarrierConfig,
    CollisionConfig,
    CollisionScene,
    HtmpcConfig,
    Kind,
    Objective,
    stage_function,
)
from lexstack.robots import RobotModel
from lexstack.types import Matrix, Vector

ROWS: dict[Kind, int] = {"ee_position": 3, "base_position": 2, "base_pose": 3}
"""The kinds of tasks that are written here, and the length of their errors."""


@dataclass(frozen=True, slots=True)
class Symbols:
    """The program of one robot with given tasks, over the inputs alone or over states too.

    Attributes:
        x: states 1 to N, q above v, shape (n_q + n, N).
        u: inputs, shape (n, N).
        start: q, v and the input before, shape (n_q + 2 n, 1).
        references: of each task, shape (s, N).
        obstacles: centres at the states 1 to N, shape (3 o, N).
        gaps: x_{k+1} less what ``stepped`` makes of x_k and u_k, shape (n_q + n, N).
        errors: of each task, shape (s, N).
        costs: J of each task, H(8).
        shared_cost: effort H(10) and all barriers.
        rooms: what is left of the distances H(7c), shape (r, 1).
        smooth: ``shared_cost`` without the barriers of the distances.
    """

    x: ca.MX
    u: ca.MX
    start: ca.MX
    references: tuple[ca.MX, ...]
    obstacles: ca.MX
    gaps: ca.MX
    errors: tuple[ca.MX, ...]
    costs: tuple[ca.MX, ...]
    shared_cost: ca.MX
    rooms: ca.MX
    smooth: ca.MX


def program(
    robot: RobotModel,
    config: HtmpcConfig,
    kinds: tuple[Kind, ...],
    spheres: tuple[int, ...] = (),
    radii: tuple[float, ...] = (),
) -> Symbols:
    """Write the program down; ``radii`` are those of the obstacles [m].

    Raises:
        InputError: a kind of task that is not written here.
    """
    for kind in kinds:
        if kind not in ROWS:
            raise InputError(f"htmpc in CasADi: kind {kind!r}; known: {', '.join(ROWS)}")
    n, size, stages = robot.n, robot.nq, config.horizon
    x, u = ca.MX.sym("x", size + n, stages), ca.MX.sym("u", n, stages)
    start = ca.MX.sym("start", size + 2 * n)
    obstacles = ca.MX.sym("obstacles", 3 * len(radii), stages)
    references = tuple(
        ca.MX.sym(f"reference{i}", ROWS[kind], stages) for i, kind in enumerate(kinds)
    )
    q, v = x[:size, :], x[size:, :]
    places = stage_function(robot, spheres).map(stages)(q)
    errors = tuple(
        (places[0] if kind == "ee_position" else q[: ROWS[kind], :]) - reference
        for kind, reference in zip(kinds, references, strict=True)
    )
    costs = tuple(_tracking(config, kind, error) for kind, error in zip(kinds, errors, strict=True))
    smooth = _effort(robot, config, v, u, start[size + n :])
    smooth += _limits(robot, config, q[size - n :, :], v, u)
    rooms = _rooms(robot, config.collision, places[3], spheres, (obstacles, radii))
    shared_cost = smooth + far_barrier(config.collision, rooms) if rooms.numel() else smooth
    before = ca.horzcat(start[: size + n], x[:, :-1])
    gaps = x - ca.horzcat(
        *(stepped(robot, before[:, k], u[:, k], config.step) for k in range(stages))
    )
    return Symbols(
        x, u, start, references, obstacles, gaps, errors, costs, shared_cost, rooms, smooth
    )


def parameters_of(
    start: tuple[Vector, Vector, Vector],
    objectives: tuple[Objective, ...],
    around: CollisionScene | None,
    stages: int,
) -> list[Matrix]:
    """Return the values of start, obstacles and references in a program."""
    centers = np.zeros((0, stages)) if around is None else around.centers.reshape(stages, -1).T
    return [np.concatenate(start), centers, *(each.reference.T for each in objectives)]


def stepped(robot: RobotModel, state: ca.MX, u: ca.MX, step: float) -> ca.MX:
    """Return q above v after a stage with a constant input, shape (n_q + n, 1).

    x and y of a differential base by a sum of Gauss and Legendre over six nodes.
    """
    size = robot.nq
    q, v = state[:size], state[size:]
    if not robot.differential:
        return ca.vertcat(q + step * v + 0.5 * step * step * u, v + step * u)
    nodes, weights = np.polynomial.legendre.leggauss(6)
    x, y = q[0], q[1]
    for node, weight in zip(0.5 * step * (nodes + 1.0), 0.5 * step * weights, strict=True):
        yaw = q[2] + node * v[1] + 0.5 * node * node * u[1]
        x += weight * (v[0] + node * u[0]) * ca.cos(yaw)
        y += weight * (v[0] + node * u[0]) * ca.sin(yaw)
    rest = q[2:] + step * v[1:] + 0.5 * step * step * u[1:]
    return ca.vertcat(x, y, rest, v + step * u)


def _tracking(config: HtmpcConfig, kind: Kind, error: ca.MX) -> ca.MX:
    """Return H(8) without the state 0."""
    diagonal = weights_of(config, kind)
    return 0.5 * ca.sum1(ca.sum2(ca.DM(diagonal) * error**2))


def weights_of(config: HtmpcConfig, kind: Kind) -> Matrix:
    """Return Q at the states 1 to N - 1 and P at N, on the diagonal, shape (s, N)."""
    weights = config.ee if kind.startswith("ee") else config.base
    lengths = 2 if kind.startswith("base") else 3
    diagonal = np.empty((ROWS[kind], config.horizon))
    diagonal[:lengths, :-1], diagonal[:lengths, -1] = weights.stage, weights.terminal
    diagonal[lengths:, :-1], diagonal[lengths:, -1] = weights.stage_angle, weights.terminal_angle
    return diagonal


def _effort(robot: RobotModel, config: HtmpcConfig, v: ca.MX, u: ca.MX, previous: ca.MX) -> ca.MX:
    """Return H(10)."""
    effort, first = config.effort, robot.arm.start

    def weigh(base: float, arm: float, values: ca.MX) -> ca.MX:
        return ca.sum1(ca.DM([base] * first + [arm] * (robot.n - first)) * ca.sum2(values**2))

    changes = u - ca.horzcat(previous, u[:, :-1])
    return 0.5 * (
        weigh(effort.base_velocity, effort.arm_velocity, v)
        + weigh(effort.base_input, effort.arm_input, u)
        + weigh(effort.base_change, effort.arm_change, changes)
    )


def _limits(robot: RobotModel, config: HtmpcConfig, q: ca.MX, v: ca.MX, u: ca.MX) -> ca.MX:
    """Return the barriers of H(7d); q without what is beyond the length of chi."""
    limits, stages = robot.limits, u.size2()
    bounded = [int(i) for i in np.flatnonzero(np.isfinite(limits.position_upper))]
    total = ca.MX(0)
    for values, lower, upper in (
        (q[bounded, :], limits.position_lower[bounded], limits.position_upper[bounded]),
        (v, -limits.velocity, limits.velocity),
        (u, -limits.acceleration, limits.acceleration),
    ):
        total += barrier(config.limits, ca.repmat(ca.DM(upper), 1, stages) - values)
        total += barrier(config.limits, values - ca.repmat(ca.DM(lower), 1, stages))
    return total


def _rooms(
    robot: RobotModel,
    config: CollisionConfig,
    centers: ca.MX,
    spheres: tuple[int, ...],
    obstacles: tuple[ca.MX, tuple[float, ...]],
) -> ca.MX:
    """Return what is left of each distance of H(7c), at every state, shape (r, 1)."""
    rooms = []
    where, radii = obstacles
    for i, place in enumerate(spheres):
        sphere = robot.config.spheres[place]
        center = centers[3 * i : 3 * i + 3, :]
        for j, radius in enumerate(radii):
            apart = ca.sqrt(ca.sum1((center - where[3 * j : 3 * j + 3, :]) ** 2))
            rooms.append(apart - sphere.radius - radius - config.margin)
        if config.ground and sphere.link != "base":
            rooms.append(center[2, :] - sphere.radius - config.margin)
    return ca.vec(ca.horzcat(*rooms)) if rooms else ca.MX(0, 1)


def barrier(config: BarrierConfig | CollisionConfig, room: ca.MX) -> ca.MX:
    """Return the sum of the relaxed log barriers of all entries."""
    mu, zeta = config.mu, config.zeta
    near = 0.5 * (((room - 2.0 * zeta) / zeta) ** 2 - 1.0) - np.log(zeta)
    far = -ca.log(ca.fmax(room, zeta))
    return mu * ca.sum1(ca.sum2(ca.if_else(room > zeta, far, near)))


def far_barrier(config: CollisionConfig, room: ca.MX) -> ca.MX:
    """Return the barriers of distances, which end where ``influence`` does, if it is set."""
    if not config.influence:
        return barrier(config, room)
    reach = config.influence - config.margin
    clipped = ca.fmin(room, reach)
    rest = np.log(reach) - 1.0 + clipped / reach
    return barrier(config, clipped) + config.mu * ca.sum1(ca.sum2(rest))


def curvature(config: CollisionConfig, room: ca.MX) -> ca.MX:
    """Return the second derivative of the barrier of every distance."""
    second = config.mu / ca.fmax(room, config.zeta) ** 2
    if not config.influence:
        return second
    return second * (room < config.influence - config.margin)
