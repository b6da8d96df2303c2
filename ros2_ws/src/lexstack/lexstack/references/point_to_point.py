"""From joint positions to others: straight, from rest to rest, as quick as limits let it.

All joints are at the same share s of their way at any time; s has constant acceleration, constant
velocity, and constant deceleration. pink, mink and placo have no such reference.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from lexstack.errors import InputError
from lexstack.types import Vector


@dataclass(frozen=True, slots=True, eq=False)
class PointToPoint:
    """A ``Trajectory`` of joint positions.

    Attributes:
        begin: when it leaves [s].
        start: from where, shape (m,), rad and m.
        goal: to where, shape (m,).
        velocity: limits, shape (m,); as much of them is used as the slowest joint allows.
        acceleration: limits, shape (m,).
    """

    begin: float
    start: Vector
    goal: Vector
    velocity: Vector
    acceleration: Vector
    _speed: float = field(init=False, repr=False)
    _rate: float = field(init=False, repr=False)
    _ramp: float = field(init=False, repr=False)
    _time: float = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Find the times; raises InputError for positions or limits that make no way."""
        ends = [
            np.array(getattr(self, name), dtype=np.float64)
            for name in ("start", "goal", "velocity", "acceleration")
        ]
        if len({each.shape for each in ends}) > 1 or ends[0].ndim != 1:
            raise InputError("start, goal, velocity, acceleration: expected vectors of one length")
        start, goal, velocity, acceleration = ends
        if not np.isfinite(np.concatenate((start, goal, [self.begin]))).all():
            raise InputError("begin, start, goal: expected finite numbers")
        if not (velocity > 0.0).all() or not (acceleration > 0.0).all():
            raise InputError("velocity, acceleration: expected limits > 0")
        way = np.abs(goal - start)
        moved = way > 0.0
        # s' and s'' at most; s goes from 0 to 1.
        rate = float((acceleration[moved] / way[moved]).min(initial=math.inf))
        speed = float((velocity[moved] / way[moved]).min(initial=math.inf))
        if moved.any():
            speed = min(speed, math.sqrt(rate))
            ramp, time = speed / rate, speed / rate + 1.0 / speed
        else:
            ramp = time = rate = speed = 0.0
        for array in ends:
            array.setflags(write=False)
        names = ("start", "goal", "velocity", "acceleration", "_speed", "_rate", "_ramp", "_time")
        for name, value in zip(names, (*ends, speed, rate, ramp, time), strict=True):
            object.__setattr__(self, name, value)

    @property
    def end(self) -> float:
        """When it arrives [s]."""
        return self.begin + self._time

    def at(self, stamp: float) -> Vector:
        """Return the positions at a time [s], shape (m,)."""
        if stamp >= self.end:
            return self.goal
        if stamp <= self.begin:
            return self.start
        gone, left = stamp - self.begin, self.end - stamp
        if gone < self._ramp:
            share = 0.5 * self._rate * gone * gone
        elif left < self._ramp:
            share = 1.0 - 0.5 * self._rate * left * left
        else:
            share = self._speed * (gone - 0.5 * self._ramp)
        return np.asarray(self.start + share * (self.goal - self.start))

    def rate(self, stamp: float) -> Vector | None:
        """Return the velocities at a time [s], shape (m,); None before and after."""
        if not self.begin < stamp < self.end:
            return None
        quick = min(self._rate * min(stamp - self.begin, self.end - stamp), self._speed)
        return np.asarray(quick * (self.goal - self.start))
