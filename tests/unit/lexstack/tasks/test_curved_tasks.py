"""look_at and centre_of_mass: how their rows turn is known, so that they rest at singularities."""

from functools import cache

import numpy as np
import pytest

from lexstack.control import make_controller
from lexstack.hqp.curvature import add_curvature
from lexstack.references import ReferenceSchedule
from lexstack.robots import RobotModel, Team
from lexstack.tasks import TASKS, LevelConfig, StackConfig, TaskConfig, build_stack
from lexstack.transition import TransitionConfig, TransitionOptions
from lexstack_config.resolved import load_robot
from support.scenario import CONFIG, state_at

WHOLE = [True, True, True]


@cache
def team(name="panda"):
    return Team((RobotModel(name, load_robot(CONFIG / f"robots/{name}.yaml")),), 0.01)


def start(robot, seed):
    rng, limits = np.random.default_rng(seed), team(robot).limits
    share = rng.uniform(0.2, 0.8, team(robot).n)
    lower, upper = (
        np.where(np.isfinite(x), x, y)
        for x, y in ((limits.position_lower, -1.0), (limits.position_upper, 1.0))
    )
    chi = rng.normal(size=team(robot).n)
    return lower + share * (upper - lower), chi / np.linalg.norm(chi), rng


def make(kind, robot, **parameters):
    far = {"max_angular" if kind == "look_at" else "max_linear": 1e9}
    return TASKS[kind](team(robot), 0, {"gain": 1.0, **far, **parameters}, "here")


def rows(task, robot, q):
    return task.linearise(team(robot).kinematics(state_at(q)), None)


def looking(robot, q, rng, away=1e-3):
    """Return the task for a point that is nearly where a frame's axis points to."""
    pose = team(robot).tools(q)[0]
    point = pose.position + 0.4 * (pose.rotation[:, 2] + away * rng.normal(size=3))
    return make("look_at", robot, point=point.tolist())


def weighing(robot, q, rng, away=1e-3, mask=WHOLE):
    centre, _ = team(robot).robots[0].centre_of_mass(q)
    goal = (centre + away * rng.normal(size=3)).tolist()
    return make("centre_of_mass", robot, target=goal, mask=mask)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(
    ("robot", "task_of"),
    [
        ("panda", looking),
        ("kinova", looking),
        ("panda", weighing),
        ("baxter", weighing),  # two arms on one torso, fingers that mimic
        ("tiago_dual", weighing),
        ("panda", lambda *given: weighing(*given, mask=[True, True, False])),
    ],
)
def test_the_curvature_is_that_of_half_of_the_squared_error(robot, task_of, seed):
    """B(e) = d2(|e|^2 / 2)/dq2 - J^T J near zero error, up to terms of second order in e."""
    q, chi, rng = start(robot, seed)
    task, n = task_of(robot, q, rng), team(robot).n
    h, now = 1e-3, rows(task, robot, q)

    def squared(s):
        error = rows(task, robot, q + s * chi).lower
        return 0.5 * float(error @ error)

    second = (squared(h) - 2.0 * squared(0.0) + squared(-h)) / h**2
    bent = np.zeros((n, n))
    kinematics = team(robot).kinematics(state_at(q))
    add_curvature(bent, now, now.lower, kinematics, {0: slice(0, n)})
    moved = now.matrix @ chi
    assert np.abs(bent).max() > 1e-5
    np.testing.assert_allclose(bent, bent.T, atol=1e-15)
    assert second - moved @ moved == pytest.approx(chi @ bent @ chi, abs=2e-5)


def served(task, q, seconds=15.0):
    """Return the commands of a controller with one task, shape (T, n), and how many were damped."""
    levels = (LevelConfig((task,)), LevelConfig((TaskConfig("velocity_damping"),)))
    stacks = {"s": build_stack(StackConfig("s", "", levels), team())}
    options = TransitionOptions("s", TransitionConfig(duration=1.0))
    references = ReferenceSchedule.at_home(team(), q)
    controller = make_controller(team(), stacks, options, references)
    state, found, damped = state_at(q), [], 0
    for _ in range(round(seconds / 0.01)):
        command = controller.tick(state)
        found.append(command.chi)
        damped += any(near.rows for near in command.near)
        state = state.after(command.chi, 0.01)
    return np.array(found), damped


@pytest.mark.parametrize(
    "task",
    [
        TaskConfig("centre_of_mass", parameters={"target": [0.1, 0.1, 2.0], "mask": WHOLE}),
        TaskConfig("centre_of_mass", parameters={"target": [1.0, 0.3, 0.5], "mask": WHOLE}),
        TaskConfig("look_at", parameters={"point": [0.05, 0.0, 0.9], "axis": [1.0, 0.0, 0.2]}),
    ],
)
def test_out_of_reach_it_comes_to_rest(task):
    chi, damped = served(task, team().home())
    tail = chi[-200:] / team().limits.velocity
    assert np.abs(tail).max() < 0.01
    if task.type == "centre_of_mass":
        assert damped > 50
