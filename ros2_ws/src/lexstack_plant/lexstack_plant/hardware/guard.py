"""What must be true of the measured state, while robots move and before they may."""

from __future__ import annotations

import numpy as np

from lexstack.robots import Team
from lexstack.types import Vector
from lexstack_config.plant_file import SafetyConfig

_SLOW = 0.5  # times the velocity limit: faster robots are not taken over


class Guard:
    """Looks at the measured state of all robots, and says in one line what is wrong with it."""

    def __init__(self, team: Team, safety: SafetyConfig) -> None:
        """Read the limits and the tolerances."""
        self._team = team
        self._safety = safety
        self._lower = team.limits.position_lower - safety.position
        self._upper = team.limits.position_upper + safety.position
        self._speed = team.limits.velocity

    def beyond(self, q: Vector, v: Vector) -> str:
        """Return which joint is beyond a limit by more than the tolerance, or ''.

        Args:
            q: a position for each entry of chi, shape (n,): ``Team.joint_positions``.
            v: velocities, shape (n,).
        """
        low, high = q < self._lower, q > self._upper
        if low.any() or high.any():
            i = int(np.argmax(low | high))
            limit = self._lower[i] if low[i] else self._upper[i]
            return f"{self._joint(i)} is at {q[i]:.4g}, beyond its limit with tolerance {limit:.4g}"
        return self._too_fast(v, self._safety.speed)

    def lost(self, away: Vector) -> str:
        """Return which joint does not go where it is led, or ''; ``away`` (n,): by how far."""
        if not (np.abs(away) > self._safety.following).any():
            return ""
        i = int(np.argmax(np.abs(away)))
        return (
            f"{self._joint(i)} does not follow: it is {abs(away[i]):.3g} from where it is led "
            f"(tolerance {self._safety.following:g})"
        )

    def unready(self, q: Vector, v: Vector) -> str:
        """Return why robots cannot be taken over as they are, or ''; as ``beyond``."""
        return self.beyond(q, v) or self._too_fast(v, _SLOW)

    def _too_fast(self, v: Vector, most: float) -> str:
        """Return which joint is faster than ``most`` times its limit, or ''."""
        fast = np.abs(v) > most * self._speed
        if not fast.any():
            return ""
        i = int(np.argmax(fast))
        return (
            f"{self._joint(i)} moves at {v[i]:.3g}, at most {most * self._speed[i]:.3g} is accepted"
        )

    def _joint(self, i: int) -> str:
        """Return the name of a joint of chi."""
        return self._team.joint_names[i]
