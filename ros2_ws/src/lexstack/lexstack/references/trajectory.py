"""What every reference is: a value and its velocity at any time, and when it comes to rest."""

from __future__ import annotations

from typing import Protocol, TypeVar

from lexstack.types import Vector

T_co = TypeVar("T_co", covariant=True)


class Trajectory(Protocol[T_co]):
    """A reference over simulated time; a value, so that all who have it agree in every bit.

    The value is a ``Pose`` for frames, an array x, y [m], yaw [rad] for bases, and an array of
    joint positions, shape (n_arm,), rad, for postures. Any object with these three members may be
    given as a target: set-points, splines, streams of twists, or one of the user's own.
    """

    @property
    def end(self) -> float:
        """The time from which it rests [s]; inf where it never does."""
        ...

    def at(self, stamp: float) -> T_co:
        """Return the reference at a time [s], defined for every time.

        From ``end`` on it returns the same object, not an equal one: what rests is not worked out
        again.
        """
        ...

    def rate(self, stamp: float) -> Vector | None:
        """Return the velocity that tasks add to their targets at a time [s]; None: they add none.

        Of a pose the twist, shape (6,): velocity of its origin [m/s], then angular velocity
        [rad/s], both in the world frame. Of a base its derivative, shape (3,), m/s and rad/s; of a
        posture its derivative, shape (n_arm,), rad/s.
        """
        ...
