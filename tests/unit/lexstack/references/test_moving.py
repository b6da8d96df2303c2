"""Trajectories in decisions: sent bit for bit, held, begun where the robot is, and taken again."""

import numpy as np
import pinocchio as pin
import pytest

from lexstack.errors import InputError
from lexstack.references import (
    BaseTwist,
    Hold,
    Moving,
    References,
    ReferenceSchedule,
    ReferenceTimeline,
    Spline,
    Target,
    Twist,
    Waypoints,
    base_spline,
    decode,
    encode,
    encode_moving,
    targets_between,
)
from lexstack.robots import Pose

DT, LEAD, ARM = 0.01, 0.3, 7
ORIGIN = Pose(np.zeros(3), np.eye(3))


def schedule(lead_in=LEAD):
    return ReferenceSchedule(References((ORIGIN,), (np.zeros(3),)), lead_in=lead_in, dt=DT)


def poses(rng, count):
    return [Pose(rng.normal(size=3), pin.exp3(rng.uniform(-1, 1, 3))) for _ in range(count)]


def random_target(rng, stamp, kinds=12):
    """Return a target of any kind, from now or soon; the last three kinds hold."""
    at = float(rng.choice([0.0, stamp + 0.03]))
    times = max(at, stamp) + np.cumsum(rng.uniform(0.05, 0.4, 4))
    rates = np.vstack((rng.normal(size=(3, 6)), np.zeros(6)))
    frame = str(rng.choice(["tool", "elbow"]))
    arm = rng.normal(size=(4, ARM))
    arm_rates = np.vstack((rng.normal(size=(3, ARM)), np.zeros(ARM)))
    begin = poses(rng, 1)[0]
    return [
        Target(at, 0, ee=poses(rng, 1)[0], frame=frame),
        Target(at, 0, ee=Waypoints(times, poses(rng, 4)), frame=frame, begin=begin),
        Target(at, 0, ee=Waypoints(times, poses(rng, 4), rates), frame=frame),
        Target(at, 0, ee=Twist(rng.normal(size=6), timeout=0.1), frame=frame, begin=begin),
        Target(at, 0, base=rng.normal(size=3), duration=0.2),
        Target(at, 0, base=base_spline(times, rng.normal(size=(4, 3)))),
        Target(at, 0, posture=arm[0], begin=arm[1], duration=0.7),
        Target(at, 0, posture=Spline(times, arm, arm_rates)),
        Target(at, 0, base=BaseTwist(rng.normal(size=3), bool(rng.integers(2)), timeout=0.1)),
        Target(at, 0, ee=Hold(), frame=frame),
        Target(at, 0, base=Hold()),
        Target(at, 0, posture=Hold()),
    ][rng.integers(kinds)]


def sent(setting):
    """Return a decision as another process hears it."""
    vectors = {name: vector.tolist() for name, vector in encode(setting).items()}
    moving = [
        Moving(m.robot, m.of, m.kind, m.values.tolist(), m.lead.tolist(), m.frame)
        for m in encode_moving(setting)
    ]
    return decode(setting.at, setting.revision, vectors, 1, "here", moving=moving, arms=[ARM])


def numbers(references):
    """Return all numbers of references, by their names."""
    motion = references.motion
    found = {"base": references.base[0], "ee": references.ee[0].position}
    found["turn"] = references.ee[0].rotation
    for name in ("twists", "bases", "postures", "posture_rates"):
        found |= {(name, key): value for key, value in getattr(motion, name).items()}
    for key, value in motion.frames.items():
        found |= {("at", key): value.position, ("turn", key): value.rotation}
    return found


def assert_same(one, other):
    mine, others = numbers(one), numbers(other)
    assert mine.keys() == others.keys()
    for name, value in mine.items():
        np.testing.assert_array_equal(value, others[name])


@pytest.mark.parametrize("seed", range(4))
def test_whoever_hears_the_decisions_has_the_same_motion_bit_for_bit(seed):
    rng = np.random.default_rng(seed)
    made, heard = schedule(), ReferenceTimeline(DT)
    kinds = set()
    for tick in range(500):
        stamp = tick * DT
        if tick % 7 == 3:
            made.add(random_target(rng, stamp))
        made.decide(stamp)
        for setting in made.take_news():
            kinds |= {moving.kind for moving in encode_moving(setting)}
            assert heard.hear(sent(setting))
        assert_same(made.at(stamp), heard.at(stamp))
    assert kinds >= {"fed", "waypoints", "waypoints_twists", "spline", "spline_rates", "twist"}
    assert "base_twist" in kinds


@pytest.mark.parametrize("seed", range(4))
def test_targets_found_in_the_decisions_lead_to_the_same_decisions(seed):
    rng = np.random.default_rng(10 + seed)
    made, again, last = schedule(), schedule(), None
    for tick in range(500):
        stamp = tick * DT
        if tick % 7 == 3:
            made.add(random_target(rng, stamp, 9))
        made.decide(stamp)
        for setting in made.take_news():
            if last is not None:
                for target in targets_between(last, sent(setting)):
                    again.add(target)
            last = sent(setting)
        ours, theirs = numbers(made.at(stamp)), numbers(again.at(stamp))
        assert ours.keys() == theirs.keys()
        for name, value in ours.items():
            np.testing.assert_allclose(theirs[name], value, atol=1e-6)


def test_with_another_lead_in_the_found_targets_are_led_in_by_it():
    made, quick, last = schedule(), schedule(0.1), None
    goal = Pose(np.array([1.0, 0.0, 0.0]), np.eye(3))
    made.add(Target(0.5, 0, ee=goal))
    for tick in range(100):
        made.decide(tick * DT)
        for setting in made.take_news():
            for target in () if last is None else targets_between(last, setting):
                assert target.ee is goal
                quick.add(target)
            last = setting
        quick.decide(tick * DT)
    assert made.timeline.at(0.65).ee[0].position[0] < 0.6
    assert quick.timeline.at(0.65).ee[0] is goal


def rate_of(made, stamp, key):
    rate = made.timeline.newest.references(stamp).motion
    return {"base": rate.bases.get(0), "ee": rate.twists.get((0, "tool"))}[key]


@pytest.mark.parametrize("key", ["ee", "base"])
def test_hold_ends_a_trajectory_without_a_jump_and_without_turning_back(key):
    made = schedule()
    way = [Pose(np.array([x, 0.0, 0.0]), np.eye(3)) for x in (0.0, 1.0, 2.0)]
    places = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]])
    times = [0.0, 2.0, 4.0]
    goal = Waypoints(times, way) if key == "ee" else base_spline(times, places)
    made.add(Target(0.0, 0, **{key: goal}))
    made.decide(0.0)
    before = rate_of(made, 2.0 - 1e-9, key)
    made.add(Target(2.0, 0, **{key: Hold()}))
    made.decide(2.0)
    np.testing.assert_allclose(rate_of(made, 2.0, key)[:3], before[:3], atol=1e-5)
    speeds = [rate_of(made, t, key)[0] for t in np.arange(2.0, 2.0 + LEAD - 1e-6, 1e-3)]
    assert min(speeds) > -1e-6, "it does not turn back"
    assert rate_of(made, 2.01 + LEAD, key) is None
    assert made.timeline.newest.references(9.0).motion.feeds is False


def test_hold_without_a_motion_is_no_decision():
    made = schedule()
    made.decide(0.0)
    revision = made.timeline.newest.revision
    for target in (Target(0.0, 0, ee=Hold()), Target(0.0, 0, posture=Hold())):
        made.add(target)
        made.decide(0.1)
    assert made.timeline.newest.revision == revision


def test_a_reference_that_there_was_not_begins_where_the_target_says():
    made, begin = schedule(), np.full(ARM, 0.5)
    made.decide(0.0)
    made.add(Target(0.0, 0, posture=np.ones(ARM), begin=begin, duration=2.0))
    made.decide(0.01)
    posture = made.timeline.newest.postures[0]
    np.testing.assert_array_equal(posture.at(0.01), begin)
    np.testing.assert_array_equal(posture.at(2.01), np.ones(ARM))
    assert posture.rate(1.0)[0] > 0.4, "its velocity is followed"
    made.add(Target(0.0, 0, ee=Twist(np.array([0.1, 0, 0, 0, 0, 0])), frame="elbow", begin=ORIGIN))
    made.decide(0.02)
    assert made.timeline.at(0.2).motion.frames[0, "elbow"].position[0] > 0.0


class Own:
    """A trajectory of a user's own."""

    end = 1.0

    def at(self, _stamp):
        return ORIGIN

    def rate(self, _stamp):
        return None


def test_a_trajectory_of_a_users_own_kind_is_not_sent():
    made = schedule(0.0)
    made.add(Target(0.0, 0, ee=Own()))
    made.decide(0.0)
    with pytest.raises(InputError, match="a Own is not sent: it is of no known kind"):
        list(encode_moving(made.timeline.newest))


POSE = [0.0, 0.0, 0.0, 1.0, 0, 0, 0, 1, 0, 0, 0, 1]
LED = [0.0] * 20


@pytest.mark.parametrize(
    ("moving", "reason"),
    [
        (Moving(1, "ee", "set_point", POSE), "no such robot"),
        (Moving(0, "head", "set_point", POSE), "values: expected 3, got 12"),
        (Moving(0, "ee", "spline", POSE), "kind: 'spline' is no kind of ee"),
        (Moving(0, "ee", "set_point", POSE[:-1]), "values: expected 12, got 11"),
        (Moving(0, "ee", "set_point", [0.0] * 12), "no rotation matrix"),
        (Moving(0, "ee", "set_point", [np.nan] * 12), "values: expected finite numbers"),
        (Moving(0, "ee", "set_point", POSE, LED[1:]), "lead: expected 20 finite numbers, or none"),
        (Moving(0, "ee", "waypoints", [1.0, *POSE, 0.5, *POSE]), "0.5 s is not after 1 s"),
        (Moving(0, "ee", "waypoints", [1.0, *POSE, 2.0]), "expected 13 for each"),
        (Moving(0, "ee", "twist", [0.0] * 29), "timeout: must be finite and > 0"),
        (Moving(0, "posture", "set_point", [0.0] * 6), "values: expected 7, got 6"),
        (Moving(0, "base", "spline", [0.0, 0, 0, 0, 1, 0, 0]), "expected 4 for each"),
    ],
)
def test_a_trajectory_that_does_not_fit_is_refused(moving, reason):
    made = schedule()
    made.decide(0.0)
    with pytest.raises(InputError, match=f"here: trajectories.0.: .*{reason}"):
        decode(0.0, 1, encode(made.timeline.newest), 1, "here", moving=[moving], arms=[ARM])


def test_a_posture_is_of_the_joints_jerk_and_no_more():
    """Velocities that are given are met, and the third derivative does not jump."""
    rng = np.random.default_rng(0)
    rates = np.vstack((rng.normal(size=(4, 2)), np.zeros(2)))
    curve = Spline([0.0, 1.0, 1.5, 3.0, 3.2], rng.normal(size=(5, 2)), rates)
    for time, rate in zip(curve.times[:-1], rates, strict=False):
        np.testing.assert_allclose(curve.rate(time + 1e-9), rate, atol=1e-6)
    third = curve._curve.derivative(3)
    for time in curve.times[1:-1]:
        np.testing.assert_allclose(third(time - 1e-9), third(time), rtol=1e-4)
    with pytest.raises(InputError, match=r"rates.4.: must be zero: the reference rests at the end"):
        Spline(curve.times, curve.values, rates + 1.0)
