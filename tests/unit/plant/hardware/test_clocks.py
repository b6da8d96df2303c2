"""Stamps of the adapter by the wall's clock: evenly spaced, whatever happens to the process."""

from __future__ import annotations

import numpy as np
import pytest

from lexstack_plant.hardware.clocks import WallClock

_SINCE_1970 = 1_800_000_000_123_456_789  # ns


class Clocks:
    """Both clocks of a host, for a process that is interrupted before every look at them."""

    def __init__(self):
        self.now, self.off, self.interrupted = 100.0, _SINCE_1970, 0.0

    def monotonic(self):
        self.now += 1e-7 + self.interrupted
        return self.now

    def wall(self):
        self.now += 1e-7 + self.interrupted
        return round(1e9 * self.now) + self.off


@pytest.fixture
def clocks():
    return Clocks()


def nanoseconds(stamp):
    return 1_000_000_000 * stamp.sec + stamp.nanosec


def test_stamps_are_as_far_apart_as_their_times_though_the_process_is_interrupted(clocks):
    clock, random, stamps = WallClock(clocks.monotonic, clocks.wall), np.random.default_rng(0), []
    for tick in range(200):
        clocks.interrupted = float(random.choice([0.0, 0.0, 0.003, 0.02]))
        stamps.append(nanoseconds(clock.stamp(100.0 + 0.01 * tick)) - _SINCE_1970)
    assert np.abs(np.diff(stamps) - 10_000_000).max() <= 1
    assert stamps[0] == pytest.approx(100e9, abs=1e3)


def test_stamps_follow_a_wall_that_is_set(clocks):
    clock = WallClock(clocks.monotonic, clocks.wall)
    clocks.off += 3_600_000_000_000
    assert nanoseconds(clock.stamp(100.0)) - clocks.off == pytest.approx(100e9, abs=1e3)
