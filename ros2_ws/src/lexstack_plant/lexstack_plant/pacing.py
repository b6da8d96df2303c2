"""When to stop waiting for a command: the only difference between lockstep and realtime. No ROS.

And how often to tell those who only look on.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from math import floor

from lexstack_config.scenario import Mode

LATE = 0.5
"""A tick counts as late when it begins so many periods after its wall-clock time."""

GIVE_UP = 3.0
"""So many periods behind, the schedule leaves ticks out instead of running after the clock."""

_SAME = 1e-6  # of a period: no difference of times


class Pacer:
    """Deadlines of commands, on a monotonic clock [s] that the caller reads.

    Lockstep: the command of a tick may take ``command_wall``. Once it did not come, the ticks go
    on one period apart, until a command, for whichever tick, shows that the controller is back.

    Realtime: tick k begins at t_0 + k dt, and its command may take until the next one begins. A
    process that fell behind catches up, but leaves every command at least half a period.

    Attributes:
        lockstep: whether a tick ends as soon as its command is there.
        deadline: until when to wait for the command of the present tick.
        late_ticks: ticks that began late (realtime).
        restarts: how often the schedule left ticks out (realtime).
    """

    def __init__(self, mode: Mode, period: float, command_wall: float) -> None:
        """Make a pacer for ticks of ``period`` [s]; call ``start`` before the first tick."""
        self.lockstep = mode == "lockstep"
        self.deadline = 0.0
        self.late_ticks = 0
        self.restarts = 0
        self._period = period
        self._patience = command_wall
        self._alive = True
        self._begun = 0.0
        self._scheduled = 0.0

    @property
    def due(self) -> float:
        """When the present tick ends, without what it is late by [s] (realtime)."""
        return self._scheduled + self._period

    def start(self, now: float) -> None:
        """Let the next tick begin at ``now``: after a pause, or at the start."""
        self._alive = True
        self._scheduled = now - self._period

    def begin(self, now: float) -> None:
        """Set the deadline of the tick whose state goes out now."""
        self._begun = now
        if self.lockstep:
            self.deadline = now + (self._patience if self._alive else self._period)
            return
        self._scheduled += self._period
        behind = (now - self._scheduled) / self._period
        self.late_ticks += behind > LATE
        if behind > GIVE_UP:
            self.restarts += 1
            # By whole periods: a trajectory says what robots do between two ticks too.
            self._scheduled += floor(behind + _SAME) * self._period
        self.deadline = max(self._scheduled + self._period, now + 0.5 * self._period)

    def answered(self) -> None:
        """Take note of a command, also of one that came too late for its tick."""
        if self.lockstep and not self._alive:
            self._alive = True
            self.deadline = self._begun + self._patience

    def missed(self) -> None:
        """Take note that the deadline passed without a command."""
        self._alive = False


class Sparse:
    """Says when something is due that is to come at most at a rate of wall time.

    What happens at ticks comes a little early or late: it is due half a tick before its time, and
    the times stay on their grid, so that the rate is kept in the mean.
    """

    def __init__(
        self, rate: float, tick: float, clock: Callable[[], float] = time.monotonic
    ) -> None:
        """``rate`` [Hz] of wall time; ``tick``: the period of ticks [s]; ``clock`` is monotonic."""
        self._period = 1.0 / rate
        self._early = min(0.5 * tick, 0.5 * self._period)
        self._clock = clock
        self._due = 0.0

    def __call__(self) -> bool:
        """Return whether it is due, and if so count it as done."""
        now = self._clock()
        if now < self._due - self._early:
            return False
        begins_anew = now - self._due > self._period
        self._due = (now if begins_anew else self._due) + self._period
        return True
