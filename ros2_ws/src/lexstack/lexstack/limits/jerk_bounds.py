"""The box that keeps position, velocity, acceleration and jerk limits, in discrete time.

Per joint and side, with d the room towards the limit, v the last velocity and w = v(k-1) - v(k-2)
its last change, both towards the limit, A = a dt the largest change and S = j dt^2 the largest
change of that:

    moves       |w' - w| <= S,  |w'| <= A,  v' = v + w',  d' = d - dt v'
    viable      0 <= d,  F(v, b) <= d / dt,  b <= u(v_max - v; S),  |w| <= A,  b = max(w - S, -A)
    the law     w' <= max {w': F(v, w') <= d / dt},  w' <= u(v_max - v; S)
    F(v, w')  = v' + D(v', w')

D(v, w), in units of dt, is how far a joint still goes that comes to rest in continuous time and
does not go back, its acceleration c = w - S/2 now: at jerk -S down to -P, there for a while, and
at jerk S up to 0.

    D = z c / S - c^3 / (6 S^2) + z (z / P + P / S) / 2 + max(c, 0)^2 / (2 S)
    z = v + c^2 / (2 S),  P^2 = min(A^2, S z),  c = max(w - S/2, -min(A, sqrt(2 S v)))

and for v < 0 that from where v = 0. One step of this motion, w' the mean of its acceleration, is
legal; it goes at least as far as the joint, dt v', where it gets slower, and the last term of D
pays for where it still gets faster. So F(v, w') <= D(v, w), the next state is viable, for ever.
The same law once more, v kept below u(d; a) by u(u(d; a) - v; S), is not: on that curve it asks
for the full deceleration at once. Braking with all there is as look-ahead is, but its joint
arrives with acceleration -A, and bounces off the limit.

Both sides leave a choice together where a joint that comes to rest for one limit can do so in
front of the others. So A is at most, with W the distance of the position limits,

    S max(1/2, sqrt(2 v_max / S))      and      S cbrt(1/8 + W / (dt S))
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lexstack.limits.stopping import approach_speed, keeps_room, largest_stoppable_change
from lexstack.types import Vector

_FAR = 1e100  # stands for infinite room: its square does not overflow
_KEPT = 1e-9  # m, rad, and relative: a limit exceeded by no more is kept


class JerkLaw:
    """The least and the largest change of velocity after which all joints can still stop in time.

    Attributes:
        usable: the acceleration that the law uses, shape (n,), at most the limit.
        table: what the compiled form takes, shape (5, 2 n): towards the lower, then towards the
            upper limits, positions over dt, speed, the largest change, the one that is used, S.
    """

    def __init__(
        self,
        position: tuple[Vector, Vector],
        velocity: Vector,
        acceleration: Vector,
        jerk: Vector,
        dt: float,
    ) -> None:
        """Prepare for limits of shape (n,) each, ``position`` lower and upper, and a period [s]."""
        lower, upper = position
        most = acceleration * dt
        # Where there is no jerk limit any number will do: the result is not used.
        step = np.where(np.isfinite(jerk), jerk, acceleration) * dt * dt
        width = np.minimum(upper - lower, _FAR) / dt
        # A joint with the acceleration A at v = 0 gains A^2 / (2 S) while the jerk takes A back to
        # 0; this is within v_max if A <= S sqrt(2 v_max / S).
        by_velocity = np.maximum(np.sqrt(2.0 * velocity / step), 0.5)
        by_position = np.cbrt(width / step + 0.125)
        used = np.minimum(most, step * np.minimum(by_velocity, by_position))
        self.usable = used / dt
        self._dt = dt
        # From here on: towards the lower, then towards the upper limit, shape (2n,), in the unit
        # of velocity. Positions are divided by dt.
        self._positions = np.clip(np.concatenate((-lower, upper)), -_FAR, _FAR) / dt
        self._speed = np.concatenate((velocity, velocity))
        self._most = np.concatenate((most, most))
        self._used = np.concatenate((used, used))
        self._step = np.concatenate((step, step))
        self.table = np.stack((self._positions, self._speed, self._most, self._used, self._step))

    def changes(self, position: Vector, velocity: Vector, change: Vector) -> tuple[Vector, Vector]:
        """Return the least and the largest change of velocity in this step, shape (n,) each.

        The least is at most the largest, from every state. Where the state is not viable, the
        acceleration limit goes before the jerk limit, that before the velocity limit, and the
        position limit comes last: the joint brakes with all it has, and then comes back.

        Args:
            position: q*, shape (n,).
            velocity: of the last step, shape (n,).
            change: of the velocity in the last step, its acceleration times dt, shape (n,).
        """
        n = position.size
        room = self._positions - np.concatenate((-position, position)) / self._dt
        speed = np.concatenate((-velocity, velocity))
        # First what acceleration, jerk and velocity allow; the position can only take from that.
        largest = self._within_velocity(room, speed, np.concatenate((-change, change)))
        # Outside too it must stop, and goes no further out than braking takes it.
        np.maximum(room, 0.0, out=room)
        # F itself is computed one joint at a time. Its upper bound is cheap, for all joints at
        # once, and clears those that are far from their limits.
        near = np.flatnonzero(self._most_distance(speed, largest) > room)
        if near.size:
            self._keep_room(near, room, speed, largest)
        least, largest = -largest[:n], largest[n:]
        crossed = least > largest
        if crossed.any():  # by rounding, or where the state is not viable
            middle = 0.5 * (least + largest)
            return np.where(crossed, middle, least), np.where(crossed, middle, largest)
        return least, largest

    def viable(self, position: Vector, velocity: Vector, change: Vector) -> NDArray[np.bool_]:
        """Return which joints can keep all limits from this state on, shape (n,).

        Args:
            position: q*, shape (n,).
            velocity: of the last step, shape (n,).
            change: of the velocity in the last step, shape (n,).
        """
        n = position.size
        speed, last = np.concatenate((-velocity, velocity)), np.concatenate((-change, change))
        keeps = self.stops(position, velocity, change)
        brake = np.maximum(last - self._step, -self._used)
        keeps &= brake <= approach_speed(self._speed - speed, self._step, 1.0) + _KEPT * self._step
        keeps &= np.abs(last) <= self._used * (1.0 + _KEPT)
        return keeps[:n] & keeps[n:]

    def stops(self, position: Vector, velocity: Vector, change: Vector) -> NDArray[np.bool_]:
        """Return which joints can stop in front of the lower, then of the upper limits, (2n,).

        The arguments are those of ``viable``.
        """
        room = self._positions - np.concatenate((-position, position)) / self._dt
        speed, last = np.concatenate((-velocity, velocity)), np.concatenate((-change, change))
        brake = np.maximum(last - self._step, -self._used)
        holds: NDArray[np.bool_] = room >= -_KEPT / self._dt
        near = np.flatnonzero(holds & ~(self._most_distance(speed, brake) <= room))
        columns = (x[near] / self._step[near] for x in (room, speed, self._used, brake))
        joints = zip(*(column.tolist() for column in columns), strict=True)
        holds[near] = [keeps_room(*joint) for joint in joints]
        return holds

    def _within_velocity(self, room: Vector, speed: Vector, change: Vector) -> Vector:
        """Return the largest changes that acceleration, jerk and velocity limits allow, (2n,)."""
        # At most A. A joint that still has more, from a state that this law did not choose, comes
        # down with the full jerk. The acceleration limit is clipped last, so it goes before jerk.
        largest: Vector = np.maximum(self._used, change - self._step)
        np.minimum(largest, change + self._step, out=largest)
        np.maximum(largest, -self._most, out=largest)
        np.minimum(largest, self._most, out=largest)
        # The least change towards one limit is the largest one towards the other: the hardest
        # braking. It is taken before the velocity limit, and what follows never goes below it.
        least: Vector = -other_side(largest)
        ceiling = self._speed
        if not room.min() >= 0.0:  # outside: back, at least at the speed that stops at the limit
            back = np.maximum(approach_speed(room, self._used, 1.0), -ceiling)
            ceiling = np.where(room >= 0.0, ceiling, back)  # a NaN stays one
        # w' <= u(v_max - v; S): the jerk can still bring this acceleration to 0 in front of the
        # velocity limit, as a can still bring the speed u(d; a) to 0 in front of a position limit.
        np.minimum(largest, approach_speed(ceiling - speed, self._step, 1.0), out=largest)
        np.maximum(largest, least, out=largest)
        return largest

    def _most_distance(self, speed: Vector, change: Vector) -> Vector:
        """Return an upper bound of F(v, w'), shape (2n,): cheap, and enough far from the limits.

        That is D with c = max(w - S/2, 0) and max(v, 0), without -c^3 / (6 S^2), and with P = A
        throughout: z / P + P / S is least at P = sqrt(S z), which D has where z < A^2 / S.
        """
        distance: Vector = speed + change
        c = change - 0.5 * self._step
        np.maximum(c, 0.0, out=c)
        gained = c * c
        gained /= 2.0 * self._step
        z = np.maximum(distance, 0.0)
        z += gained
        distance += gained
        c += 0.5 * self._used
        c /= self._step
        c += z / (2.0 * self._used)
        c *= z
        distance += c
        return distance

    def _keep_room(
        self, near: NDArray[np.intp], room: Vector, speed: Vector, largest: Vector
    ) -> None:
        """Reduce ``largest`` (2n,) at the indices ``near`` so that the joints keep their room."""
        step = self._step[near]
        least = -other_side(largest)
        columns = (x[near] / step for x in (room, speed, self._used, least, largest))
        joints = zip(*(column.tolist() for column in columns), strict=True)
        largest[near] = np.array([largest_stoppable_change(*joint) for joint in joints]) * step


def other_side(both: Vector) -> Vector:
    """Return a vector (2n,) with its halves swapped."""
    n = both.size // 2
    return np.concatenate((both[n:], both[:n]))
