"""Trajectories between ticks: acceleration and jerk of the commands hold at every time."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lexstack.limits import JointLimits
from lexstack_plant.hardware.braking import SmoothBrake
from lexstack_plant.hardware.spline import CommandSpline, Point, Quintic

DT = 0.01
LIMITS = JointLimits(
    np.full(3, -3.0),
    np.full(3, 3.0),
    np.array([2.0, 1.0, 3.0]),
    np.array([15.0, 7.5, 20.0]),
    np.array([7500.0, 300.0, 10000.0]),
)


def walk(seed, ticks=40):
    """Return commands that keep the limits from tick to tick, anyhow else."""
    random, brake = np.random.default_rng(seed), SmoothBrake(LIMITS, DT)
    chi, change, commands = np.zeros(3), np.zeros(3), []
    for _ in range(ticks):
        step = LIMITS.jerk * DT * DT
        most = LIMITS.acceleration * DT
        wanted = np.clip(change + random.uniform(-step, step), -most, most)
        fast = np.abs(chi + wanted) > 0.6 * LIMITS.velocity
        after = np.where(fast, brake(chi, change), chi + wanted)
        chi, change = after, after - chi
        commands.append(chi)
    return commands


class Consumer:
    """A controller that samples the newest trajectory at 1 kHz, as joint_trajectory_controller."""

    def __init__(self, q):
        self.path = [Point(0.0, q, np.zeros(3), np.zeros(3))]

    def take(self, points, at, now):
        here = self.sample(now)
        coming = [dataclasses.replace(p, time=p.time + at) for p in points]
        self.path = [here, *(p for p in coming if p.time > now + 1e-9)]

    def sample(self, now):
        while len(self.path) > 1 and self.path[1].time <= now:
            del self.path[0]
        if len(self.path) < 2:
            return dataclasses.replace(self.path[0], time=now)
        return Quintic(self.path[0], self.path[1]).point(now)


def followed(commands, ahead, delays):
    """Return where a consumer leads the joints, at 1 kHz; messages arrive after their delay [s]."""
    spline = CommandSpline(LIMITS, DT, ahead, hold=10)
    spline.begin(np.zeros(3), np.zeros(3))
    waiting = []
    for k, chi in enumerate(commands):
        spline.push(chi)
        waiting.append((k * DT + delays[k], k * DT, spline.points()))
    waiting.sort(key=lambda entry: (entry[0], entry[1]))
    consumer, path = Consumer(np.zeros(3)), []
    for step in range(round(1000 * DT * len(commands))):
        now = 1e-3 * step
        while waiting and waiting[0][0] <= now + 1e-9:
            _, at, points = waiting.pop(0)
            consumer.take(points, at, now)
        path.append(consumer.sample(now).position)
    return np.array(path)


def peaks(path):
    """Return the largest velocity, acceleration and jerk of a path at 1 kHz / limits."""
    v = np.diff(path, axis=0) / 1e-3
    a = np.diff(v, axis=0) / 1e-3
    j = np.diff(a, axis=0) / 1e-3
    return [
        float((np.abs(values) / most).max())
        for values, most in ((v, LIMITS.velocity), (a, LIMITS.acceleration), (j, LIMITS.jerk))
    ]


@given(st.integers(0, 10_000), st.integers(1, 5))
@settings(max_examples=8, deadline=None)
def test_a_consumer_at_1_khz_keeps_the_limits_of_the_commands(seed, ahead):
    commands = walk(seed)
    assert max(peaks(followed(commands, ahead, np.zeros(len(commands))))) <= 1.0 + 1e-6


@given(st.integers(0, 10_000), st.integers(2, 5))
@settings(max_examples=8, deadline=None)
def test_messages_may_be_late_by_all_points_but_one(seed, ahead):
    random, commands = np.random.default_rng(seed), walk(seed)
    # The first message has no trajectory before it that could go on.
    delays = np.concatenate([[0.0], random.uniform(0.0, (ahead - 1) * DT, len(commands) - 1)])
    delays = np.maximum.accumulate(np.arange(len(commands)) * DT + delays)
    delays -= np.arange(len(commands)) * DT
    late = followed(commands, ahead, delays)
    np.testing.assert_allclose(late, followed(commands, ahead, 0.0 * delays), atol=1e-9)


def test_later_messages_break_the_limits():
    commands = walk(3)
    delays = np.zeros(len(commands))
    delays[20:26] = 0.06 - DT * np.arange(6)
    assert max(peaks(followed(commands, 2, delays))) > 1.5


@given(st.integers(0, 10_000))
@settings(max_examples=8, deadline=None)
def test_a_consumer_that_hears_no_more_comes_to_rest_within_the_limits(seed):
    commands = walk(seed, 25)
    spline = CommandSpline(LIMITS, DT, 2, hold=10)
    spline.begin(np.zeros(3), np.zeros(3))
    for chi in commands:
        spline.push(chi)
    consumer = Consumer(np.zeros(3))
    consumer.path = spline.points()
    path = [consumer.sample(DT + 1e-3 * step).position for step in range(3000)]
    assert max(peaks(np.array(path))) <= 1.0 + 1e-3
    np.testing.assert_array_equal(path[-1], path[-100])


def test_what_is_in_flight_is_what_is_left_to_go():
    spline = CommandSpline(LIMITS, DT, 3, hold=10)
    spline.begin(np.ones(3), np.zeros(3))
    commands = walk(5)
    for chi in commands:
        spline.push(chi)
    total = 1.0 + DT * np.sum(commands, axis=0)
    np.testing.assert_allclose(spline.led + spline.in_flight, total, atol=1e-12)
    for _ in range(10):
        spline.push(np.zeros(3))
    np.testing.assert_allclose(spline.led, total, atol=1e-12)
    np.testing.assert_allclose(spline.in_flight, 0.0, atol=1e-12)


def test_a_moving_arm_is_taken_over_at_its_velocity():
    v = np.array([0.5, -0.2, 1.0])
    spline = CommandSpline(LIMITS, DT, 2, hold=10)
    spline.begin(np.zeros(3), v)
    spline.push(v)  # sent one period later
    first = spline.points()[0]
    np.testing.assert_allclose(first.position, 2 * DT * v)
    np.testing.assert_allclose(first.velocity, v)
    np.testing.assert_allclose(first.acceleration, 0.0)


@given(st.integers(0, 10_000), st.sampled_from([0.001, 0.004, 0.01, 0.02]))
@settings(max_examples=20, deadline=None)
def test_braking_keeps_acceleration_and_jerk_and_ends_at_rest(seed, dt):
    random = np.random.default_rng(seed)
    brake = SmoothBrake(LIMITS, dt)
    command = random.uniform(-LIMITS.velocity, LIMITS.velocity)
    change = random.uniform(-1.0, 1.0, 3) * LIMITS.acceleration * dt
    jerk = np.minimum(LIMITS.jerk, 2.0 * LIMITS.acceleration / dt)
    speeds = [np.abs(command)]
    for _ in range(round(3.0 / dt)):
        after = brake(command, change)
        moved = after - command
        assert (np.abs(moved) <= LIMITS.acceleration * dt * (1 + 1e-9) + 1e-15).all()
        assert (np.abs(moved - change) <= jerk * dt * dt * (1 + 1e-9) + 1e-12).all()
        command, change = after, moved
        speeds.append(np.abs(command))
    assert not command.any()
    assert not change.any()


def test_braking_from_a_steady_velocity_never_reverses():
    brake = SmoothBrake(LIMITS, DT)
    command, change = np.array([1.5, 0.8, -2.0]), np.zeros(3)
    sign = np.sign(command)
    while command.any():
        after = brake(command, change)
        command, change = after, after - command
        assert (command * sign >= -1e-12).all()


def test_no_trajectory_goes_on_when_at_rest():
    spline = CommandSpline(LIMITS, DT, 2, hold=10)
    spline.begin(np.ones(3), np.zeros(3))
    spline.push(np.zeros(3))
    assert [point.time for point in spline.points()] == pytest.approx([DT, 2 * DT])
