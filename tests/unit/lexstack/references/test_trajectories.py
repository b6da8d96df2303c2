"""Trajectories: their velocity is the derivative of their value, and nothing in them jumps."""

from itertools import pairwise

import numpy as np
import pinocchio as pin
import pytest

from lexstack.errors import ConfigurationError, InputError
from lexstack.references import (
    BASES,
    JOINTS,
    POSES,
    MotionLimits,
    References,
    ReferenceSchedule,
    ReferenceTimeline,
    SetPoint,
    Spline,
    Target,
    Twist,
    TwistStream,
    Waypoints,
    base_spline,
    timed_waypoints,
)
from lexstack.references.set_point import led, led_onto
from lexstack.references.waypoints import peaks
from lexstack.robots import Pose
from lexstack.tasks.feed_forward import drift
from support.scenario import random_q, team

H = 1e-5  # s
ORIGIN = Pose(np.zeros(3), np.eye(3))


def pose(*values):
    return Pose(np.array(values[:3]), pin.exp3(np.array(values[3:])))


def some_poses(count=4, seed=1):
    rng = np.random.default_rng(seed)
    return [pose(*rng.uniform(-1.0, 1.0, 6)) for _ in range(count)]


WAY = Waypoints([0.5, 1.5, 2.0, 4.0], some_poses())
TWO = Waypoints([0.0, 2.0], some_poses(2))
TURNING = Waypoints(
    [0.5, 1.5, 2.0, 4.0],
    some_poses(),
    [[0.2, 0, 0.1, 0.3, 0, -0.2], [0.5, 0.1, 0, 0.2, 0.2, 0], [0, -0.3, 0, 0, 0, 0.4], [0.0] * 6],
)
STREAM = TwistStream.begun(WAY, 1.2, Twist(np.array([0.2, 0, 0.1, 0.5, -0.3, 0.4]), timeout=1.0))
HASTY = TwistStream.begun(WAY, 1.2, Twist(np.array([0.9, 0, 0.1, 0.5, -0.3, 0.4]), timeout=0.05))
FED = led(WAY, ORIGIN, 1.2, 0.8, POSES)
ONTO = led_onto(SetPoint(ORIGIN), WAY, 1.0, 0.8, POSES)
POSE_KINDS = {
    "way": WAY,
    "two": TWO,
    "stream": STREAM,
    "hasty": HASTY,
    "fed": FED,
    "onto": ONTO,
    "turning": TURNING,
}
PLACES = base_spline([0.0, 1.0, 3.0], [[0, 0, 3.0], [1, 0, -3.0], [1, 2, 0]])
ARM = Spline([1.0, 2.0, 2.5], np.random.default_rng(0).normal(size=(3, 7)))
ARM_RATES = np.vstack((np.random.default_rng(2).normal(size=(2, 7)), np.zeros(7)))
PLAIN_KINDS = {
    "arm in motion": (Spline([1.0, 2.0, 2.5], ARM.values, ARM_RATES), JOINTS),
    "base": (PLACES, BASES),
    "arm": (ARM, JOINTS),
    "arm of 3": (Spline([0.0, 1.0], np.array([[0.0, 0, 0], [1, 1, 4]])), JOINTS),
    "fed base": (led(PLACES, np.zeros(3), 1.2, 0.5, BASES), BASES),
    "onto arm": (led_onto(SetPoint(np.zeros(7), space=JOINTS), ARM, 1.2, 0.5, JOINTS), JOINTS),
}


def started(trajectory):
    """Return the first time at which a trajectory is one."""
    if isinstance(trajectory, TwistStream):
        return trajectory.follow.start
    if isinstance(trajectory, Waypoints | Spline):
        return trajectory.times[0] - 0.5
    return trajectory.fading.start


def stamps(trajectory, count=300):
    begin = started(trajectory) + 2.0 * H
    return np.random.default_rng(3).uniform(begin, trajectory.end + 0.3, count)


def twist_between(one, other, span):
    turn = pin.log3(other.rotation @ one.rotation.T)
    return np.concatenate((other.position - one.position, turn)) / span


def rate(trajectory, stamp):
    found = trajectory.rate(stamp)
    size = 6 if isinstance(trajectory.at(stamp), Pose) else len(trajectory.at(stamp))
    return np.zeros(size) if found is None else found


@pytest.mark.parametrize("kind", POSE_KINDS)
def test_the_twist_is_the_derivative_of_the_pose(kind):
    trajectory = POSE_KINDS[kind]
    for stamp in stamps(trajectory):
        found = twist_between(trajectory.at(stamp - H), trajectory.at(stamp + H), 2.0 * H)
        np.testing.assert_allclose(rate(trajectory, stamp), found, atol=2e-4)


@pytest.mark.parametrize("kind", PLAIN_KINDS)
def test_the_rate_is_the_derivative_of_the_value(kind):
    trajectory, space = PLAIN_KINDS[kind]
    for stamp in stamps(trajectory):
        found = space.gap(trajectory.at(stamp - H), trajectory.at(stamp + H)) / (2.0 * H)
        np.testing.assert_allclose(rate(trajectory, stamp), found, atol=2e-4)


@pytest.mark.parametrize("kind", [*POSE_KINDS, *PLAIN_KINDS])
def test_neither_value_nor_velocity_jumps(kind):
    trajectory = POSE_KINDS.get(kind) or PLAIN_KINDS[kind][0]
    times = np.arange(started(trajectory) + H, trajectory.end + 0.2, 1e-3)
    rates = np.array([rate(trajectory, t) for t in times])
    change = np.linalg.norm(np.diff(rates, axis=0), axis=1)
    assert change.max() < 0.2, "1e-3 s of the largest acceleration, and no jump"
    assert rates[-1].any() == 0
    if not isinstance(trajectory, TwistStream) and trajectory is not TURNING:
        # The acceleration does not jump either: its largest change within 1 ms is that of a jerk.
        assert np.abs(np.diff(rates, 2, axis=0)).max() < 0.02


@pytest.mark.parametrize("kind", POSE_KINDS)
def test_what_rests_is_the_same_object(kind):
    trajectory = POSE_KINDS[kind]
    end = trajectory.end
    assert trajectory.at(end) is trajectory.at(end + 5.0)
    assert trajectory.rate(end) is None


def test_waypoints_are_passed_at_their_times_and_without_stopping():
    for stamp, goal in zip(WAY.times, WAY.poses, strict=True):
        now = WAY.at(stamp)
        np.testing.assert_allclose(now.position, goal.position, atol=1e-12)
        np.testing.assert_allclose(now.rotation, goal.rotation, atol=1e-12)
    assert np.linalg.norm(WAY.rate(1.5)[:3]) > 0.1
    assert np.linalg.norm(WAY.rate(1.5)[3:]) > 0.1
    assert WAY.rate(0.5) is None
    assert WAY.rate(4.0) is None


def test_a_yaw_takes_the_short_way_round():
    yaw = [PLACES.at(t)[2] for t in np.linspace(0.0, 1.0, 50)]
    assert min(yaw) > 2.9
    assert max(yaw) < 3.4


@pytest.mark.parametrize("scale", [0.2, 1.0, 5.0])
@pytest.mark.parametrize("tight", range(4))
def test_times_that_are_not_given_are_the_shortest_within_the_limits(tight, scale):
    values = [1.0, 3.0, 2.0, 6.0]
    values[tight] *= 0.1 * scale
    limits = MotionLimits(*values)
    way = timed_waypoints(some_poses(5), start=2.0, limits=limits)
    share = peaks(way) / limits.values
    assert share.max() == pytest.approx(1.0, rel=2e-3)
    assert way.times[0] == 2.0


POSES_4 = some_poses(4)
TURNED = [ORIGIN, pose(0, 0, 0, np.pi, 0, 0)]
REFUSED = [
    (lambda: Waypoints([0.0], POSES_4[:1]), "times: expected two or more finite numbers"),
    (lambda: Waypoints([0.0, 1.0, 1.0], POSES_4[:3]), r"times\[2\]: 1 s is not after 1 s"),
    (lambda: Waypoints([0.0, np.nan], POSES_4[:2]), "times: expected two or more finite"),
    (lambda: Waypoints([0.0, 1.0], POSES_4), "poses: expected 2, as many as times, got 4"),
    (lambda: Waypoints([0.0, 1.0], TURNED), r"poses\[1\]: turned by 3\.142 rad from the one bef"),
    (lambda: timed_waypoints(POSES_4), "times: none are given, and linear or angular velocity"),
    (lambda: timed_waypoints(POSES_4[:1], limits=MotionLimits(1, 1, 1, 1)), "poses: expected two"),
    (
        lambda: timed_waypoints(POSES_4, [0, 1, 2, 3], limits=MotionLimits(0.1, 99, 99, 99)),
        r"times: the way needs linear velocity \d.* m/s, the limit is 0\.1",
    ),
    (
        lambda: timed_waypoints(POSES_4, limits=MotionLimits(linear_velocity=-1.0)),
        "limits: linear_velocity: must be finite and > 0, got -1.0",
    ),
    (lambda: Spline([0, 1], [[0.0], [np.inf]]), "values: expected 2 rows of finite numbers"),
    (lambda: base_spline([0, 1], [[0, 0], [1, 1]]), "places: expected rows of x, y, yaw"),
    (lambda: Twist(np.zeros(3)), "twist: expected 6 finite numbers"),
    (lambda: Twist(np.zeros(6), timeout=0.0), "twist: timeout: must be finite and > 0"),
    (lambda: Twist(np.zeros(6), linear=np.inf), "twist: linear: must be finite and > 0"),
]


@pytest.mark.parametrize("k", range(len(REFUSED)))
def test_a_wrong_trajectory_is_refused_in_one_line_with_its_key(k):
    make, text = REFUSED[k]
    with pytest.raises((InputError, ConfigurationError), match=text) as error:
        make()
    assert "\n" not in str(error.value)


# ---- a stream of twists


def schedule():
    return ReferenceSchedule(References((ORIGIN,), (np.zeros(3),)), lead_in=0.5, dt=0.01)


def test_a_stream_that_stops_comes_to_rest_within_its_acceleration_limits():
    made, value = schedule(), np.array([0.5, 0.0, 0.0, 0.0, 0.0, 1.0])
    twist = Twist(value, timeout=0.3, linear=1.0, angular=2.0)
    speeds, last = [], None
    for k in range(300):
        if k <= 100 and not k % 5:
            made.add(Target(0.01 * k, 0, ee=twist))
        last = made.at(0.01 * k)
        rate = last.twist(0)
        speeds.append(np.zeros(6) if rate is None else rate)
    speeds = np.array(speeds)
    np.testing.assert_allclose(speeds[90], value, atol=1e-12)
    np.testing.assert_allclose(speeds[129], value, atol=1e-12)  # 0.3 s after the last one
    assert not speeds[181:].any()
    change = np.diff(speeds, axis=0) / 0.01
    assert np.linalg.norm(change[:, :3], axis=1).max() <= 1.0 + 1e-9
    assert np.linalg.norm(change[:, 3:], axis=1).max() <= 2.0 + 1e-9
    assert made.at(5.0).ee[0] is made.at(6.0).ee[0]


def test_a_twist_of_a_frame_without_a_pose_is_refused():
    made = schedule()
    twist = Twist(np.ones(6))
    with pytest.raises(InputError, match="ee_target of elbow: a twist needs a pose to begin from"):
        made.add(Target(0.0, 0, ee=twist, frame="elbow"))
    made.add(Target(0.0, 0, ee=ORIGIN, frame="elbow"))
    made.at(0.0)
    made.add(Target(0.01, 0, ee=twist, frame="elbow"))
    assert made.at(0.5).twist(0, "elbow").any()


# ---- decisions


def test_a_trajectory_is_led_onto_and_left_without_a_jump():
    """Pose and velocity of the references change by no more than an acceleration explains."""
    made = schedule()
    made.add(Target(0.2, 0, ee=WAY))
    made.add(Target(0.2, 0, base=PLACES))
    made.add(Target(1.7, 0, ee=ORIGIN))
    made.add(Target(1.7, 0, base=np.ones(3)))
    found = [made.at(0.01 * k) for k in range(400)]
    twists = np.array([np.zeros(6) if r.twist(0) is None else r.twist(0) for r in found])
    moved = np.array([twist_between(a.ee[0], b.ee[0], 0.01) for a, b in pairwise(found)])
    # The velocity is that of the middle of the period in which the pose moves.
    np.testing.assert_allclose(moved, twists[:-1], atol=0.02)
    assert np.abs(np.diff(twists, axis=0)).max() < 0.5
    assert found[-1].ee[0] is ORIGIN
    assert not found[-1].motion.feeds


def test_a_set_point_has_no_velocity_unless_it_is_left_from_a_trajectory():
    made = schedule()
    made.add(Target(0.1, 0, ee=pose(1.0, 0, 0, 0, 0, 0)))
    assert not any(made.at(0.01 * k).motion.feeds for k in range(100))


def test_references_of_frames_and_postures_are_decided_like_all_others():
    made = schedule()
    made.at(0.0)
    made.add(Target(0.1, 0, ee=WAY, frame="elbow"))
    made.add(Target(0.1, 0, posture=ARM))
    assert made.at(0.05).pose(0, "elbow") is None
    later = made.at(1.75)
    assert later.revision == 2
    np.testing.assert_array_equal(later.pose(0, "elbow").position, WAY.at(1.75).position)
    np.testing.assert_array_equal(later.twist(0, "elbow"), WAY.rate(1.755))
    np.testing.assert_array_equal(later.motion.postures[0], ARM.at(1.75))
    np.testing.assert_array_equal(later.motion.posture_rates[0], ARM.rate(1.755))


def test_a_follower_of_the_decisions_has_the_same_references_bit_for_bit():
    made, other = schedule(), ReferenceTimeline(0.01)
    made.add(Target(0.1, 0, ee=WAY))
    for k in range(300):
        one = made.at(0.01 * k)
        for news in made.take_news():
            other.hear(news)
        same = other.at(0.01 * k)
        np.testing.assert_array_equal(one.ee[0].position, same.ee[0].position)
        np.testing.assert_array_equal(one.twist(0), same.twist(0))


# ---- the feed-forward


def test_the_drift_is_the_derivative_of_the_jacobian():
    rng = np.random.default_rng(0)
    robot = team().robots[0]
    for _ in range(20):
        q, chi = random_q(rng)[:10], rng.normal(size=10)
        ahead, behind = (robot.tool(q + side * 1e-6 * chi)[1] for side in (1.0, -1.0))
        np.testing.assert_allclose(
            drift(robot.tool(q)[1], chi), (ahead - behind) @ chi / 2e-6, atol=1e-6
        )
