"""Tasks of any frame and of joints: derivatives, two arms in one sequence, refusals in one line."""

from functools import cache

import numpy as np
import pytest

from lexstack.errors import InputError
from lexstack.mpc import (
    COLUMNS,
    DEFAULT_HTMPC,
    HT_ARCH,
    Change,
    Htmpc,
    Objective,
    Reach,
    SequenceRunner,
    SequenceTask,
    StageModel,
    Start,
    Task,
)
from lexstack.robots import Obstacles, Team, to_quaternion
from lexstack.types import RobotState
from support.htmpc import config, robot

# Without a base, with two arms on a torso that slides; mimicking joints and a base; continuous
# joints; a single arm.
ROBOTS = ("tiago_dual", "pr2", "kinova", "panda", "baxter")
H = 1e-6


def frames_of(which):
    names = ("left", "right") if robot(which).config.tools else ("tool",)
    return (*names, robot(which).pinocchio.frames[-4].name)


def some_q(which, count, seed=0, spread=0.4):
    model = robot(which)
    limits, home = model.limits, model.home((0.3, -0.2, 0.5))
    q = home + np.random.default_rng(seed).uniform(-spread, spread, (count, model.nq))
    return np.clip(q, limits.position_lower, limits.position_upper)


def objective_of(which, kind, stages, seed=3):
    """Return a task with a random reference, on a frame that is not the tool."""
    rng, model = np.random.default_rng(seed), robot(which)
    columns = COLUMNS[kind] or 2
    joints = model.config.arm.joints[2::-2][:2] if kind == "joint_positions" else ()
    frame = frames_of(which)[-1] if kind.startswith("ee") else "tool"
    reference = rng.normal(size=(stages, columns))
    return Objective("t", kind, reference, frame=frame, joints=joints)


def kinds_of(which):
    return [kind for kind in COLUMNS if robot(which).has_base or not kind.startswith("base")]


@pytest.mark.parametrize("which", ROBOTS)
def test_every_frame_is_that_of_pinocchio(which):
    model, names = robot(which), frames_of(which)
    q = some_q(which, 4)
    at = StageModel(model, 4, (), names).at(q)
    assert tuple(at.frames) == names
    for name in names:
        for k in range(4):
            pose, jacobian = model.at(q[k], model.frame(name))
            np.testing.assert_allclose(at.frames[name].position[k], pose.position, atol=1e-12)
            np.testing.assert_allclose(at.frames[name].rotation[k], pose.rotation, atol=1e-12)
            np.testing.assert_allclose(at.frames[name].jacobian[k], jacobian, atol=1e-12)


@pytest.mark.parametrize("which", ROBOTS)
def test_jacobians_of_errors_are_those_of_differences(which):
    model, own = robot(which), config(horizon=3)
    for kind in kinds_of(which):
        objective = objective_of(which, kind, 3)
        task = Task(objective, own, model)
        stages = StageModel(model, 3, (), (task.frame,) if task.frame else ())
        q = some_q(which, 3)
        jacobian = task.jacobian(stages.at(q))
        assert jacobian.shape == (3, task.tolerance.size, model.nq)
        for column in range(model.nq):
            h = H * np.eye(model.nq)[column]
            slope = (task.error(stages.at(q + h)) - task.error(stages.at(q - h))) / (2 * H)
            np.testing.assert_allclose(slope, jacobian[:, :, column], atol=2e-8 / H * 1e-2)


@pytest.mark.parametrize("which", ROBOTS)
def test_gradient_and_gauss_newton_terms_are_those_of_differences(which):
    model, own = robot(which), config(horizon=4, hard_limits=False)
    solver = Htmpc(model, own, ())
    rng = np.random.default_rng(1)
    start = Start(0.0, some_q(which, 1)[0], 0.2 * rng.normal(size=model.n))
    for kind in kinds_of(which):
        task = Task(objective_of(which, kind, 4), own, model)
        program = solver.program(start, frames=(task.frame,) if task.frame else ())
        u = 0.3 * rng.normal(size=(4, model.n))
        iterate = program.iterate(u)
        quadratic = program.quadratic(iterate, task)
        errors = []
        for _ in range(5):
            d = rng.normal(size=u.shape)
            there, back = (program.iterate(u + s * H * d) for s in (1, -1))
            slope = (program.cost(there, task) - program.cost(back, task)) / (2 * H)
            assert slope == pytest.approx(quadratic.gradient @ d.ravel(), rel=1e-5, abs=1e-5), kind
            turned = (task.error(there.at) - task.error(back.at)) / (2 * H)
            errors.append((d, turned))
        # The task's part of the Hessian is J^T W J: what is left without it is the same for all.
        plain = solver.program(start, frames=(task.frame,) if task.frame else ())
        light = Task(task.objective, own, model)
        light.weights = 2.0 * task.weights
        double = plain.quadratic(plain.iterate(u), light)
        part = double.hessian - quadratic.hessian
        for d, turned in errors:
            by_hand = np.vdot(task.weights * turned, turned)
            assert d.ravel() @ part @ d.ravel() == pytest.approx(by_hand, rel=1e-5), kind


@cache
def team_of(which):
    return Team((robot(which),), dt=0.1)


def executed(which, tasks, seconds):
    """Return the states and the progress of a sequence on an ideal plant."""
    team = team_of(which)
    runner = SequenceRunner(team, 0, DEFAULT_HTMPC)
    state = RobotState.at_rest(team.home())
    runner.begin(tasks, HT_ARCH, state)
    states, told = [state], []
    while state.stamp < seconds:
        told.append(runner.step(state))
        if told[-1].sequence.done:
            break
        q, v, _ = told[-1].plan.sample(state.stamp + team.dt)
        tick = state.tick + 1
        state = RobotState(tick, tick * team.dt, q, v, q, v)
        states.append(state)
    return states, told


@pytest.mark.parametrize("which", ["tiago_dual", "pr2", "baxter"])
def test_two_arms_bring_both_tools_to_two_targets_in_one_sequence(which):
    model = robot(which)
    home = model.home()
    goals = {}
    for name, out in (("left", [0.1, 0.1, 0.1]), ("right", [0.1, -0.1, -0.1])):
        pose = model.at(home, model.frame(name))[0]
        goals[name] = tuple(pose.position + np.array(out))
    # The first one stays in the window for 2 s at its goal: long enough for the second one.
    tasks = (
        SequenceTask("give", "ee_position", (goals["left"],), frame="left", dwell=2.0),
        SequenceTask("take", "ee_position", (goals["right"],), frame="right", dwell=0.5),
    )
    states, told = executed(which, tasks, 10.0)
    assert told[-1].sequence.done
    assert all(each.plan.solved for each in told)
    both = next(i for i, each in enumerate(told) if each.sequence.first == 1)
    for name, goal in goals.items():
        place = model.at(states[both].q, model.frame(name))[0].position
        assert np.linalg.norm(place - goal) < 2e-3, name
    first = model.at(states[0].q, model.frame("right"))[0].position
    assert np.linalg.norm(first - goals["right"]) > 0.15


def test_joints_go_along_a_line_and_arrive_together():
    model = robot("tiago_dual")
    names = ("arm_right_1_joint", "torso_lift_joint")
    places = [model.joints.index(name) for name in names]
    start = model.home()[places]
    goal = tuple(start + np.array([0.6, 0.1]))
    task = SequenceTask("fold", "joint_positions", (goal,), 0.1, 0.3, 0.002, 0.002, joints=names)
    states, told = executed("tiago_dual", (task,), 10.0)
    assert told[-1].sequence.done
    q = np.array([state.q for state in states])
    np.testing.assert_allclose(q[-1, places], goal, atol=2e-3)
    others = np.setdiff1d(np.arange(model.nq), places)
    np.testing.assert_allclose(q[-1, others], q[0, others], atol=0.02)
    speeds = np.abs(np.diff(q[:, places], axis=0)).max(axis=0) / 0.1
    assert speeds[0] < 0.4, "0.3 rad/s, and a little of catching up"
    assert speeds[1] < 0.07, "0.1 m in the 2 s that the other one needs"
    assert told[-1].errors[0] < 2e-3, "of the joint that slides [m]"
    assert told[-1].errors[1] < 2e-3, "of the joint that turns [rad]"


def test_all_joints_of_the_arm_are_the_default():
    model = robot("panda")
    goal = tuple(model.home() + 0.2)
    task = SequenceTask("fold", "joint_positions", (goal,), tolerance_angle=1e-3)
    states, told = executed("panda", (task,), 5.0)
    assert told[-1].sequence.done
    np.testing.assert_allclose(states[-1].q, goal, atol=1e-3)


def test_an_orientation_is_reached_while_the_position_is_free():
    model = robot("pr2")
    q = model.home()
    turned = model.at(q + 0.2, model.frame("right"))[0].rotation
    goal = tuple(to_quaternion(turned))
    task = SequenceTask(
        "turn", "ee_orientation", (goal,), turn=0.5, tolerance_angle=0.005, frame="right"
    )
    states, told = executed("pr2", (task,), 10.0)
    assert told[-1].sequence.done
    assert told[-1].errors[0] == 0.0
    first, last = (model.at(s.q, model.frame("right"))[0].rotation for s in (states[0], states[-1]))
    assert np.arccos((np.trace(first.T @ turned) - 1) / 2) > 0.1
    assert np.arccos((np.trace(last.T @ turned) - 1) / 2) < 0.005


@pytest.mark.parametrize(
    ("which", "task", "message"),
    [
        (
            "tiago_dual",
            SequenceTask("t", "ee_position", ((1.0, 0.0, 1.0),), frame="hand"),
            "task t: frame: robot robot: no frame 'hand'; there is: ",
        ),
        (
            "tiago_dual",
            SequenceTask("t", "base_position", ((1.0, 0.0),)),
            "task t: kind: base_position: robot robot has no base",
        ),
        (
            "panda",
            SequenceTask("t", "joint_positions", ((1.0,),), joints=("elbow",)),
            r"task t: joints\[0\]: robot robot has no joint 'elbow'; known: panda_joint1, ",
        ),
        (
            "panda",
            SequenceTask("t", "joint_positions", ((1.0, 1.0),), joints=("panda_joint1",) * 2),
            r"task t: joints\[1\]: 'panda_joint1' stands twice",
        ),
        (
            "panda",
            SequenceTask("t", "joint_positions", ((1.0, 1.0),)),
            r"task 't': points\[0\]: expected 7 numbers, one per joint, got 2",
        ),
        (
            "panda",
            SequenceTask("t", "joint_positions", ((9.0,),), joints=("panda_joint1",)),
            r"task 't': points\[0\]: panda_joint1: 9 is outside its limits \[",
        ),
        (
            "baxter",
            SequenceTask("t", "ee_position", ((9.0, 0.0, 0.0),), frame="right"),
            r"task 't': points\[0\]: out of reach: right comes to ",
        ),
    ],
)
def test_what_a_robot_has_not_or_cannot_is_refused_in_one_line(which, task, message):
    with pytest.raises(InputError, match=f"^{message}") as error:
        Reach(robot(which), Obstacles({})).check([task], "ht")
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"kind": "base_pose", "points": ((0, 0, 0),), "frame": "left"}, "frame: base_pose moves"),
        ({"kind": "ee_pose", "points": ((0,) * 7,)}, r"points\[0\]: its quaternion is zero"),
        ({"kind": "ee_orientation", "points": ((0, 0, 0),)}, r"points\[0\]: expected 4 finite"),
        (
            {"kind": "ee_position", "points": ((0, 0, 0),), "joints": ("a",)},
            "joints: only for joint_positions",
        ),
        (
            {"kind": "joint_positions", "points": ((0, 0), (0,))},
            r"points\[1\]: expected 2 finite numbers",
        ),
        ({"kind": "joint_positions", "points": ((),)}, r"points\[0\]: expected 0 finite"),
    ],
)
def test_a_task_that_no_robot_has_is_refused(values, message):
    with pytest.raises(InputError, match=f"^task 't': {message}"):
        SequenceTask("t", **values)


def test_an_unknown_frame_of_an_objective_is_refused():
    solver = Htmpc(robot("panda"), config(), ())
    start = Start(0.0, robot("panda").home(), np.zeros(7))
    objective = Objective("t", "ee_position", np.zeros((10, 3)), frame="hand")
    with pytest.raises(InputError, match=r"^task t: frame: robot robot: no frame 'hand'"):
        solver.solve(start, (objective,))


def test_a_refused_sequence_or_change_changes_nothing():
    team = team_of("panda")
    runner = SequenceRunner(team, 0, DEFAULT_HTMPC)
    state = RobotState.at_rest(team.home())
    wrong = SequenceTask("t", "ee_position", ((0.4, 0.0, 0.5),), frame="hand")
    with pytest.raises(InputError, match="no frame 'hand'"):
        runner.begin((wrong,), HT_ARCH, state)
    assert runner.sequence is None


def test_a_goal_of_joints_moves_while_it_is_under_way_and_keeps_its_length():
    team = team_of("panda")
    runner = SequenceRunner(team, 0, DEFAULT_HTMPC)
    state = RobotState.at_rest(team.home())
    fold = SequenceTask("fold", "joint_positions", (tuple(team.home()),))
    runner.begin((fold,), HT_ARCH, state)
    before = runner.sequence
    with pytest.raises(InputError, match=r"points\[0\]: expected 7 numbers, one per joint, got 3"):
        runner.change(Change("retarget", "fold", ((0.1, 0.2, 0.3),)), state)
    assert runner.sequence is before
    goal = tuple(team.home() + 0.1)
    runner.change(Change("retarget", "fold", (goal,)), state)
    progress = runner.step(state)
    assert progress.errors == (0.0, pytest.approx(0.1))
