"""The compiled box: the bits of the plain form, and nothing compiled at a call."""

import sys

import numpy as np
import pytest

from lexstack.control.kernels import load_kernels
from lexstack.limits import JointLimits, target_bounds, viable_bounds
from lexstack.limits.kernel import box as kernel

load_kernels()
plain = sys.modules["lexstack.limits.viable_bounds"]
DT = 0.01


def draw(rng):
    """Return the limits and the motion of some joints, some without limits, some beyond them."""
    n = int(rng.integers(1, 12))
    lower = rng.uniform(-3.0, 0.0, n)
    upper = lower + rng.uniform(0.0, 4.0, n) * rng.choice([0.0, 1.0, 1.0], n)
    lower[rng.random(n) < 0.2], upper[rng.random(n) < 0.2] = -np.inf, np.inf
    jerk = np.where(rng.random(n) < 0.3, np.inf, 10.0 ** rng.uniform(-1.0, 3.0, n))
    limits = JointLimits(
        lower, upper, rng.uniform(0.05, 2.0, n), 10.0 ** rng.uniform(-1.0, 1.0, n), jerk
    )
    velocity = rng.normal(size=n) * rng.choice([0.01, 1.0])
    sent = velocity + rng.normal(size=n) * rng.choice([0.0, 0.01, 1.0])
    acceleration = rng.normal(size=n) * 3.0
    position = rng.uniform(-3.5, 3.5, n)
    if rng.random() < 0.05:
        position[0] = np.nan
    return position, limits, velocity, sent, acceleration


def same(one, other):
    """Hold two boxes against each other, bit by bit."""
    np.testing.assert_array_equal(one.lower, other.lower)
    np.testing.assert_array_equal(one.upper, other.upper)


def test_the_compiled_box_has_the_bits_of_the_plain_one():
    rng = np.random.default_rng(1)
    for _ in range(1500):
        q, limits, v, sent, a = draw(rng)
        for last in (None, v, sent):
            for acceleration in (None, a):
                given = (q, limits, DT, v, last, acceleration)
                same(viable_bounds(*given), plain._in_arrays(*given))
        same(target_bounds(q, limits, DT), plain._target_in_arrays(q, limits, DT))


def test_without_numba_the_plain_form_runs(monkeypatch):
    monkeypatch.setattr(plain, "kernel", lambda _name: None)
    q, limits, v, sent, a = draw(np.random.default_rng(2))
    same(viable_bounds(q, limits, DT, v, sent, a), plain._in_arrays(q, limits, DT, v, sent, a))
    same(target_bounds(q, limits, DT), plain._target_in_arrays(q, limits, DT))


def test_a_box_is_read_only_and_takes_arrays_of_any_layout():
    q, limits, v, sent, a = draw(np.random.default_rng(3))
    spread = [np.repeat(array, 2)[::2] for array in (q, v, sent, a)]
    box = viable_bounds(spread[0], limits, DT, spread[1], spread[2], spread[3])
    same(box, viable_bounds(q, limits, DT, v, sent, a))
    assert not box.lower.flags.writeable
    assert not box.upper.flags.writeable
    for function in (kernel.target, kernel.command, kernel.with_jerk):
        assert len(function.signatures) == 1


def test_a_state_in_whole_numbers_is_taken_and_one_of_another_length_is_not():
    limits = JointLimits(-np.ones(2), np.ones(2), np.ones(2), np.ones(2), np.ones(2))
    zeros = np.zeros(2, dtype=int)
    same(
        viable_bounds(zeros, limits, DT, zeros), viable_bounds(0.0 * zeros, limits, DT, 0.0 * zeros)
    )
    same(target_bounds(zeros, limits, DT), target_bounds(0.0 * zeros, limits, DT))
    for position, applied in ((np.zeros(3), np.zeros(3)), (np.zeros(2), np.zeros(1))):
        with pytest.raises(ValueError, match="fit"):
            viable_bounds(position, limits, DT, applied)
