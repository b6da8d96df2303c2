"""The controller's messages of a tick: its chi as bytes, and its transitions when they change."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from lexstack.transition import TransitionState
from lexstack_interfaces.msg import Chi, TransitionStatus
from lexstack_ros.messages.cdr import Buffer
from lexstack_ros.messages.conversions import WORLD, chi_of_command, to_time, transition_status

if TYPE_CHECKING:
    from lexstack.control import Command

_NUMBERS = ("alpha", "duration", "gap", "id")
_PERIOD = 0.1  # s of wall time between two messages of transitions that go on as they did


class CommandBytes:
    """Makes the chi of a command: numbers are written where they stand, the rest stays."""

    def __init__(self, robots: Sequence[str], sender: str) -> None:
        """``sender`` names this process."""
        self._robots = list(robots)
        self._sender = sender
        self._rest: object = None  # what decides where the numbers stand
        self._buffer: Buffer

    def __call__(self, command: Command) -> bytes:
        """Return the message of a command."""
        reason = command.fallback or command.near_singularity
        states = tuple(map(_words, command.transitions))
        rest = command.stack, reason, command.chi.size, command.slacks.size, states
        if rest == self._rest:
            self._fill(command)
        else:
            message = Chi(robots=self._robots, sender=self._sender)
            message.header.frame_id = WORLD
            self._buffer, self._rest = Buffer(chi_of_command(command, message)), rest
        return self._buffer.data

    def _fill(self, command: Command) -> None:
        """Write the numbers of a command whose strings and lengths are those of the last one."""
        put, put_all = self._buffer.put, self._buffer.put_all
        stamp = to_time(command.stamp)
        put("header.stamp.sec", stamp.sec)
        put("header.stamp.nanosec", stamp.nanosec)
        put("tick", command.tick)
        put("transition_id", max(state.id for state in command.transitions))
        put("references", command.revision)
        put_all("chi", command.chi)
        put_all("lower", command.bounds.lower)
        put_all("upper", command.bounds.upper)
        put_all("slacks", command.slacks)
        put("status", Chi.FALLBACK if command.fallback else Chi.SOLVED)
        put("empty_bounds", command.bounds.empty)
        put("solve_time", command.solve_time)
        for place, state in enumerate(command.transitions):
            path = f"transitions.{place}."
            put(f"{path}header.stamp.sec", stamp.sec)
            put(f"{path}header.stamp.nanosec", stamp.nanosec)
            put(f"{path}tick", command.tick)
            for name in _NUMBERS:
                put(path + name, getattr(state, name))
            put(f"{path}phase", state.phase.value)


def _words(state: TransitionState) -> tuple[object, ...]:
    """Return the strings of a transition, and how many of them."""
    source, robots = state.source, state.robots
    return state.from_stack, state.to_stack, source, state.method, state.reason, robots


class TransitionNews:
    """Which transitions are to be published by themselves: for those who need not know every tick.

    All of a tick, when more has changed than how far they are, and ten times a second.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        """Nothing was published yet; ``clock`` is monotonic [s]."""
        self._clock = clock
        self._last: object = None
        self._due = 0.0

    def of(self, command: Command) -> list[TransitionStatus]:
        """Return what is to be published of a command."""
        states = tuple((s.id, s.phase, s.duration, _words(s)) for s in command.transitions)
        now = self._clock()
        if states == self._last and now < self._due:
            return []
        self._last, self._due = states, now + _PERIOD
        return [transition_status(command, state) for state in command.transitions]
