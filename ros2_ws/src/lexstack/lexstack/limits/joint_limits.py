"""The limits of all joints, and boxes on chi, as values."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lexstack.errors import ModelError
from lexstack.types import Matrix, Vector

# Stands for an infinite position limit: far enough that the velocity limit decides, near enough
# that 2 a d does not overflow.
_FAR = 1e100
LIMITS = ("position_lower", "position_upper", "velocity", "acceleration", "jerk")
"""The limits of a joint, by their names in ``JointLimits``."""


@dataclass(frozen=True, slots=True)
class Bounds:
    """A box ``lower <= chi <= upper``; +-inf is legal, ``lower <= upper`` always holds.

    Attributes:
        lower: shape (n,), m/s and rad/s.
        upper: shape (n,), m/s and rad/s.
    """

    lower: Vector
    upper: Vector

    @classmethod
    def of(cls, box: Matrix) -> Bounds:
        """Return the bounds in the rows of an array (2, n), which is read-only from then on."""
        box.setflags(write=False)
        lower, upper = box
        return cls(lower, upper)

    @property
    def empty(self) -> int:
        """Number of joints whose interval is empty (0 for every box of ``viable_bounds``)."""
        return int(np.count_nonzero(~(self.lower <= self.upper)))


@dataclass(frozen=True, slots=True, eq=False)
class JointLimits:
    """What the joints of all robots can do; read-only copies, of shape (n,) unless said.

    Raises ModelError if the lengths differ, or a value is not what its line below says.

    Attributes:
        position_lower: m and rad; -inf where there is none.
        position_upper: m and rad, at least ``position_lower``; inf where there is none.
        velocity: m/s and rad/s, finite and positive.
        acceleration: m/s^2 and rad/s^2, finite and positive.
        jerk: m/s^3 and rad/s^3, positive; inf where there is none.
        positions: both position limits, lower first, finite, shape (2n,).
        speeds: ``velocity`` for either of them, shape (2n,).
        rates: ``acceleration`` for either of them, shape (2n,).
        table: the two finite position limits, velocity and acceleration, shape (4, n).
    """

    position_lower: Vector
    position_upper: Vector
    velocity: Vector
    acceleration: Vector
    jerk: Vector
    # Below: the lower, then the upper side in one vector, so that one pass of plain vector
    # operations makes both sides of a box; broadcasting would double the time of each.
    positions: Vector = field(init=False, repr=False)
    speeds: Vector = field(init=False, repr=False)
    rates: Vector = field(init=False, repr=False)
    table: Matrix = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Copy, check and freeze the arrays."""
        for name in LIMITS:
            value = np.array(getattr(self, name), dtype=np.float64)
            value.setflags(write=False)
            object.__setattr__(self, name, value)
            if value.ndim != 1 or value.size != self.position_lower.size:
                expected = f"({self.position_lower.size},)"
                raise ModelError(f"joint limits: {name}: shape {value.shape}, expected {expected}")
        self._require(
            self.position_lower <= self.position_upper, "position_lower", "at most position_upper"
        )
        for name in ("velocity", "acceleration"):
            value = getattr(self, name)
            self._require(np.isfinite(value) & (value > 0.0), name, "finite and positive")
        self._require(self.jerk > 0.0, "jerk", "positive")
        positions = np.concatenate((self.position_lower, self.position_upper))
        object.__setattr__(self, "positions", np.clip(positions, -_FAR, _FAR))
        object.__setattr__(self, "speeds", np.concatenate((self.velocity,) * 2))
        object.__setattr__(self, "rates", np.concatenate((self.acceleration,) * 2))
        rows = (*self.positions.reshape(2, -1), self.velocity, self.acceleration)
        object.__setattr__(self, "table", np.stack(rows))

    def _require(self, holds: NDArray[np.bool_], name: str, what: str) -> None:
        """Raise ModelError for the first joint that breaks a rule."""
        if not holds.all():
            joint = int(np.argmin(holds))
            value = getattr(self, name)[joint]
            raise ModelError(f"joint limits: {name}[{joint}] = {value}, must be {what}")

    @classmethod
    def joined(cls, parts: Iterable[JointLimits]) -> JointLimits:
        """Return the limits of several robots, one after another."""
        values = [[getattr(part, name) for name in LIMITS] for part in parts]
        return cls(*map(np.concatenate, zip(*values, strict=True)))

    @property
    def n(self) -> int:
        """Number of joints."""
        return int(self.position_lower.size)

    def replaced(self, pieces: Iterable[tuple[Any, JointLimits]]) -> JointLimits:
        """Return these limits, with other ones on some joints: an index of (n,), and the limits."""
        values = {name: getattr(self, name).copy() for name in LIMITS}
        for joints, limits in pieces:
            for name in LIMITS:
                values[name][joints] = getattr(limits, name)[joints]
        return JointLimits(**values)
