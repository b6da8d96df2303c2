"""Limits that change at run time: no empty box, no acceleration beyond, inside in least time."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lexstack.limits import JointLimits, LimitBlend, Motion, target_bounds, viable_bounds

N = 20
OUTSIDE = 1e-9
RATIO = 1.0 + 1e-9
SEEDS = st.integers(0, 2**32 - 1)
PERIODS = st.sampled_from([0.002, 0.01])


def random_limits(rng, jerk):
    """Return limits whose ranges overlap, or not, with those of another call."""
    lower = rng.uniform(-3.0, 0.0, N)
    upper = lower + 10.0 ** rng.uniform(-0.5, 0.7, N)
    free = rng.random(N) < 0.1
    acceleration = 10.0 ** rng.uniform(-0.3, 1.5, N)
    return JointLimits(
        np.where(free, -np.inf, lower),
        np.where(free, np.inf, upper),
        10.0 ** rng.uniform(-0.3, 0.7, N),
        acceleration,
        acceleration * 10.0 ** rng.uniform(1.0, 3.0, N) if jerk else np.full(N, np.inf),
    )


def moving(rng, limits, dt, *, jerk):
    """Return how joints move after a while at random within their limits."""
    low, high = np.maximum(limits.position_lower, -3.0), np.minimum(limits.position_upper, 3.0)
    q = rng.uniform(low, high)
    if not jerk:
        stops = target_bounds(q, limits, dt)
        return Motion(q, rng.uniform(stops.lower, stops.upper), dt)
    v, a, side = np.zeros(N), np.zeros(N), rng.choice([-1.0, 1.0], N)
    for _ in range(rng.integers(1, 100)):
        box = viable_bounds(q, limits, dt, v, acceleration=a)
        chi = np.where(side > 0.0, box.upper, box.lower)
        q, v, a = q + dt * chi, chi, (chi - v) / dt
    return Motion(q, v, dt, a)


def ahead(blend, motion, choose, settle=50):
    """Yield tick, limits, box, motion before and after, until all are inside ``new`` and on.

    ``choose`` says where in its box each joint goes, from 0 inward to 1 outward.
    """
    new, dt = blend.new, motion.dt
    middle = 0.5 * (np.maximum(new.position_lower, -9.0) + np.minimum(new.position_upper, 9.0))
    for tick in range(blend.start, blend.end + 5000 + back_at_the_latest(new, motion)):
        limits, q, v = blend.at(tick), motion.position, motion.applied
        box = viable_bounds(q, limits, dt, v, acceleration=motion.acceleration)
        out = np.where(q > middle, choose, 1.0 - choose)
        chi = box.lower + out * (box.upper - box.lower)
        after = Motion(
            q + dt * chi, chi, dt, None if motion.acceleration is None else (chi - v) / dt
        )
        yield tick, limits, box, motion, after
        motion = after
        if tick >= blend.end + settle and np.all(outside(motion.position, new) <= 0.0):
            return


def back_at_the_latest(limits, motion):
    """Return in how many ticks all joints stop and come back at their velocity limit."""
    speed, rate = np.abs(motion.applied), limits.acceleration
    stops = speed / rate
    way = np.maximum(outside(motion.position, limits), 0.0) + speed * (stops + motion.dt)
    time = stops + way / limits.velocity + 2.0 * limits.velocity / rate
    return int(np.max(time) / motion.dt)


def outside(q, limits):
    """Return how far outside its limits each joint is, negative inside."""
    return np.maximum(q - limits.position_upper, limits.position_lower - q)


def blended(seed, dt, duration=0.0, *, jerk=False):
    rng = np.random.default_rng(seed)
    old, new = random_limits(rng, jerk), random_limits(rng, jerk)
    motion = moving(rng, old, dt, jerk=jerk)
    return old, motion, LimitBlend.begin(old, new, motion, 7, duration), rng.choice([0, 0.5, 1], N)


@settings(max_examples=30, derandomize=True, deadline=None)
@given(seed=SEEDS, dt=PERIODS, duration=st.sampled_from([0.0, 0.0, 0.3]), jerk=st.booleans())
def test_never_empty_never_beyond_and_inside_in_the_end(seed, dt, duration, jerk):
    old, motion, blend, choose = blended(seed, dt, duration, jerk=jerk)
    larger = np.maximum(old.acceleration, blend.new.acceleration)
    for _, limits, box, before, after in ahead(blend, motion, choose):
        assert box.empty == 0
        assert np.all(limits.acceleration <= larger)
        change = np.abs(after.applied - before.applied)
        assert np.all(change <= limits.acceleration * dt * RATIO + 1e-14)
        if jerk:
            able = np.abs(before.acceleration) <= limits.acceleration * RATIO
            jerks = np.abs(after.acceleration - before.acceleration)
            assert np.all((jerks <= limits.jerk * dt * RATIO + 1e-9)[able])
    assert np.all(outside(after.position, blend.new) <= OUTSIDE)


def least_time(motion, new):
    """Return per joint and side when a double integrator is inside, by simulation in fine steps.

    v falls at the acceleration limit down to the velocity limit; nan where it starts inside.
    """
    times = []
    for sign, wall in ((-1.0, new.position_lower), (1.0, new.position_upper)):
        out, v = sign * (motion.position - wall), sign * motion.applied
        a, fastest = new.acceleration, new.velocity
        t = np.linspace(0.0, 40.0, 20001)[:, None]
        braked = np.minimum(t, (v + fastest) / a)
        inside = out + v * braked - 0.5 * a * braked**2 - fastest * (t - braked) <= 0.0
        arrives = (out > 0.0) & inside.any(axis=0)
        times.append(np.where(arrives, t[inside.argmax(axis=0), 0], np.nan))
    return np.fmax(*times)


@pytest.mark.parametrize(
    ("seed", "jerk"),
    [
        pytest.param(1080, False, id="too fast for the new acceleration beyond the time given"),
        pytest.param(28, True, id="the same with jerk limits"),
        pytest.param(2, False, id="6 m outside, 0.65 m/s: on its way for longer than most"),
    ],
)
def test_cases_that_were_wrong_once(seed, jerk):
    test = test_never_empty_never_beyond_and_inside_in_the_end
    test.hypothesis.inner_test(seed, 0.002, 0.3, jerk)


@settings(max_examples=10, derandomize=True, deadline=None)
@given(seed=SEEDS, dt=PERIODS)
def test_inside_in_the_least_time_that_velocity_and_acceleration_allow(seed, dt):
    """At most 5 percent or one tick above it, where there is room to stop behind the limit."""
    _, motion, blend, _ = blended(seed, dt)
    new = blend.new
    best = least_time(motion, new)
    roomy = new.position_upper - new.position_lower > new.velocity**2 / new.acceleration
    slow = np.abs(motion.applied) <= new.velocity
    since = np.full(N, np.nan)
    for tick, _, _, _, after in ahead(blend, motion, 1.0):
        inside = outside(after.position, new) <= OUTSIDE
        time = (tick + 1 - blend.start) * dt
        since = np.where(inside, np.where(np.isnan(since), time, since), np.nan)
    timed = np.isfinite(best) & roomy & slow & (best < 39.0)
    most = np.maximum(1.05 * best, best + dt) + 0.002  # the step of the simulation
    assert np.all((since <= most)[timed])


@settings(max_examples=20, derandomize=True, deadline=None)
@given(seed=SEEDS, dt=PERIODS, jerk=st.booleans())
def test_a_joint_that_can_stop_with_the_old_acceleration_never_leaves_the_new_limits(
    seed, dt, jerk
):
    """A smaller acceleration limit waits until the joint stands where it is too fast for it."""
    rng = np.random.default_rng(seed)
    old = random_limits(rng, jerk)
    new = replace(old, acceleration=old.acceleration * rng.uniform(0.05, 1.0, N))
    motion = moving(rng, old, dt, jerk=jerk)
    blend = LimitBlend.begin(old, new, motion, 0)
    for _, _, _, _, after in ahead(blend, motion, 1.0, settle=300):
        assert np.all(outside(after.position, new) <= OUTSIDE)
    if not jerk:
        assert blend.end * dt <= np.max(np.abs(motion.applied) / old.acceleration) + dt


@settings(max_examples=20, derandomize=True, deadline=None)
@given(seed=SEEDS, dt=PERIODS)
def test_pre_empted_on_the_way_it_goes_on_without_an_empty_box(seed, dt):
    old, motion, blend, choose = blended(seed, dt)
    rng = np.random.default_rng(seed + 1)
    other = random_limits(rng, jerk=False)
    larger = np.maximum(np.maximum(old.acceleration, blend.new.acceleration), other.acceleration)
    cut = blend.start + rng.integers(0, max(blend.end - blend.start, 1))
    for tick, limits, _, before, after in ahead(blend, motion, choose):
        motion = before
        if tick == cut:
            blend = LimitBlend.begin(limits, other, before, tick)
            break
        motion = after
    for _, _, box, before, after in ahead(blend, motion, choose):
        assert box.empty == 0
        assert np.all(np.abs(after.applied - before.applied) <= larger * dt * RATIO)
    assert np.all(outside(after.position, blend.new) <= OUTSIDE)


@pytest.mark.parametrize("fault", ["not drawn inside", "released too soon", "new acceleration"])
def test_the_tests_above_can_fail(fault, monkeypatch):
    test = test_inside_in_the_least_time_that_velocity_and_acceleration_allow
    if fault == "not drawn inside":
        monkeypatch.setattr(LimitBlend, "at", lambda self, tick: self.new)
    elif fault == "released too soon":
        monkeypatch.setattr(
            "lexstack.limits.limit_timing._time_to_cross", lambda room, v, *_: np.full_like(v, 0.01)
        )
    else:
        test = test_a_joint_that_can_stop_with_the_old_acceleration_never_leaves_the_new_limits
        monkeypatch.setattr("lexstack.limits.limit_transition._eased", lambda old, new, fast: new)
    args = (False,) if fault == "new acceleration" else ()
    with pytest.raises(AssertionError):
        [test.hypothesis.inner_test(seed, 0.01, *args) for seed in range(5)]
