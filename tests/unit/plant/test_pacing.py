"""Deadlines in lockstep and realtime, on a clock of the test's own."""

from __future__ import annotations

import numpy as np
import pytest

from lexstack_plant.pacing import Pacer, Sparse

PERIOD, PATIENCE = 0.01, 2.0


def test_lockstep_waits_long_until_a_command_was_missed():
    pacer = Pacer("lockstep", PERIOD, PATIENCE)
    pacer.start(5.0)
    pacer.begin(5.0)
    assert pacer.deadline == pytest.approx(5.0 + PATIENCE)
    pacer.missed()
    pacer.begin(7.0)
    assert pacer.deadline == pytest.approx(7.0 + PERIOD)


def test_lockstep_waits_long_again_once_any_command_came():
    pacer = Pacer("lockstep", PERIOD, PATIENCE)
    pacer.start(0.0)
    pacer.begin(0.0)
    pacer.missed()
    pacer.begin(2.0)
    pacer.answered()
    assert pacer.deadline == pytest.approx(2.0 + PATIENCE)
    pacer.begin(2.001)
    assert pacer.deadline == pytest.approx(2.001 + PATIENCE)


def test_realtime_deadlines_do_not_drift():
    pacer = Pacer("realtime", PERIOD, PATIENCE)
    pacer.start(1.0)
    for tick in range(1000):
        pacer.begin(1.0 + tick * PERIOD + 0.001)  # each a little late
        assert pacer.deadline == pytest.approx(1.0 + (tick + 1) * PERIOD)
    assert pacer.late_ticks == 0


def test_realtime_catches_up_and_leaves_half_a_period_to_each_command():
    pacer = Pacer("realtime", PERIOD, PATIENCE)
    pacer.start(0.0)
    pacer.begin(0.0)
    now, times = 0.027, []  # ticks 1 and 2 are over already
    for _ in range(6):
        pacer.begin(now)
        assert pacer.deadline - now >= 0.5 * PERIOD - 1e-12
        now = pacer.deadline
        times.append(now)
    assert times[-1] == pytest.approx(7 * PERIOD)  # back on the schedule, nothing skipped
    assert pacer.late_ticks == 3
    assert pacer.restarts == 0


def test_realtime_starts_anew_when_far_behind():
    pacer = Pacer("realtime", PERIOD, PATIENCE)
    pacer.start(0.0)
    pacer.begin(0.0)
    pacer.begin(3.0)
    assert pacer.restarts == 1
    assert pacer.late_ticks == 1
    assert pacer.deadline == pytest.approx(3.0 + PERIOD)
    pacer.begin(3.0 + PERIOD)
    assert pacer.late_ticks == 1


@pytest.mark.parametrize(("tick", "jitter"), [(0.01, 0.003), (0.004, 0.0015), (0.0017, 0.0005)])
def test_what_is_for_onlookers_comes_at_its_rate_of_wall_time_in_the_mean(tick, jitter):
    rng, now = np.random.default_rng(0), [100.0]
    due, times = Sparse(50.0, tick, clock=lambda: now[0]), []
    for k in range(round(4.0 / tick)):
        now[0] = 100.0 + k * tick + rng.uniform(-jitter, jitter)
        if due():
            times.append(now[0])
    assert len(times) == pytest.approx(200, abs=2)
    assert np.diff(times).max() < 0.02 + tick + 2.0 * jitter


def test_what_is_for_onlookers_does_not_catch_up_after_a_pause():
    now = [0.0]
    due = Sparse(50.0, 0.01, clock=lambda: now[0])
    assert due()
    now[0] = 10.0
    assert [due() for _ in range(5)] == [True, False, False, False, False]


def test_realtime_starts_anew_on_its_grid():
    """A trajectory between two ticks would be shifted by the part of a period, and jerk."""
    pacer = Pacer("realtime", PERIOD, PATIENCE)
    pacer.start(0.0)
    pacer.begin(0.0)
    dues = []
    for now in (4.54 * PERIOD, 9.9 * PERIOD, 15.2 * PERIOD):
        pacer.begin(now)
        dues.append(pacer.due)
    assert pacer.restarts == 3
    assert dues == pytest.approx([5 * PERIOD, 10 * PERIOD, 16 * PERIOD])
