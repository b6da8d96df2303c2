"""The tasks: what they ask for is what brings their error to zero."""

import dataclasses

import numpy as np
import pinocchio as pin
import pytest

from lexstack.errors import ConfigurationError
from lexstack.references import References, ReferenceSchedule, Target
from lexstack.robots import Pose, RobotModel, Team
from lexstack.tasks import (
    TASKS,
    LevelConfig,
    StackConfig,
    TaskConfig,
    build_stack,
    pose_error,
    saturated,
)
from lexstack_config.parts import build_references
from support.scenario import home, random_q, resolved, state_at, team

RNG = np.random.default_rng(2)
DT = 0.01
STEP = 1e-6
NEEDED = {  # parameters without a default
    "centre_of_mass": {"target": [0.0, 0.0, 0.5]},
    "cone": {"angle": 0.5},
    "half_space": {"normal": [0.0, 0.0, 1.0]},
    "joint_coupling": {"joints": {"panda_joint1": 1.0, "panda_joint2": -2.0}},
    "look_at": {"point": [1.0, 0.0, 0.5]},
    "relative_pose": {"other": "robot_a"},
}
COUPLED = {"relative_pose"}
# Nothing to bring to zero, or not to a reference; test_collision_avoidance.py has the derivatives
# of distances, test_tasks_frames.py those of the others.
WITHOUT_ERROR = {
    "collision_avoidance",
    "velocity_damping",
    "axis_alignment",
    "centre_of_mass",
    "cone",
}
WITHOUT_ERROR |= {"frame_velocity_limit", "half_space", "joint_coupling", "look_at"}
WITHOUT_ERROR |= {"manipulability"}
WITHOUT_GAIN = {"velocity_damping", "frame_velocity_limit"}


def make(kind, robot=0, **parameters):
    return TASKS[kind](team(), robot, parameters, "here")


def references(q=None):
    if q is None:
        return build_references(resolved(), team()).at(0.0)
    return ReferenceSchedule.at_home(team(), q).at(0.0)


@pytest.mark.parametrize("kind", sorted(TASKS))
def test_every_task_has_rows_of_the_right_shape(kind):
    q = random_q(RNG)
    task = make(kind, robot=1, **NEEDED.get(kind, {}))
    linear = task.linearise(team().kinematics(state_at(q)), references())
    assert linear.name == task.name
    assert task.name.startswith(f"robot_b/{kind}")
    assert linear.matrix.shape == (linear.lower.size, team().n)
    assert linear.upper.shape == linear.lower.shape
    assert (linear.lower <= linear.upper).all()
    if kind not in COUPLED:
        assert not linear.matrix[:, :10].any(), "it concerns robot B alone"


@pytest.mark.parametrize("seed", range(10))
@pytest.mark.parametrize("kind", sorted(set(TASKS) - WITHOUT_ERROR))
def test_the_matrix_is_the_derivative_of_the_error(kind, seed):
    """Around its reference, b = gain e changes by -gain A chi: rows, signs and units agree."""
    rng = np.random.default_rng(seed)
    q, chi = random_q(rng), rng.normal(size=team().n)
    task = make(kind, robot=1, gain=2.0, **NEEDED.get(kind, {}))
    here = References(team().tools(q), tuple(q[part][:3] for part in team().slices))
    ahead, now, behind = (
        task.linearise(team().kinematics(state_at(integrated(q, h * chi))), here)
        for h in (STEP, 0.0, -STEP)
    )
    change = (ahead.lower - behind.lower) / (2.0 * STEP)
    np.testing.assert_allclose(change, -2.0 * now.matrix @ chi, atol=1e-6)
    np.testing.assert_array_equal(now.lower, now.upper)


def integrated(q, step):
    """Return q moved by a step of chi, robot by robot, as pinocchio moves it."""
    return np.concatenate(
        [
            pin.integrate(robot.pinocchio, q[part], step[part])
            for robot, part in zip(team().robots, team().slices, strict=True)
        ]
    )


@pytest.mark.parametrize("kind", sorted(TASKS))
def test_a_task_says_whose_joints_it_moves(kind):
    task = make(kind, robot=1, **NEEDED.get(kind, {}))
    linear = task.linearise(team().kinematics(state_at(random_q(RNG))), references())
    for robot, part in enumerate(team().slices):
        assert robot in task.robots or not linear.matrix[:, part].any()
    assert 1 in task.robots


@pytest.mark.parametrize("kind", sorted(TASKS))
def test_an_unknown_parameter_is_refused(kind):
    with pytest.raises(ConfigurationError, match="here: unknown key 'wrong'"):
        make(kind, wrong=1.0)


@pytest.mark.parametrize("kind", sorted(set(TASKS) - WITHOUT_GAIN))
def test_a_gain_that_is_not_positive_is_refused(kind):
    with pytest.raises(ConfigurationError, match="here: gain: must be finite and > 0"):
        make(kind, gain=0.0, **NEEDED.get(kind, {}))


@pytest.mark.parametrize("_", range(10))
def test_ee_pose_drives_the_tool_to_its_reference(_):
    """Following it exactly, the error shrinks by exp(-gain t), also from far away."""
    goal = team().tools(random_q(RNG))[0]
    q = random_q(RNG)
    target = References((goal, goal), references().base)
    task = make("ee_pose", gain=3.0, max_linear=1e6, max_angular=1e6)
    kinematics = team().kinematics(state_at(q))
    linear = task.linearise(kinematics, target)
    # Moving the pose itself with the velocity asked for, for a short time:
    step = 1e-4
    now = kinematics.tools[0]
    moved = Pose(
        now.position + step * linear.lower[:3], pin.exp3(step * linear.lower[3:]) @ now.rotation
    )
    before, after = pose_error(now, goal), pose_error(moved, goal)
    np.testing.assert_allclose(after, (1.0 - 3.0 * step) * before, atol=1e-6)


def test_ee_pose_saturates_its_speed():
    far = Pose(np.array([100.0, 0.0, 0.0]), np.diag([1.0, -1.0, -1.0]))
    linear = make("ee_pose", max_linear=0.4, max_angular=0.7).linearise(
        team().kinematics(state_at(random_q(RNG))), References((far, far), references().base)
    )
    assert np.linalg.norm(linear.lower[:3]) == pytest.approx(0.4, rel=1e-4)
    assert np.linalg.norm(linear.lower[3:]) < 0.7


def test_the_saturation_has_no_corner():
    """Its second difference is that of a smooth function everywhere, also around the limit."""
    step = 1e-3
    speeds = [float(saturated(np.array([x, 0.0, 0.0]), 0.5)[0]) for x in np.arange(0.0, 2.0, step)]
    assert np.abs(np.diff(speeds, 2)).max() / step**2 < 2.0
    assert speeds[1] == pytest.approx(step, rel=1e-5), "small errors keep their gain"


def test_base_takes_the_short_way_round():
    q = home()
    q[2] = np.pi - 0.1
    base = (np.array([0.0, 0.0, -np.pi + 0.1]), np.zeros(3))
    linear = make("base", gain=2.0).linearise(
        team().kinematics(state_at(q)), References(references().ee, base)
    )
    np.testing.assert_allclose(linear.lower, [0.0, 0.0, 0.4], atol=1e-12)


def test_base_and_posture_use_q_star_not_q():
    q, q_star = random_q(RNG), random_q(RNG)
    state = state_at(q)
    state = type(state)(state.tick, state.stamp, q, state.v, q_star, state.command)
    kinematics = team().kinematics(state)
    refs = references()
    base = make("base", gain=1.0).linearise(kinematics, refs)
    np.testing.assert_allclose(base.lower[:2], refs.base[0][:2] - q_star[:2])
    posture = make("posture", gain=1.0, target=[0.1] * 7).linearise(kinematics, refs)
    np.testing.assert_allclose(posture.lower, 0.1 - q_star[3:10])
    np.testing.assert_array_equal(posture.matrix @ np.arange(20.0), np.arange(3.0, 10.0))


def middle():
    limits = team().limits
    return 0.5 * (limits.position_lower[3:10] + limits.position_upper[3:10])


def posture_error(task, arm):
    q = home()
    q[3:10] = arm
    return task.linearise(team().kinematics(state_at(q)), references()).lower


def test_posture_goes_to_the_posture_of_the_robots_file_by_default():
    rest = team().robots[0].config.arm.posture
    assert np.abs(np.array(rest) - middle()).max() > 0.5
    np.testing.assert_array_equal(posture_error(make("posture"), rest), 0.0)


def test_posture_goes_to_mid_range_where_the_file_says_so_or_the_robot_has_no_posture():
    asked = make("posture", target="mid_range")
    np.testing.assert_allclose(posture_error(asked, middle()), 0.0, atol=1e-12)
    config = team().robots[0].config
    plain = dataclasses.replace(config, arm=dataclasses.replace(config.arm, posture=None))
    robots = (RobotModel("robot_a", plain), RobotModel("robot_b", plain))
    task = TASKS["posture"](Team(robots, 0.01), 0, {}, "here")
    np.testing.assert_allclose(posture_error(task, middle()), 0.0, atol=1e-12)


def test_posture_refuses_a_target_that_is_neither_a_list_nor_mid_range():
    with pytest.raises(ConfigurationError, match="here: target: 'middle' is not one of: mid_range"):
        make("posture", target="middle")


def test_posture_refuses_a_target_of_the_wrong_length():
    with pytest.raises(ConfigurationError, match="here: target: expected 7 values, got 2"):
        make("posture", target=[0.0, 0.0])


def test_velocity_damping_weighs_base_and_arm():
    linear = make("velocity_damping", base_cost=2.0, arm_cost=3.0).linearise(
        team().kinematics(state_at(home())), references()
    )
    np.testing.assert_array_equal(np.diag(linear.matrix[:, :10]), [2.0] * 3 + [3.0] * 7)


# ---- stacks


def stack(*levels):
    return StackConfig("test", "", tuple(LevelConfig(tuple(level)) for level in levels))


def test_a_task_without_a_robot_stands_for_every_robot():
    built = build_stack(stack([TaskConfig("ee_pose")], [TaskConfig("base", "robot_b")]), team())
    names = [[task.name for task in level.tasks] for level in built.levels]
    assert names == [["robot_a/ee_pose", "robot_b/ee_pose"], ["robot_b/base"]]


def test_a_weight_scales_the_squared_residual():
    built = build_stack(stack([TaskConfig("base", "robot_a", weight=4.0)]), team())
    plain = build_stack(stack([TaskConfig("base", "robot_a")]), team())
    kinematics, chi = team().kinematics(state_at(home())), RNG.normal(size=20)
    heavy = built.linearise(kinematics, references())[0][0].residual(chi)
    light = plain.linearise(kinematics, references())[0][0].residual(chi)
    assert heavy @ heavy == pytest.approx(4.0 * light @ light)


@pytest.mark.parametrize(
    ("levels", "message"),
    [
        ([[TaskConfig("dance")]], "unknown task 'dance'; known: axis_alignment, base, "),
        ([[TaskConfig("base", "robot_c")]], "unknown robot 'robot_c'"),
        ([[TaskConfig("base")], [TaskConfig("base")]], "'robot_a/base' stands in it twice"),
        ([[TaskConfig("base", parameters={"gain": -1.0})]], "gain: must be finite and > 0"),
    ],
)
def test_a_wrong_stack_is_refused(levels, message):
    with pytest.raises(ConfigurationError) as error:
        build_stack(stack(*levels), team())
    assert message in str(error.value)


# ---- references


def test_targets_take_effect_at_their_time():
    schedule = build_references(resolved(), team())
    pose = Pose(np.array([1.0, 2.0, 3.0]), np.eye(3))
    schedule.add(Target(2.0, 0, base=np.array([5.0, 5.0, 0.0])))
    schedule.add(Target(1.0, 1, ee=pose))
    first = schedule.at(0.99)
    assert schedule.at(0.995) is first, "unchanged references are the same object"
    second = schedule.at(1.0)
    assert second.ee[1] is pose
    assert second.ee[0] is first.ee[0]
    np.testing.assert_array_equal(schedule.at(2.0).base[0], [5.0, 5.0, 0.0])
    np.testing.assert_array_equal(first.base[0], [0.0, -0.5, 0.0])


def test_of_two_targets_for_one_time_the_later_wins():
    schedule = build_references(resolved(), team())
    for x in (1.0, 2.0):
        schedule.add(Target(1.0, 0, base=np.array([x, 0.0, 0.0])))
    assert schedule.at(1.0).base[0][0] == 2.0
