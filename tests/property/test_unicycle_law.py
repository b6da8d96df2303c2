"""The law that drives a unicycle to a pose: from everywhere, under limits, and as it is proved."""

import math

import numpy as np
import pytest

from lexstack.robots.spatial import wrap
from lexstack.tasks.unicycle_law import unicycle_rates

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


def energy(x, y, yaw):
    """Return V of the proof at a pose; the goal is the origin."""
    bearing = math.atan2(-y, -x)
    return 0.5 * (x * x + y * y + wrap(bearing - yaw) ** 2 + 4.0 * wrap(bearing) ** 2)


def test_the_lyapunov_function_decreases_as_the_proof_says():
    drawn = np.random.default_rng(7)
    for _ in range(500):
        x, y, yaw = *drawn.uniform(-3.0, 3.0, 2), drawn.uniform(-math.pi, math.pi)
        v, w = unicycle_rates((-x, -y), yaw, 0.0, GAIN)
        h = 1e-6
        moved = (x + h * v * math.cos(yaw), y + h * v * math.sin(yaw), yaw + h * w)
        back = (x - h * v * math.cos(yaw), y - h * v * math.sin(yaw), yaw - h * w)
        slope = (energy(*moved) - energy(*back)) / (2.0 * h)
        a, r = wrap(math.atan2(-y, -x) - yaw), math.hypot(x, y)
        expected = -GAIN * (r * math.cos(a)) ** 2 - 4.0 * GAIN * a * a
        assert slope == pytest.approx(expected, rel=1e-5, abs=1e-7)
