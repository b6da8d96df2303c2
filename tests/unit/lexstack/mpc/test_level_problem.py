"""The cost of a level, its gradient and its Hessian, against differences and CasADi."""

import casadi as ca
import numpy as np
import pytest

from lexstack.mpc import CollisionScene, Htmpc, Task
from lexstack_experiments.baselines.htmpc_casadi import program
from support.htmpc import ROBOTS, config, random_objectives, random_start, robot

SPHERES = (1, 4, 8)
RADII = (0.1, 0.2)
H = 1e-6


def problem(which, seed, obstacles=True, **changes):
    """Return a program with its tasks, an input, and what CasADi needs to say the same."""
    own = config("lexstack", horizon=5, hard_limits=False, **changes)
    solver = Htmpc(robot(which), own, SPHERES)
    rng = np.random.default_rng(seed)
    start = random_start(rng, which, wild=1.2)
    objectives = random_objectives(rng, start, solver)
    tasks = [Task(objective, own, solver.robot) for objective in objectives]
    centers = start.q[:3] + rng.uniform(-1.5, 1.5, (5, 2, 3))
    around = CollisionScene(centers, np.array(RADII)) if obstacles else None
    u = rng.normal(size=(5, solver.robot.n))
    return solver, solver.program(start, None, around), tasks, u, (start, around)


@pytest.mark.parametrize("which", ROBOTS)
@pytest.mark.parametrize("level", [0, 1])
def test_gradient_is_that_of_differences(which, level):
    _, parts, tasks, u, _ = problem(which, 1)
    gradient = parts.quadratic(parts.iterate(u), tasks[level]).gradient
    rng = np.random.default_rng(0)
    for _ in range(20):
        d = rng.normal(size=u.shape)
        there, back = (parts.cost(parts.iterate(u + s * H * d), tasks[level]) for s in (1, -1))
        assert (there - back) / (2 * H) == pytest.approx(gradient @ d.ravel(), rel=1e-5, abs=1e-6)


@pytest.mark.parametrize("which", ROBOTS)
def test_cost_gradient_and_hessian_are_those_of_casadi(which):
    """The Hessian is J^T W J of the task, and a rest that all levels share."""
    solver, parts, tasks, u, (start, around) = problem(which, 2)
    own, n = solver.config, solver.robot.n
    kinds = ("ee_position", "base_position")
    symbols = program(solver.robot, own, kinds, SPHERES, RADII)
    inputs = [symbols.x, symbols.u, symbols.start, symbols.obstacles, *symbols.references]
    iterate = parts.iterate(u)
    values = [
        np.vstack((iterate.q[1:].T, iterate.v[1:].T)),
        u.T,
        np.concatenate((start.q, start.v, np.zeros(n))),
        around.centers.reshape(5, -1).T,
        *(task.objective.reference.T for task in tasks),
    ]
    gaps = ca.Function("gaps", inputs, [symbols.gaps])(*values).full()
    assert np.abs(gaps).max() < 1e-12
    to_states = _states_by_inputs(solver.horizon, n)
    rest = []
    for level, task in enumerate(tasks):
        cost = symbols.costs[level] + symbols.shared_cost
        value, by_x, by_u = (
            part.full()
            for part in ca.Function(
                "slopes", inputs, [cost, ca.gradient(cost, symbols.x), ca.gradient(cost, symbols.u)]
            )(*values)
        )
        assert parts.cost(iterate, task) == pytest.approx(value.item(), rel=1e-10)
        gradient = to_states.T @ by_x.T.ravel() + by_u.T.ravel()
        quadratic = parts.quadratic(iterate, task)
        np.testing.assert_allclose(quadratic.gradient, gradient, rtol=1e-8, atol=1e-8)
        error = ca.vec(symbols.errors[level])
        jacobian = ca.Function("j", inputs, [ca.jacobian(error, ca.vec(symbols.x))])(*values).full()
        weights = np.diag(task.weights.ravel())
        j = jacobian @ to_states
        np.testing.assert_allclose(quadratic.hessian, quadratic.hessian.T, atol=1e-9)
        rest.append(quadratic.hessian - j.T @ weights @ j)
    np.testing.assert_allclose(rest[0], rest[1], rtol=1e-8, atol=1e-8)
    assert np.linalg.eigvalsh(rest[0]).min() > 0.0


def _states_by_inputs(horizon, n):
    """Return d(x_1 ... x_N)/d(u_0 ... u_{N-1}) by rolling unit inputs out."""
    stages = horizon.stages
    columns = []
    for column in np.eye(stages * n):
        q, v = horizon.roll_out(np.zeros(n), np.zeros(n), column.reshape(stages, n))
        columns.append(np.hstack((q[1:], v[1:])).ravel())
    return np.array(columns).T


@pytest.mark.parametrize("level", [0, 1])
def test_hessian_is_the_exact_one_where_nothing_is_left_out(level):
    """Without distances and at zero error, Gauss-Newton leaves nothing out."""
    solver, parts, tasks, u, _ = problem("ur10_ridgeback", 3, obstacles=False)
    iterate = parts.iterate(u)
    reached = [
        type(task)(
            type(task.objective)(task.objective.name, task.objective.kind, reference),
            solver.config,
            solver.robot,
        )
        for task, reference in zip(
            tasks, (iterate.at.tool.position, iterate.q[1:, :2]), strict=True
        )
    ]
    task = reached[level]
    hessian = parts.quadratic(iterate, task).hessian
    rng = np.random.default_rng(1)
    for _ in range(10):
        d = rng.normal(size=u.shape)
        there, back = (
            parts.quadratic(parts.iterate(u + s * H * d), task).gradient for s in (1, -1)
        )
        slope = (there - back) / (2 * H)
        np.testing.assert_allclose(slope, hessian @ d.ravel(), rtol=1e-4, atol=1e-3)
