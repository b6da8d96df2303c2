"""The law that drives a unicycle to a pose: from everywhere, under limits, and as it is proved."""

import itertools
import math

import numpy as np
import pytest

from lexstack.robots import wrap
from lexstack.tasks.unicycle_law import paced, tracking_rates, unicycle_rates

GAIN, DT = 0.7, 0.01  # 1/s, s
SPEEDS, RATES = (0.8, 1.5), (1.0, 2.0)  # m/s and rad/s, m/s2 and rad/s2
GOAL = (0.4, -0.3, 2.5)  # m, m, rad

_random = np.random.default_rng(5)
STARTS = [
    GOAL,
    (GOAL[0] - math.sin(GOAL[2]), GOAL[1] + math.cos(GOAL[2]), GOAL[2]),  # beside: parallel parking
    (GOAL[0] + math.cos(GOAL[2]), GOAL[1] + math.sin(GOAL[2]), GOAL[2]),  # behind the goal
    (GOAL[0], GOAL[1], GOAL[2] + math.pi),  # turned about
    *((*_random.uniform(-3.0, 3.0, 2), _random.uniform(-math.pi, math.pi)) for _ in range(96)),
]


def limited(wanted, held):
    """Return rates of the same ratio within the speeds, reached within the accelerations."""
    factor = 1.0 / max(1.0, *(abs(w) / most for w, most in zip(wanted, SPEEDS, strict=True)))
    steps = zip(wanted, held, RATES, strict=True)
    return tuple(h + min(max(factor * w - h, -r * DT), r * DT) for w, h, r in steps)


@pytest.mark.parametrize("start", STARTS)
def test_it_ends_within_5_mm_and_5_mrad_and_at_rest(start):
    x, y, yaw = start
    rates = (0.0, 0.0)
    for _ in range(3000):
        wanted = unicycle_rates((GOAL[0] - x, GOAL[1] - y), yaw, GOAL[2], GAIN)
        rates = v, w = limited(wanted, rates)
        middle = yaw + 0.5 * DT * w
        x, y, yaw = x + DT * v * math.cos(middle), y + DT * v * math.sin(middle), yaw + DT * w
        if math.hypot(GOAL[0] - x, GOAL[1] - y) < 3e-3 and max(map(abs, rates)) < 1e-4:
            break  # it stands
    assert math.hypot(GOAL[0] - x, GOAL[1] - y) < 5e-3
    assert abs(wrap(GOAL[2] - yaw)) < 5e-3
    assert max(map(abs, rates)) < 1e-3


def polar(x, y, yaw):
    """Return r, a and b of the proof at a pose; the goal is the origin, maybe behind."""
    bearing = math.atan2(-y, -x)
    if abs(wrap(bearing - yaw)) > 0.5 * math.pi:
        bearing += math.pi
    return math.hypot(x, y), wrap(bearing - yaw), wrap(bearing)


def energy(x, y, yaw):
    """Return V of the proof at a pose."""
    r, a, b = polar(x, y, yaw)
    return 0.5 * (r * r + a * a + 4.0 * b * b)


def test_the_lyapunov_function_decreases_as_the_proof_says():
    drawn = np.random.default_rng(7)
    for _ in range(500):
        x, y, yaw = *drawn.uniform(-3.0, 3.0, 2), drawn.uniform(-math.pi, math.pi)
        v, w = unicycle_rates((-x, -y), yaw, 0.0, GAIN)
        h = 1e-6
        moved = (x + h * v * math.cos(yaw), y + h * v * math.sin(yaw), yaw + h * w)
        back = (x - h * v * math.cos(yaw), y - h * v * math.sin(yaw), yaw - h * w)
        slope = (energy(*moved) - energy(*back)) / (2.0 * h)
        r, a, _ = polar(x, y, yaw)
        expected = -GAIN * (r * math.cos(a)) ** 2 - 4.0 * GAIN * a * a
        assert slope == pytest.approx(expected, rel=1e-5, abs=1e-7)


def test_a_goal_behind_is_reached_in_reverse_and_a_way_once_chosen_is_kept():
    v, w = unicycle_rates((-0.5, 0.0), 0.0, 0.0, GAIN)
    assert v == pytest.approx(-0.5 * GAIN)
    assert w == pytest.approx(0.0, abs=1e-15)
    drawn = np.random.default_rng(9)
    for _ in range(200):  # at either side of |a| = pi / 2 the bearing leaves this border
        bearing, side = drawn.uniform(-math.pi, math.pi), drawn.choice([-1.0, 1.0])
        for inside in (1e-6, -1e-6):
            yaw = bearing - side * (0.5 * math.pi - inside)
            v, w = unicycle_rates(
                (math.cos(bearing), math.sin(bearing)), yaw, drawn.uniform(-math.pi, math.pi), GAIN
            )
            change = side * (v * math.sin(bearing - yaw) - w)  # of |a|, seen from the heading
            assert change * inside < 0.0


def needed(start):
    """Return the largest acceleration that the paced law asks for, of those that there are."""
    x, y, yaw = start
    step, before, most = 5e-3, None, 0.0
    for _ in range(5000):
        v, w = paced((GOAL[0] - x, GOAL[1] - y), yaw, GOAL[2], GAIN, (SPEEDS, RATES))
        assert abs(v) <= SPEEDS[0]
        assert abs(w) <= SPEEDS[1]
        if before is not None:
            change = (abs(v - before[0]) / RATES[0], abs(w - before[1]) / RATES[1])
            most = max(most, max(change) / step)
        before = v, w
        middle = yaw + 0.5 * step * w
        x, y = x + step * v * math.cos(middle), y + step * v * math.sin(middle)
        yaw += step * w
    assert math.hypot(GOAL[0] - x, GOAL[1] - y) < 5e-3
    assert abs(wrap(GOAL[2] - yaw)) < 5e-3
    return most


def test_a_paced_base_keeps_its_speeds_and_hardly_needs_a_box_of_accelerations():
    most = np.array([needed(start) for start in STARTS[1::3]])
    assert np.median(most) < 0.7
    # A change of the pace itself may ask for more, and the law jumps where b = pi.
    assert np.mean(most < 1.9) > 0.95


@pytest.mark.parametrize("forward", [1.0, -1.0])
def test_the_tracking_law_settles_on_a_pose_that_drives(forward):
    drawn, step = np.random.default_rng(11), 0.01
    for _ in range(20):
        pose = np.zeros(3)
        x, y, yaw = drawn.uniform((-0.3, -0.3, -1.0), (0.3, 0.3, 1.0))
        for k in itertools.count():
            v_d, w_d = 0.4 * forward, 0.3 * math.sin(0.01 * k)
            gap = (pose[0] - x, pose[1] - y)
            if k == 2000:
                break
            v, w = tracking_rates(gap, yaw, (pose[2], v_d, w_d), 1.0)
            middle = pose[2] + 0.5 * step * w_d
            pose += step * np.array([v_d * math.cos(middle), v_d * math.sin(middle), w_d])
            middle = yaw + 0.5 * step * w
            x, y = x + step * v * math.cos(middle), y + step * v * math.sin(middle)
            yaw += step * w
        assert math.hypot(*gap) < 1e-3
        assert abs(wrap(pose[2] - yaw)) < 1e-3
