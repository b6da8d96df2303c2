"""From every state the box holds something, and whoever stays in it stays inside the limits."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lexstack.limits import JointLimits, target_bounds, viable_bounds

N = 20
ROUNDING = 1e-12
OUTSIDE = 1e-9
SEEDS = st.integers(0, 2**32 - 1)
PERIODS = st.sampled_from([0.001, 0.002, 0.01, 0.1, 0.5])


def random_limits(rng):
    """From sluggish to so strong that a joint may cross its range in a few periods."""
    lower = rng.uniform(-3.0, 1.0, N)
    upper = lower + 10.0 ** rng.uniform(-3.0, 1.0, N)
    free = rng.random(N) < 0.2
    return JointLimits(
        np.where(free, -np.inf, lower),
        np.where(free, np.inf, upper),
        10.0 ** rng.uniform(-2.0, 1.0, N),
        10.0 ** rng.uniform(-1.0, 2.5, N),
        np.full(N, np.inf),
    )


def random_start(rng, limits, dt):
    """Return a state inside: one from which the box of the next step reaches into [L, U]."""
    low = np.maximum(limits.position_lower, -5.0)
    high = np.minimum(limits.position_upper, 5.0)
    q = rng.uniform(low, high)
    stops = target_bounds(q, limits, dt)
    reach = limits.acceleration * dt
    return q, rng.uniform(stops.lower - reach, stops.upper + reach)


@settings(max_examples=300, derandomize=True, deadline=None)
@given(seed=SEEDS, dt=PERIODS, late=st.booleans())
def test_never_empty_and_never_beyond_the_acceleration(seed, dt, late):
    rng = np.random.default_rng(seed)
    limits = random_limits(rng)
    q = rng.uniform(-10.0, 10.0, N)
    applied = rng.uniform(-3.0, 3.0, N) * limits.velocity
    reach = limits.acceleration * dt
    sent = applied + rng.uniform(-3.0, 3.0, N) * reach if late else None
    box = viable_bounds(q, limits, dt, applied, sent)
    assert box.empty == 0
    assert np.all(box.lower >= applied - reach - ROUNDING)
    assert np.all(box.upper <= applied + reach + ROUNDING)
    if late:
        near = np.abs(applied - sent) <= 2.0 * reach - ROUNDING
        assert np.all((box.lower >= sent - reach - ROUNDING)[near])
        assert np.all((box.upper <= sent + reach + ROUNDING)[near])
    assert target_bounds(q, limits, dt).empty == 0


@settings(max_examples=100, derandomize=True, deadline=None)
@given(seed=SEEDS, dt=PERIODS)
@pytest.mark.parametrize("habit", ["anything", "upper", "lower", "back and forth"])
def test_inside_for_ever(habit, seed, dt):
    rng = np.random.default_rng(seed)
    limits = random_limits(rng)
    q, v = random_start(rng, limits, dt)
    for step in range(200):
        box = viable_bounds(q, limits, dt, v)
        share = {
            "anything": rng.choice([0.0, 1.0, rng.random()], N),
            "upper": np.ones(N),
            "lower": np.zeros(N),
            "back and forth": np.full(N, step // 20 % 2),
        }[habit]
        chi = box.lower + share * (box.upper - box.lower)
        assert np.all(np.abs(chi - v) <= limits.acceleration * dt + ROUNDING)
        assert np.all(np.abs(chi) <= np.maximum(limits.velocity, np.abs(v)) + ROUNDING)
        q, v = q + dt * chi, chi
        assert np.all(q >= limits.position_lower - OUTSIDE)
        assert np.all(q <= limits.position_upper + OUTSIDE)


@settings(max_examples=20, derandomize=True, deadline=None)
@given(seed=SEEDS, dt=PERIODS.filter(lambda dt: dt > 0.001))
def test_pushed_against_a_limit_a_joint_arrives_there(seed, dt):
    # The box is not safe by standing still: it uses the room that there is.
    rng = np.random.default_rng(seed)
    limits = JointLimits(*(np.full(N, x) for x in (-1.0, 1.0, 2.0, 5.0, np.inf)))
    q, v = rng.uniform(-1.0, 1.0, N), np.zeros(N)
    for _ in range(int(4.0 / dt) + 10):
        v = viable_bounds(q, limits, dt, v).upper
        q = q + dt * v
    np.testing.assert_allclose(q, 1.0, atol=1e-3)


@settings(max_examples=20, derandomize=True, deadline=None)
@given(seed=SEEDS, dt=PERIODS.filter(lambda dt: dt > 0.001))
def test_from_outside_back_in_and_never_further_out(seed, dt):
    rng = np.random.default_rng(seed)
    limits = JointLimits(*(np.full(N, x) for x in (-1.0, 1.0, 2.0, 5.0, np.inf)))
    side = rng.choice([-1.0, 1.0], N)
    q, v = side * (1.0 + rng.uniform(0.0, 2.0, N)), np.zeros(N)
    outside = np.abs(q) - 1.0
    for _ in range(int(6.0 / dt) + 10):
        box = viable_bounds(q, limits, dt, v)
        chi = box.lower + rng.random(N) * (box.upper - box.lower)
        q, v = q + dt * chi, chi
        further = np.maximum(np.abs(q) - 1.0, 0.0)
        assert np.all(further <= np.maximum(outside, 0.0) + OUTSIDE)
        outside = further
    assert np.all(outside <= 1e-3)


@settings(max_examples=100, derandomize=True, deadline=None)
@given(seed=SEEDS, dt=PERIODS)
def test_too_fast_brakes_with_all_there_is(seed, dt):
    rng = np.random.default_rng(seed)
    limits = random_limits(rng)
    reach = limits.acceleration * dt
    v = limits.velocity + reach * rng.uniform(1.0, 50.0, N)
    q = rng.uniform(-1.0, 1.0, N)
    box = viable_bounds(q, limits, dt, v)
    np.testing.assert_allclose(box.lower, v - reach, rtol=1e-12)
    np.testing.assert_allclose(box.upper, v - reach, rtol=1e-12)
