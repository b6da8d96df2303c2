"""The measured joints of one arm, from messages in any order, whole or not, late or twice."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lexstack.errors import InputError
from lexstack.options import shown
from lexstack.types import Vector
from lexstack_plant.hardware.sender_clock import SenderClock, set_back

_SMOOTHING = 0.02  # s, of velocities that follow from positions: of encoders they would be steps
_PLAUSIBLE = 1.5  # times the velocity limit: what two samples may differ by
_HUGE = 1e6  # rad, m, rad/s and m/s: no joint gets there
_SHORTEST = 1e-5  # s between two samples


@dataclass(frozen=True, slots=True)
class JointSample:
    """One message of joints, as it came.

    Attributes:
        names: of its joints.
        positions: rad or m, as many as names.
        velocities: rad/s or m/s, as many as names; or none.
        stamp: s by the sender's clock; 0: none.
        received: s by the local clock.
    """

    names: Sequence[str]
    positions: Sequence[float]
    velocities: Sequence[float]
    stamp: float
    received: float


@dataclass(slots=True)
class IntakeCounters:
    """Messages so far, by what became of them."""

    taken: int = 0
    repeated: int = 0  # with the stamp of the one before
    late: int = 0  # with an older stamp
    refused: int = 0  # no sample: lengths, names, NaN


class JointIntake:
    """Positions and velocities of an arm's joints, in the order of chi.

    Attributes:
        q: rad and m, shape (n,); NaN until it is known.
        v: rad/s and m/s, shape (n,).
        times: when each joint was measured, by the local clock [s], shape (n,); -inf: never.
        fault: why the last samples, or their times, cannot be true; empty: they can. It stays
            until ``forget``.
        counters: of messages.
    """

    def __init__(
        self,
        names: Sequence[str],
        velocity: Vector,
        tolerance: float,
        *,
        stamps: bool = True,
        shared: bool = False,
    ) -> None:
        """Make the intake of joints.

        Args:
            names: in messages, in the order of chi.
            velocity: limits, shape (n,), rad/s and m/s.
            tolerance: by which a position may jump beyond what the limits allow [rad, m].
            stamps: whether stamps say when the joints were measured.
            shared: whether stamps are of the local clock.
        """
        n = len(names)
        self.q: Vector = np.full(n, np.nan)
        self.v: Vector = np.zeros(n)
        self.times: Vector = np.full(n, -np.inf)
        self.fault = ""
        self.counters = IntakeCounters()
        self._names = tuple(names)
        self._place = {name: i for i, name in enumerate(names)}
        self._velocity = velocity
        self._tolerance = tolerance
        self._clock = SenderClock(shared=shared) if stamps else None
        self._stamps: Vector = np.full(n, -np.inf)

    def hear(self, sample: JointSample) -> None:
        """Take a message, or what is new in it; one without a joint of ours is not looked at.

        Raises:
            InputError: it is no sample; nothing of it is taken.
        """
        places, found = self._ours(sample)
        if not places.size:
            return
        q = self._values(sample.positions, sample.names, found, "position")
        given = len(sample.velocities) == len(sample.names)
        v = self._values(sample.velocities, sample.names, found, "velocity") if given else None
        time = self._time(sample, places)
        if time is None:
            return
        self.counters.taken += 1
        elapsed = np.maximum(time - self.times[places], _SHORTEST)
        known = np.isfinite(self.q[places])
        moved = np.where(known, q - self.q[places], 0.0)
        self._check(places, moved, elapsed)
        if v is None:
            # A joint that is seen for the first time, an infinite time after none, is at rest.
            share = np.where(known, 1.0 / (1.0 + _SMOOTHING / elapsed), 0.0)
            v = self.v[places] + share * (moved / elapsed - self.v[places])
        self.q[places], self.v[places], self.times[places] = q, v, time

    def at(self, now: float, most: float) -> Vector:
        """Return where the joints are now, shape (n,): they went on for ``most`` [s] at most."""
        return self.q + self.v * np.clip(now - self.times, 0.0, most)

    def age(self, now: float) -> float:
        """Return how old the oldest joint is [s]; inf: one is not known."""
        return float(now - self.times.min(initial=np.inf)) if self._names else 0.0

    def missing(self) -> list[str]:
        """Return the joints that no message has had so far."""
        return [name for name, time in zip(self._names, self.times, strict=True) if time == -np.inf]

    def forget(self) -> None:
        """Take the next samples as the truth, whatever was before."""
        self.fault = ""

    def _ours(self, sample: JointSample) -> tuple[np.ndarray, list[int]]:
        """Return the places of a message's joints in chi, and in the message."""
        found = [i for i, name in enumerate(sample.names) if name in self._place]
        places = np.array([self._place[sample.names[i]] for i in found], dtype=np.intp)
        if len(sample.positions) != len(sample.names):
            if found:
                self._refuse(f"{len(sample.names)} names, but {len(sample.positions)} positions")
            return places[:0], []
        if len(set(places.tolist())) != len(found):
            self._refuse(f"a joint stands twice in {shown(list(sample.names))}")
        return places, found

    def _values(
        self, values: Sequence[float], names: Sequence[str], found: list[int], what: str
    ) -> Vector:
        """Return the values of our joints; raises InputError where one is none."""
        result = np.asarray(values, dtype=np.float64)[found]
        wrong = ~(np.abs(result) <= _HUGE)  # of NaN too
        if wrong.any():
            i = int(np.argmax(wrong))
            self._refuse(f"{what} of {shown(names[found[i]])} is {result[i]}")
        return result

    def _refuse(self, what: str) -> None:
        """Count a message that is no sample, and raise InputError."""
        self.counters.refused += 1
        raise InputError(f"joint states: {what}")

    def _time(self, sample: JointSample, places: np.ndarray) -> float | None:
        """Return when a sample was measured, or None if it is not newer than what is known.

        Sets ``fault`` where the sender's clock was set back.
        """
        if self._clock is None or not sample.stamp:
            return sample.received
        newest = float(self._stamps[places].max())
        restarted = set_back(sample.stamp, newest)
        if restarted:
            self.fault = restarted
            self._stamps[:] = newest = -np.inf
            self._clock.forget()
        if sample.stamp <= newest:
            repeated = sample.stamp == newest
            self.counters.repeated += repeated
            self.counters.late += not repeated
            return None
        self._stamps[places] = sample.stamp
        return self._clock.local(sample.stamp, sample.received)

    def _check(self, places: np.ndarray, moved: Vector, elapsed: Vector) -> None:
        """Set ``fault`` if a joint moved by more than its limits allow."""
        most = _PLAUSIBLE * self._velocity[places] * elapsed + self._tolerance
        wrong = np.abs(moved) > most
        if wrong.any():
            i = int(np.argmax(wrong))
            name, far, time = self._names[places[i]], moved[i], elapsed[i]
            self.fault = f"{name} jumped by {far:.3g} in {1e3 * time:.1f} ms"
