"""The stand-in: habits, drives that refuse steps, and what its controllers make of messages."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from lexstack.errors import ConfigurationError
from lexstack.limits import JointLimits
from lexstack_config.plant_file import (
    ArmInterfaceConfig,
    BaseInterfaceConfig,
    PlantFile,
    RobotInterfaceConfig,
    load_plant,
)
from lexstack_config.resolved import load_scenario
from lexstack_plant.hardware.base_intake import BaseSample
from lexstack_plant.hardware.joint_intake import JointSample
from lexstack_plant.hardware.spline import Point
from lexstack_testing.stand_in.consumers import (
    BaseConsumer,
    PositionConsumer,
    TrajectoryConsumer,
    VelocityConsumer,
)
from lexstack_testing.stand_in.drive import Drive
from lexstack_testing.stand_in.habits import ALL, Habits, parse_habits
from lexstack_testing.stand_in.lateness import Lateness
from lexstack_testing.stand_in.robots import StandIn
from support.ideal_hardware import PLANT
from support.scenario import CONFIG, resolved

LIMITS = JointLimits(
    np.array([-3.0]), np.array([3.0]), np.array([2.0]), np.array([15.0]), np.array([7500.0])
)


def stand_in(**values):
    return StandIn(resolved(), load_plant(PLANT), dataclasses.replace(Habits(), **values), 10.0)


# ---- habits


@pytest.mark.parametrize("value", ["nan", "inf", "-2", "1e300"])
@pytest.mark.parametrize("name", [field.name for field in dataclasses.fields(Habits)])
def test_habits_out_of_range_are_refused(name, value):
    with pytest.raises(ConfigurationError, match=f"habit {name}: must be in"):
        parse_habits(f"{name}={value}")


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
    way = robots.plant.q[0]
    assert way > 0.3
    assert robots.robots["robot_a"].odometry[0] == pytest.approx(1.1 * way, rel=1e-2)


def test_robots_go_the_same_way_however_time_passes():
    random, ends = np.random.default_rng(1), []
    cuts = np.sort(random.uniform(10.0, 10.3, 200))
    for looks in (cuts, cuts[::10]):
        robots = stand_in()
        arm = robots.robots["robot_a"].drive.q.copy()
        step = np.zeros_like(arm)
        step[1] = 1.0
        goal = [Point(10.25, arm + 0.05 * step, 0.0 * step, 0.0 * step)]
        robots.command_arm("robot_a", goal, 10.0)
        robots.command_base("robot_a", np.array([0.3, 0.1, 0.5]), 10.0502)
        robots.command_base("robot_a", np.array([0.1, 0.2, 0.9]), 10.1307)
        for now in looks:
            robots.advance(now)
        robots.advance(10.321)
        ends.append(robots.plant.q.copy())
    np.testing.assert_allclose(ends[1], ends[0], atol=2e-6)
    home = stand_in().plant.q
    assert ends[0][4] - home[4] == pytest.approx(0.05, abs=0.01)
    assert ends[0][2] > 0.05


# ---- drives


def drive():
    return Drive(LIMITS, np.zeros(1), 1e-3, reflex=True)


def test_a_drive_follows_what_keeps_its_limits():
    motor, q, v, a = drive(), 0.0, 0.0, 0.0
    for _ in range(50):
        a = min(a + 7.5, 15.0)
        v += 1e-3 * a
        q += 1e-3 * v
        led, good = motor.follow(np.array([[q]]))
        assert led == q
        assert good == 1
    assert not motor.stopped
    assert motor.peaks[1] == pytest.approx(1.0, rel=2e-3)


@pytest.mark.parametrize(
    ("path", "what"),
    [([0.0, 0.01], "velocity"), ([0.0, 2e-5], "acceleration"), ([0.0, 1e-5], "jerk")],
)
def test_a_step_stops_a_drive_for_good(path, what):
    motor = drive()
    _, good = motor.follow(np.array(path)[:, None])
    assert good == 1
    assert what in motor.stopped
    led, good = motor.follow(np.full((1000, 1), 0.5))
    assert good == 0
    assert abs(led[-1, 0]) < 0.2
    assert motor.follow(np.ones((1, 1)))[0] == led[-1]
    motor.release(led[-1])
    assert not motor.stopped


def test_a_drive_does_the_same_however_many_periods_it_is_given_at_once():
    random = np.random.default_rng(3)
    for scale in (1e-6, 1e-4):  # within the limits, and far beyond them
        asked = np.cumsum(np.cumsum(scale * random.standard_normal((40, 1)), axis=0), axis=0)
        whole, single = drive(), drive()
        led, good = whole.follow(asked)
        steps = [single.follow(row[None]) for row in asked]
        np.testing.assert_allclose(led, np.concatenate([each for each, _ in steps]), atol=1e-12)
        assert good == sum(each for _, each in steps)
        assert whole.stopped == single.stopped
        np.testing.assert_allclose(whole.peaks, single.peaks)
    assert whole.stopped


# ---- controllers


def test_platforms_follow_within_their_limits_and_time_out():
    base = BaseConsumer(np.array([1.0, 1.0, 2.0]))
    base.take(np.array([0.5, 0.0, 0.0]), 0.0)
    times = 1e-3 * np.arange(1, 1001)
    speeds = np.concatenate([base.path(part, 1e-3) for part in np.split(times, [3, 100, 700])])[
        :, 0
    ]
    assert max(np.abs(np.diff(speeds))) <= 1e-3 * (1 + 1e-9)
    assert max(speeds) == pytest.approx(0.25, abs=0.01)
    assert speeds[-1] == 0.0


def test_arrays_are_reached_in_a_period():
    position = PositionConsumer(np.zeros(1), 0.01)
    position.take(np.ones(1), 1.0)
    np.testing.assert_allclose(position.path(np.array([1.005, 1.5]))[:, 0], [0.5, 1.0])
    velocity = VelocityConsumer(np.zeros(1), 0.01)
    velocity.take(np.ones(1), 0.0)
    times = 1e-3 * np.arange(1, 101)
    where = [velocity.path(part) for part in np.split(times, [7, 50])][-1]
    assert where[-1, 0] == pytest.approx(0.095, abs=1e-3)


def test_a_trajectory_of_the_past_changes_nothing():
    consumer = TrajectoryConsumer(np.zeros(1))
    consumer.take([], 1.0)
    assert consumer.path(np.array([2.0]))[0] == 0.0


def test_a_trajectory_is_the_same_however_many_times_are_asked_for_at_once():
    points = [
        Point(1.0 + 0.004 * k, np.array([0.01 * k * k]), np.array([0.2 * k]), np.array([5.0 - k]))
        for k in range(1, 5)
    ]
    times = 1.0 + 1e-3 * np.arange(1, 25)
    found = []
    for cuts in ([], [1, 4, 5, 20], range(1, 24)):
        consumer = TrajectoryConsumer(np.zeros(1))
        consumer.take(points, 1.0)
        found.append(np.concatenate([consumer.path(part) for part in np.split(times, cuts)]))
    np.testing.assert_allclose(found[1], found[0], atol=1e-12)
    np.testing.assert_allclose(found[2], found[0], atol=1e-12)
    np.testing.assert_allclose(found[0][[3, 7, 15, 23], 0], [0.01, 0.04, 0.16, 0.16])


def test_an_emergency_stop_stops_the_drives():
    robots = stand_in()
    robots.press("robot_a")
    assert robots.stopped() == {"robot_a": "emergency stop"}
    robots.release("robot_a")
    assert not robots.stopped()


# ---- a machine that is too busy


def test_what_comes_late_to_a_busy_machine_is_done_as_if_it_had_come_in_time():
    """A process that stood still for 0.2 s finds commands in its queue, and when they were sent."""
    ends = []
    for late in (False, True):
        robots = stand_in()
        for k in range(30):
            now = 10.0 + 0.01 * k
            if not late or not 10 <= k < 25:
                robots.advance(now)
            robots.command_base("robot_a", np.array([0.002 * k, 0.0, 0.1]), now)
        sent = robots.advance(10.4)
        ends.append((robots.plant.q.copy(), len(sent)))
    np.testing.assert_allclose(ends[1][0], ends[0][0], atol=1e-5)
    assert ends[0][0][0] > 1e-3
    assert ends[1][1] == ends[0][1]


def test_lateness_is_counted_and_reported_once():
    lateness = Lateness()
    for behind in (0.001, 0.05, 0.2, 0.002):
        lateness.add(behind)
    complaint, newest = lateness.report()
    assert "200 ms behind the clock" in complaint
    assert newest == 0.2
    assert lateness.report() == ("", 0.0)
    assert str(lateness) == ("behind the clock by more than 30 ms at 2 of 4 looks, at most 200 ms")


# ---- differential platforms


def test_a_differential_platform_drives_arcs_and_never_to_its_side():
    whole = load_scenario(CONFIG / "scenarios" / "drive.yaml")
    topics = BaseInterfaceConfig(odometry="/odom", command="/cmd_vel")
    robot = RobotInterfaceConfig("tiago", ArmInterfaceConfig("/arm"), base=topics)
    robots = StandIn(whole, PlantFile("tiago", "", {"robot_a": robot}), Habits(), 10.0)
    sent = []
    for k in range(150):
        now = 10.0 + 0.01 * k
        robots.command_base("robot_a", np.array([0.4, 0.3, 0.5]), now)  # y: of no effect
        sent += robots.advance(now)
    base = [each.sample for each in sent if isinstance(each.sample, BaseSample)]
    assert {each.twist[1] for each in base} == {0.0}
    v, w = base[-1].twist[0], base[-1].twist[2]
    assert (v, w) == pytest.approx((0.4, 0.5), abs=0.01)
    poses = np.array([[each.x, each.y, 2.0 * np.arctan2(*each.quaternion[2:])] for each in base])
    steps, yaws = np.diff(poses[:, :2], axis=0), 0.5 * (poses[1:, 2] + poses[:-1, 2])
    aside = np.cos(yaws) * steps[:, 1] - np.sin(yaws) * steps[:, 0]
    assert np.abs(aside).max() < 1e-4  # m, in 8 ms
    np.testing.assert_allclose(poses[-1], robots.plant.q[:3], atol=1e-6)
    assert poses[-1, 2] > 0.5
    assert poses[-1, 0] > 0.3
