"""The stand-in: habits, drives that refuse steps, and what its controllers make of messages."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from lexstack.errors import ConfigurationError
from lexstack.limits import JointLimits
from lexstack_config.plant_file import load_plant
from lexstack_plant.hardware.base_intake import BaseSample
from lexstack_plant.hardware.joint_intake import JointSample
from lexstack_testing.stand_in.consumers import (
    BaseConsumer,
    PositionConsumer,
    TrajectoryConsumer,
    VelocityConsumer,
)
from lexstack_testing.stand_in.drive import Drive
from lexstack_testing.stand_in.habits import ALL, Habits, parse_habits
from lexstack_testing.stand_in.robots import StandIn
from support.ideal_hardware import PLANT
from support.scenario import resolved

LIMITS = JointLimits(
    np.array([-3.0]), np.array([3.0]), np.array([2.0]), np.array([15.0]), np.array([7500.0])
)


def stand_in(**values):
    return StandIn(resolved(), load_plant(PLANT), dataclasses.replace(Habits(), **values), 10.0)


# ---- habits


def test_habits_are_read_from_a_text():
    assert parse_habits("") == Habits()
    assert parse_habits("all, drop=0.5") == dataclasses.replace(ALL, drop=0.5)
    assert parse_habits("reorder,reflex=0") == Habits(reorder=True, reflex=False)


@pytest.mark.parametrize("text", ["haste", "drop=often"])
def test_unknown_habits_are_refused(text):
    with pytest.raises(ConfigurationError, match="habit"):
        parse_habits(text)


def test_states_come_at_their_rate():
    sent = stand_in().advance(11.0)
    assert sum(isinstance(each.sample, JointSample) for each in sent) == 2 * 126
    assert sum(isinstance(each.sample, BaseSample) for each in sent) == 2 * 126


def test_messages_are_lost_late_repeated_and_reordered():
    lost = stand_in(drop=0.2).advance(11.0)
    assert 340 < len(lost) < 450
    repeated = stand_in(repeat=0.2).advance(11.0)
    assert 550 < len(repeated) < 660
    robots, late = stand_in(late=0.2), []
    for now in np.arange(10.0, 11.0, 0.001):
        late += [now - each.sample.stamp for each in robots.advance(now)]
    assert max(late) == pytest.approx(0.03, abs=0.002)
    mixed = stand_in(reorder=True, velocities=False).advance(10.5)
    names = {tuple(e.sample.names) for e in mixed if isinstance(e.sample, JointSample)}
    assert len(names) > 20
    assert all(len(each) == 9 for each in names)


def test_none_overtakes_another():
    robots, stamps = stand_in(jitter=0.05, late=0.1), []
    for now in np.arange(10.0, 11.0, 0.001):
        stamps += [
            e.sample.stamp
            for e in robots.advance(now)
            if e.robot == "robot_a" and isinstance(e.sample, BaseSample)
        ]
    assert stamps == sorted(stamps)


def test_encoders_have_steps():
    (first, *_) = stand_in(quantum=1e-2).advance(10.01)
    np.testing.assert_allclose(np.array(first.sample.positions) % 1e-2 % 9.9999e-3, 0.0, atol=1e-6)


def test_odometry_is_wrong_by_a_share_of_the_way():
    robots = stand_in(drift=0.1)
    for k in range(200):
        now = 10.0 + 0.01 * k
        robots.command_base("robot_a", np.array([0.2, 0.0, 0.0]), now)
        robots.advance(now + 0.01)
    way = robots.plant.state().q[0]
    assert way > 0.3
    assert robots.robots["robot_a"].odometry[0] == pytest.approx(1.1 * way, rel=1e-2)


# ---- drives


def drive():
    return Drive(LIMITS, np.zeros(1), 1e-3, reflex=True)


def test_a_drive_follows_what_keeps_its_limits():
    motor, q, v, a = drive(), 0.0, 0.0, 0.0
    for _ in range(50):
        a = min(a + 7.5, 15.0)
        v += 1e-3 * a
        q += 1e-3 * v
        assert motor.follow(np.array([q])) == q
    assert not motor.stopped
    assert motor.peaks[1] == pytest.approx(1.0, rel=2e-3)


@pytest.mark.parametrize(
    ("path", "what"),
    [([0.0, 0.01], "velocity"), ([0.0, 2e-5], "acceleration"), ([0.0, 1e-5], "jerk")],
)
def test_a_step_stops_a_drive_for_good(path, what):
    motor = drive()
    for q in path:
        motor.follow(np.array([q]))
    assert what in motor.stopped
    where = motor.follow(np.array([0.5]))
    for _ in range(1000):
        where = motor.follow(np.array([0.5]))
    assert abs(where[0]) < 0.2
    assert motor.follow(np.array([1.0])) == where
    motor.release(where)
    assert not motor.stopped


# ---- controllers


def test_platforms_follow_within_their_limits_and_time_out():
    base = BaseConsumer(np.array([1.0, 1.0, 2.0]))
    base.take(np.array([0.5, 0.0, 0.0]), 0.0)
    speeds = [base.step(1e-3 * k, 1e-3)[0] for k in range(1000)]
    assert max(np.abs(np.diff(speeds))) <= 1e-3 * (1 + 1e-9)
    assert max(speeds) == pytest.approx(0.25, abs=0.01)
    assert speeds[-1] == 0.0


def test_arrays_are_reached_in_a_period():
    position = PositionConsumer(np.zeros(1), 0.01)
    position.take(np.ones(1), 1.0)
    assert position.at(1.005)[0] == pytest.approx(0.5)
    assert position.at(1.5)[0] == 1.0
    velocity = VelocityConsumer(np.zeros(1), 0.01)
    velocity.take(np.ones(1), 0.0)
    for k in range(1, 101):
        where = velocity.at(1e-3 * k)
    assert where[0] == pytest.approx(0.095, abs=1e-3)


def test_a_trajectory_of_the_past_changes_nothing():
    consumer = TrajectoryConsumer(np.zeros(1))
    consumer.take([], 1.0)
    assert consumer.at(2.0)[0] == 0.0


def test_an_emergency_stop_stops_the_drives():
    robots = stand_in()
    robots.press("robot_a")
    assert robots.stopped() == {"robot_a": "emergency stop"}
    robots.release("robot_a")
    assert not robots.stopped()
