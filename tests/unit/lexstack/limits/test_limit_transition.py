"""Limits that change at run time, by hand; and the limits that a stack file may carry."""

import copy
from dataclasses import replace

import numpy as np
import pytest
import yaml

from lexstack.errors import ConfigurationError
from lexstack.limits import JointLimits, LimitBlend, Motion, viable_bounds
from lexstack.tasks import StackConfig, build_stack
from lexstack_config.reader import build
from lexstack_config.resolved import ResolvedScenario
from support.scenario import CONFIG, resolved, team

DT = 0.01
FIELDS = ("position_lower", "position_upper", "velocity", "acceleration", "jerk")


def limits(lower=-2.0, upper=2.0, velocity=1.0, acceleration=10.0, jerk=np.inf):
    return JointLimits(*(np.atleast_1d(x) for x in (lower, upper, velocity, acceleration, jerk)))


def motion(q, v=0.0, a=None):
    return Motion(np.atleast_1d(q), np.atleast_1d(v), DT, None if a is None else np.atleast_1d(a))


def same(one, other):
    return all(np.array_equal(getattr(one, name), getattr(other, name)) for name in FIELDS)


# ---- one joint by hand


@pytest.mark.parametrize(
    ("q", "v", "new"),
    [
        pytest.param(0.0, 0.0, {"upper": 1.0}, id="inside, at rest"),
        pytest.param(0.0, 0.5, {"velocity": 0.1}, id="above the new velocity limit"),
        pytest.param(0.0, 0.5, {"acceleration": 1.0}, id="it can stop with less acceleration"),
        pytest.param(0.0, 0.0, {"upper": 3.0}, id="wider"),
    ],
)
def test_limits_that_can_be_kept_hold_at_once(q, v, new):
    blend = LimitBlend.begin(limits(), limits(**new), motion(q, v), 100)
    assert blend.at(100) is blend.new
    assert blend.end == 100


def test_a_joint_outside_is_driven_inside_in_the_least_time():
    # 0.45 rad at 10 rad/s^2: sqrt(2 * 0.45 / 10) = 0.3 s, if 3 rad/s are allowed; at 1 rad/s
    # 1 / 10 + (0.45 - 1 / 20) / 1 = 0.5 s
    fast = LimitBlend.begin(limits(velocity=9.0), limits(upper=0.0, velocity=9.0), motion(0.45), 0)
    slow = LimitBlend.begin(limits(), limits(upper=0.0), motion(0.45), 0)
    assert fast.end == 30
    assert slow.end == 50
    # drawn inside by v^2 / 2 a + v dt, so that there is one choice
    assert slow.at(0).position_upper.item() == pytest.approx(-0.05 - 0.01)
    box = viable_bounds(np.array([0.45]), slow.at(0), DT, np.array([0.0]))
    assert box.lower.item() == box.upper.item() == pytest.approx(-0.1)
    assert slow.at(slow.end - 1) is slow.at(0)
    assert slow.at(slow.end) is slow.new


def test_it_is_never_driven_through_the_other_limit():
    blend = LimitBlend.begin(limits(), limits(lower=-0.01, upper=0.0), motion(0.45), 0)
    assert blend.at(0).position_upper.item() == pytest.approx(-0.01)
    q, v = 0.45, 0.0
    for tick in range(200):
        box = viable_bounds(np.array([q]), blend.at(tick), DT, np.array([v]))
        v = box.lower.item()
        q += DT * v
        assert q >= -0.01 - 1e-12
    assert q <= 1e-12


def test_too_fast_for_a_smaller_acceleration_it_keeps_the_old_one_until_it_stands():
    # 1 rad/s, 0.1 rad before the limit: 0.05 rad with 10 rad/s^2, 0.5 rad with 1 rad/s^2
    blend = LimitBlend.begin(limits(), limits(acceleration=1.0), motion(1.9, 1.0), 0)
    assert blend.end == 10
    assert blend.at(9).acceleration.item() == 10.0
    box = viable_bounds(np.array([1.9]), blend.at(0), DT, np.array([1.0]))
    assert box.lower.item() == box.upper.item() == pytest.approx(0.9)


def test_in_a_given_time_the_limit_moves_from_where_the_joint_can_rest():
    new = limits(upper=0.0)
    blend = LimitBlend.begin(limits(), new, motion(0.45, 0.2), 0, duration=1.0)
    assert blend.end == 100
    ends = np.array([blend.at(tick).position_upper.item() for tick in range(101)])
    rest = 0.45 + 0.2**2 / 20 + 0.2 * DT
    s = np.arange(1, 101) / 100
    np.testing.assert_allclose(ends[:100], rest * (1 - 10 * s**3 + 15 * s**4 - 6 * s**5))
    assert same(blend.at(100), new)
    assert np.all(np.diff(ends) <= 0.0)


def test_each_joint_is_released_at_its_own_tick():
    two = [limits(*(np.full(3, x) for x in (-2.0, upper, 1.0, 10.0, np.inf))) for upper in (2, 0)]
    blend = LimitBlend.begin(*two, motion([0.45, -0.5, 0.95], [0.0, 0.0, 0.0]), 7)
    first, second = blend.releases
    assert first < second == blend.end
    np.testing.assert_array_equal(blend.at(first - 1).position_upper < 0.0, [True, False, True])
    np.testing.assert_array_equal(blend.at(first).position_upper < 0.0, [False, False, True])


def test_jerk_limits_delay_the_release():
    old, new = limits(jerk=100.0), limits(upper=0.0, jerk=100.0)
    without = LimitBlend.begin(old, new, motion(0.45), 0)
    with_jerk = LimitBlend.begin(old, new, motion(0.45, a=0.0), 0)
    assert with_jerk.end >= without.end + 10  # 0.1 s to the full acceleration


# ---- stack files


STACK = yaml.safe_load((CONFIG / "stacks" / "track.yaml").read_text(encoding="utf-8"))
TIGHTER = {
    "robot_a": {
        "panda_joint4": {"position": [-2.0, -1.0]},
        "panda_joint1": {"velocity": 1.0, "acceleration": 5.0},
    },
    "robot_b": {"base_x": {"position": [0.0, 2.5], "jerk": 60}},
}


def config(limits_of):
    return build(StackConfig, {**STACK, "limits": limits_of}, "track.yaml")


def test_a_stack_without_limits_has_none():
    assert build_stack(build(StackConfig, STACK, "track.yaml"), team()).limits is None


def test_a_stack_with_limits_has_those_of_the_whole_team():
    tight, own = build_stack(config(TIGHTER), team()).limits, team().limits
    changed = {
        ("position_lower", 6): -2.0,
        ("position_upper", 6): -1.0,
        ("velocity", 3): 1.0,
        ("acceleration", 3): 5.0,
        ("position_lower", 10): 0.0,
        ("position_upper", 10): 2.5,
        ("jerk", 10): 60.0,
    }
    for name in FIELDS:
        expected = getattr(own, name).copy()
        for (field, joint), value in changed.items():
            if field == name:
                expected[joint] = value
        np.testing.assert_array_equal(getattr(tight, name), expected)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (
            {"robot_c": {"panda_joint1": {"velocity": 1.0}}},
            "stack track: limits: unknown robot 'robot_c'; known: robot_a, robot_b",
        ),
        (
            {"robot_a": {"joint1": {"velocity": 1.0}}},
            "limits.robot_a: unknown joint 'joint1'; known: base_x, base_y, base_yaw, panda_joint1",
        ),
        (
            {"robot_a": {"panda_joint4": {"position": [-9.0, -1.0]}}},
            "limits.robot_a.panda_joint4: position_lower: -9.0 is beyond the robot's own -3.0718",
        ),
        (
            {"robot_a": {"panda_joint4": {"position": [-2.0, 0.0]}}},
            "position_upper: 0.0 is beyond the robot's own -0.0698",
        ),
        ({"robot_a": {"panda_joint1": {"velocity": 3.0}}}, "velocity: 3.0 is beyond"),
        ({"robot_a": {"panda_joint1": {"acceleration": 16}}}, "acceleration: 16.0 is beyond"),
        ({"robot_a": {"panda_joint1": {"jerk": 1e4}}}, "jerk: 10000.0 is beyond"),
    ],
)
def test_limits_that_do_not_fit_the_team_are_refused(wrong, message):
    with pytest.raises(ConfigurationError) as error:
        build_stack(config(wrong), team())
    assert message in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"position": [1.0, 1.0]}, "panda_joint1: position: lower 1.0 is not below upper 1.0"),
        ({"position": [1.0]}, "position: expected 2 values, got 1"),
        ({"velocity": 0.0}, "panda_joint1: velocity: must be finite and > 0, got 0.0"),
        ({"jerk": float("inf")}, "jerk: must be finite and > 0, got inf"),
        ({"speed": 1.0}, "unknown key 'speed'; known: acceleration, jerk, position, velocity"),
        ({}, "panda_joint1: no limit is given"),
    ],
)
def test_a_wrong_limit_is_named(wrong, message):
    with pytest.raises(ConfigurationError) as error:
        config({"robot_a": {"panda_joint1": wrong}})
    assert str(error.value).startswith("track.yaml: limits.robot_a")
    assert message in str(error.value)


def test_limits_survive_the_text_of_a_resolved_scenario():
    stacks = {**resolved().stacks, "track": config(copy.deepcopy(TIGHTER))}
    scenario = replace(resolved(), stacks=stacks)
    assert ResolvedScenario.from_yaml(scenario.to_yaml(), "copy") == scenario
