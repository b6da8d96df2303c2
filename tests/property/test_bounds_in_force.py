"""Limits and jerk that come and go: what can be kept is kept, whatever happens when."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lexstack.limits import JointLimits, LimitOptions, LimitsInForce, is_viable
from lexstack.types import RobotState

N = 20
TICKS = 150
KEPT = 1e-9
SEEDS = st.integers(0, 2**32 - 1)
PERIODS = st.sampled_from([0.002, 0.01, 0.05])


def random_limits(rng):
    lower = rng.uniform(-1.0, 0.5, N)
    upper = lower + 10.0 ** rng.uniform(-1.5, 0.5, N)
    free = rng.random(N) < 0.1
    acceleration = 10.0 ** rng.uniform(-0.5, 1.5, N)
    return JointLimits(
        np.where(free, -np.inf, lower),
        np.where(free, np.inf, upper),
        10.0 ** rng.uniform(-0.5, 0.5, N),
        acceleration,
        acceleration * 10.0 ** rng.uniform(0.5, 3.0, N),
    )


def ahead(rng, dt, wanted, jerk, q):
    """Yield tick, limits, box, and (q, v, a) before and after, from rest at ``q``.

    ``wanted`` tells the limits that are asked for at a tick, ``jerk`` whether with jerk.
    """
    force = LimitsInForce(wanted(0), LimitOptions(dt))
    v, a, goal = np.zeros(N), np.zeros(N), rng.choice([0.0, 1.0], N)
    for tick in range(TICKS):
        turns = rng.random(N) < 0.03
        goal = np.where(turns, rng.choice([0.0, 0.5, 1.0], N), goal)
        state = RobotState(tick, dt * tick, q, v, q, v)
        limits, box = force.at(state, wanted(tick), v, jerk=jerk(tick))
        chi = box.lower + goal * (box.upper - box.lower)
        yield tick, limits, box, (q, v, a), (q + dt * chi, chi, (chi - v) / dt)
        q, v, a = q + dt * chi, chi, (chi - v) / dt


def switching(rng, *values):
    """Return a function of the tick that goes from value to value at random."""
    ticks = np.sort(rng.integers(1, TICKS, rng.integers(1, 8)))
    order = rng.integers(0, len(values), len(ticks) + 1)
    return lambda tick: values[order[np.searchsorted(ticks, tick, side="right")]]


@settings(max_examples=60, derandomize=True, deadline=None)
@given(seed=SEEDS, dt=PERIODS)
def test_whenever_jerk_is_limited_all_other_limits_are_kept(seed, dt):
    rng = np.random.default_rng(seed)
    own = random_limits(rng)
    jerk = switching(rng, True, False)
    low, high = (np.clip(x, -2.0, 2.0) for x in (own.position_lower, own.position_upper))
    for tick, _, box, before, (q, v, a) in ahead(
        rng, dt, lambda _: own, jerk, rng.uniform(low, high)
    ):
        assert box.empty == 0
        assert np.all(np.abs(v - before[1]) <= own.acceleration * dt * (1.0 + KEPT) + 1e-14)
        assert np.all(np.abs(v) <= own.velocity + KEPT)
        assert np.all((q >= own.position_lower - KEPT) & (q <= own.position_upper + KEPT))
        if jerk(tick):
            # A joint that can keep all limits with its jerk does, and it goes on to.
            able = is_viable(before[0], own, dt, *before[1:])
            assert np.all((np.abs(a - before[2]) <= own.jerk * dt * (1.0 + 1e-6) + 1e-9)[able])
            assert np.all(is_viable(q, own, dt, v, a)[able])


@settings(max_examples=60, derandomize=True, deadline=None)
@given(seed=SEEDS, dt=PERIODS)
def test_tighter_jerk_never_leads_out_of_a_limit(seed, dt):
    rng = np.random.default_rng(seed)
    own = random_limits(rng)
    tighter = replace(own, jerk=own.jerk * rng.uniform(0.01, 1.0, N))
    low, high = (np.clip(x, -2.0, 2.0) for x in (own.position_lower, own.position_upper))
    wanted = switching(rng, own, tighter)
    for _, _, box, before, (q, v, a) in ahead(
        rng, dt, wanted, lambda _: True, rng.uniform(low, high)
    ):
        assert box.empty == 0
        assert np.all(np.abs(a - before[2]) <= own.jerk * dt * (1.0 + 1e-6) + 1e-9)
        assert np.all(np.abs(v) <= own.velocity + KEPT)
        assert np.all((q >= own.position_lower - KEPT) & (q <= own.position_upper + KEPT))


@settings(max_examples=60, derandomize=True, deadline=None)
@given(seed=SEEDS, dt=PERIODS)
def test_any_limits_at_any_time_leave_a_choice_within_the_acceleration(seed, dt):
    rng = np.random.default_rng(seed)
    several = [random_limits(rng) for _ in range(3)]
    largest = np.max([limits.acceleration for limits in several], axis=0)
    jerk, wanted = switching(rng, True, False), switching(rng, *several)
    for _, limits, box, (_, v, _), (_, chi, _) in ahead(
        rng, dt, wanted, jerk, rng.uniform(-1.0, 1.0, N)
    ):
        assert box.empty == 0
        assert np.all(limits.acceleration <= largest)
        assert np.all(np.abs(chi - v) <= limits.acceleration * dt * (1.0 + KEPT) + 1e-14)


@pytest.mark.parametrize("fault", ["no wait", "jerk of another tick"])
def test_the_tests_above_can_fail(fault, monkeypatch):
    if fault == "no wait":
        monkeypatch.setattr(
            "lexstack.limits.limits_in_force.is_viable", lambda q, *_: np.ones(q.size, dtype=bool)
        )
        tests = (
            test_whenever_jerk_is_limited_all_other_limits_are_kept,
            test_tighter_jerk_never_leads_out_of_a_limit,
        )
    else:
        monkeypatch.setattr(LimitsInForce, "_acceleration", lambda *_: np.zeros(N))
        tests = (test_whenever_jerk_is_limited_all_other_limits_are_kept,)
    for test in tests:
        with pytest.raises(AssertionError):
            [test.hypothesis.inner_test(seed, 0.01) for seed in range(20)]
