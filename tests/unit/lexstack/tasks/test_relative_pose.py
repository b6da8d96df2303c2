"""Position of one tool, and the pose of two tools that hold one object."""

import numpy as np
import pinocchio as pin
import pytest

from lexstack.errors import ConfigurationError
from lexstack.hqp import HqpProblem, make_solver
from lexstack.limits import Bounds
from lexstack.references import Motion, References
from lexstack.robots import Pose
from lexstack.tasks import (
    TASKS,
    LevelConfig,
    StackConfig,
    TaskConfig,
    build_stack,
    other_end,
    pose_error,
)
from support.scenario import random_q, state_at, team

STEP = 1e-6
BASES = (np.zeros(3), np.zeros(3))


def random_pose(rng):
    return Pose(rng.uniform(-1.0, 1.0, 3), pin.exp3(rng.uniform(-2.0, 2.0, 3)))


def random_references(rng):
    return References((random_pose(rng), random_pose(rng)), BASES)


def relative(robot="robot_a", other="robot_b", **parameters):
    values = {"other": other, "max_linear": 1e9, "max_angular": 1e9, **parameters}
    return TASKS["relative_pose"](team(), team().index(robot), values, "here")


def error_of(q, references, one=0, other=1):
    """Return e = (e_p, e_R), straight from its definition, shape (6,)."""
    tools = team().tools(q)
    goal = other_end(tools[one], references.ee[one], references.ee[other])
    return pose_error(tools[other], goal)


@pytest.mark.parametrize("seed", range(20))
def test_ee_position_is_the_linear_part_of_ee_pose(seed):
    rng = np.random.default_rng(seed)
    kinematics, references = team().kinematics(state_at(random_q(rng))), random_references(rng)
    both = {"gain": 2.0, "max_linear": 0.3}
    position = TASKS["ee_position"](team(), 1, both, "here").linearise(kinematics, references)
    pose = TASKS["ee_pose"](team(), 1, both, "here").linearise(kinematics, references)
    np.testing.assert_array_equal(position.matrix, pose.matrix[:3])
    np.testing.assert_array_equal(position.lower, pose.lower[:3])
    np.testing.assert_array_equal(position.upper, pose.upper[:3])


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("pair", [("robot_a", "robot_b"), ("robot_b", "robot_a")])
def test_the_matrix_is_the_derivative_of_the_relative_pose(pair, seed):
    rng = np.random.default_rng(seed)
    q, references = random_q(rng), random_references(rng)
    one, other = (team().index(name) for name in pair)
    matrix = relative(*pair).linearise(team().kinematics(state_at(q)), references).matrix
    for joint in range(team().n):
        ends = []
        for sign in (1.0, -1.0):
            moved = q.copy()
            moved[joint] += sign * STEP
            tools = team().tools(moved)
            goal = other_end(tools[one], references.ee[one], references.ee[other])
            ends.append((tools[other].position - goal.position, tools, goal))
        linear = (ends[0][0] - ends[1][0]) / (2.0 * STEP)
        np.testing.assert_allclose(matrix[:3, joint], linear, atol=1e-7)
        turns = [
            pin.log3(ends[0][1][i].rotation @ ends[1][1][i].rotation.T) / (2.0 * STEP)
            for i in (one, other)
        ]
        np.testing.assert_allclose(matrix[3:, joint], turns[1] - turns[0], atol=1e-7)


@pytest.mark.parametrize("seed", range(20))
def test_following_it_the_error_shrinks_at_its_gain(seed):
    """However the object moves meanwhile: |e| falls by exp(-gain t)."""
    rng = np.random.default_rng(seed)
    q, references = random_q(rng), random_references(rng)
    linear = relative(gain=3.0).linearise(team().kinematics(state_at(q)), references)
    freedom = np.eye(20) - np.linalg.pinv(linear.matrix) @ linear.matrix
    chi = np.linalg.pinv(linear.matrix) @ linear.lower + freedom @ rng.normal(size=20)
    time = 1e-6
    before, after = error_of(q, references), error_of(q + time * chi, references)
    for part in (slice(0, 3), slice(3, 6)):
        rate = np.linalg.norm(after[part]) / np.linalg.norm(before[part]) - 1.0
        assert rate / time == pytest.approx(-3.0, abs=2e-2)


@pytest.mark.parametrize("seed", range(10))
def test_references_that_move_as_one_object_leave_it_as_it_is(seed):
    rng = np.random.default_rng(seed)
    kinematics, references = team().kinematics(state_at(random_q(rng))), random_references(rng)
    turn, shift = pin.exp3(rng.uniform(-2.0, 2.0, 3)), rng.uniform(-1.0, 1.0, 3)
    moved = References(
        tuple(Pose(turn @ pose.position + shift, turn @ pose.rotation) for pose in references.ee),
        BASES,
    )
    here, there = (relative().linearise(kinematics, each) for each in (references, moved))
    np.testing.assert_allclose(here.matrix, there.matrix, atol=1e-12)
    np.testing.assert_allclose(here.lower, there.lower, atol=1e-12)


def test_it_saturates_what_it_asks_for():
    far = References(
        (Pose(np.zeros(3), np.eye(3)), Pose(np.array([90.0, 0.0, 0.0]), np.eye(3))), BASES
    )
    q = random_q(np.random.default_rng(3))
    linear = relative(max_linear=0.2, max_angular=0.1).linearise(
        team().kinematics(state_at(q)), far
    )
    assert np.linalg.norm(linear.lower[:3]) == pytest.approx(0.2, rel=1e-3)
    assert np.linalg.norm(linear.lower[3:]) < 0.1


def test_the_object_goes_where_the_level_below_takes_it():
    """Level 1 holds it, level 2 moves the controller's end: both tools move as one rigid body."""
    rng = np.random.default_rng(5)
    q = random_q(rng)
    tools = team().tools(q)
    goal = Pose(tools[0].position + np.array([0.02, -0.01, 0.03]), tools[0].rotation)
    goals = References((goal, other_end(goal, *tools)), BASES)
    stack = build_stack(
        StackConfig(
            "carry",
            "",
            (
                LevelConfig(
                    (TaskConfig("relative_pose", "robot_a", parameters={"other": "robot_b"}),)
                ),
                LevelConfig((TaskConfig("ee_pose", "robot_a", parameters={"max_linear": 9.0}),)),
            ),
        ),
        team(),
    )
    levels = stack.linearise(team().kinematics(state_at(q)), goals)
    free = Bounds(np.full(20, -100.0), np.full(20, 100.0))
    solution = make_solver("daqp").solve(HqpProblem(levels, free))
    np.testing.assert_allclose(solution.slacks, 0.0, atol=1e-9)
    moved = team().tools(q + 1e-6 * solution.chi)
    for before, after in zip(tools, moved, strict=True):
        velocity = (after.position - before.position) / 1e-6
        np.testing.assert_allclose(velocity, [0.06, -0.03, 0.09], atol=1e-4)


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({}, "here: other: 'robot_a' is the task's own robot: the task needs another one, or two"),
        ({"other_frame": "wing"}, "here: other_frame: robot robot_a: no frame 'wing'"),
        ({"frame": "wing"}, "here: frame: robot robot_a: no frame 'wing'"),
        ({"other": "robot_b", "axes": "wing"}, "here: axes: robot robot_a: no frame 'wing'"),
        ({"other": "robot_b", "mask": [False] * 6}, "here: mask: it leaves no axis"),
        ({"other": "robot_b", "gain": [1.0] * 3}, "here: gain: expected a number, 6 numbers"),
        (
            {"other": "robot_b", "pose": {"quaternion": [0.0] * 4}},
            "here: pose: quaternion: must not be zero",
        ),
        ({"other": "robot_c"}, "here: other: unknown robot 'robot_c'; known: robot_a, robot_b"),
        ({"other": "robot_a"}, "here: other: 'robot_a' is the task's own robot"),
        ({"other": "robot_b", "max_linear": 0.0}, "here: max_linear: must be finite and > 0"),
    ],
)
def test_a_wrong_pair_is_refused(parameters, message):
    with pytest.raises(ConfigurationError, match=message):
        TASKS["relative_pose"](team(), 0, parameters, "here")


@pytest.mark.parametrize("seed", range(5))
def test_references_that_move_against_each_other_move_the_goal_on_the_object(seed):
    """What is asked for besides the correction is the derivative of the other tool's goal."""
    rng = np.random.default_rng(seed)
    q, step = random_q(rng), 1e-6
    refs, twists = team().tools(random_q(rng)), rng.normal(size=(2, 6))
    motion = Motion(twists={(0, "tool"): twists[0], (1, "tool"): twists[1]})
    bases = (np.zeros(3), np.zeros(3))
    kinematics = team().kinematics(state_at(q))
    task = TASKS["relative_pose"](team(), 1, {"other": "robot_a"}, "here")
    one, other = task.robots
    still = task.linearise(kinematics, References(refs, bases))
    moving = task.linearise(kinematics, References(refs, bases, 1, motion))

    def goal(time):
        ends = [
            Pose(pose.position + time * twist[:3], pin.exp3(time * twist[3:]) @ pose.rotation)
            for pose, twist in zip(refs, twists, strict=True)
        ]
        return other_end(kinematics.tools[one], ends[one], ends[other])

    before, after = goal(-step), goal(step)
    turn = pin.log3(after.rotation @ before.rotation.T)
    expected = np.concatenate((after.position - before.position, turn)) / (2.0 * step)
    np.testing.assert_allclose(moving.lower - still.lower, expected, atol=1e-6)
    np.testing.assert_allclose(moving.correction, still.lower, atol=1e-12)


def test_references_that_move_as_one_object_ask_for_nothing_more():
    rng = np.random.default_rng(0)
    refs, twist = team().tools(random_q(rng)), rng.normal(size=6)
    lever = refs[1].position - refs[0].position
    along = np.concatenate((twist[:3] + np.cross(twist[3:], lever), twist[3:]))
    motion = Motion(twists={(0, "tool"): twist, (1, "tool"): along})
    kinematics = team().kinematics(state_at(random_q(rng)))
    task = TASKS["relative_pose"](team(), 1, {"other": "robot_a"}, "here")
    moving = task.linearise(kinematics, References(refs, (np.zeros(3),) * 2, 1, motion))
    # As seen by either robot: the task's own one comes first.
    assert np.abs(moving.feed).max() < 1e-12
