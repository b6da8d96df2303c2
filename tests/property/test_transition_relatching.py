"""Whatever comes in mid-blend, in any order and number: the blend ends, and nothing winds up."""

import itertools

import numpy as np
import pytest

from lexstack.transition import Source
from support.scenario import team
from support.trains import Train, path_lengths, random_train, run, still_blending

LITTLE = 0.05  # m: below it a ratio of ways says nothing


def within_limits(result):
    """Return whether every command kept velocity and acceleration limits, and was solved."""
    limits = team().limits
    chi = np.array([command.chi for command in result.record.commands])
    steps = np.abs(np.diff(chi, axis=0)) / (result.parts.dt * limits.acceleration)
    speeds = np.abs(chi) / limits.velocity
    solved = not any(command.fallback for command in result.record.commands)
    return solved and steps.max() <= 1.0 + 1e-9 and speeds.max() <= 1.0 + 1e-12


def check(train, most=1.5):
    """Check what holds for any train of events, and return its run.

    ``most``: way over that with a perfect solver.
    """
    result = run(train)
    assert not still_blending(result), "it ends within its duration and the stated time"
    assert within_limits(result)
    perfect = path_lengths(run(train, perfect=True))
    went = path_lengths(result)
    assert (went <= most * perfect + LITTLE).all(), (went, perfect)
    return result


@pytest.mark.parametrize("seed", range(12))
def test_a_train_of_events_neither_holds_a_blend_open_nor_winds_it_up(seed):
    check(random_train(seed, 400))


@pytest.mark.parametrize("seed", [1, 2, 204])
def test_where_b_has_other_references_and_nobody_knows_the_motion_stays_bounded(seed):
    """So it was: the solver applied targets at other ticks, and the bases ran to 20 m."""
    check(random_train(seed, 600, named=False), most=2.5)


@pytest.mark.parametrize("seed", [203, 204])
def test_twenty_seconds_of_events_at_sixty_hertz(seed):
    check(random_train(seed, 2000))


def stream(mode, lag, *, lead=0.0, named=False, until=700):
    """Return targets of both tools at 60 Hz, +-0.3 m at 1 Hz, ``lag`` ticks later at the solver."""
    ticks = np.arange(0.0, until, 100.0 / 60.0).astype(int)
    swing = 0.3 * np.sin(2.0 * np.pi * ticks / 100.0)
    targets = tuple(
        (int(tick), robot, np.array([x, 0.0, 0.0]))
        for tick, x in zip(ticks, swing, strict=True)
        for robot in (0, 1)
    )
    switches = ((100, "reach_base", ()),)
    silent, delays = frozenset[int](), np.full(until, int(mode == "realtime"))
    lags = (lag,) * len(targets)
    return Train(mode, 1.0, switches, targets, lags, lead, named, silent, delays, until)


@pytest.mark.parametrize("mode", ["lockstep", "realtime"])
def test_a_stream_that_b_has_a_tick_late_does_not_drive_the_bases_away(mode):
    """Each tick the solver is lost and back: the velocity grew by what each latch carried on."""
    told = [command.transition for command in check(stream(mode, 1)).record.commands]
    changes = sum(a.reason != b.reason for a, b in itertools.pairwise(told))
    assert changes <= 10, "574 in the run that was reported"


def test_a_stream_of_steps_does_not_keep_a_blend_open():
    """Ten sets of targets are bridged, the rest are followed as they are without a switch."""
    result = run(stream("lockstep", 0))
    assert within_limits(result)
    last = max(c.tick for c in result.record.commands if c.transition.source is not Source.NONE)
    assert last < 400, "the stream goes on to tick 700"


def test_a_stream_that_is_led_in_leaves_the_blend_its_own_time():
    result = run(stream("lockstep", 0, lead=0.5, named=True))
    blending = [c.tick for c in result.record.commands if c.transition.source is not Source.NONE]
    assert (blending[0], blending[-1]) == (100, 200)
    assert not any(command.transition.reason for command in result.record.commands)
