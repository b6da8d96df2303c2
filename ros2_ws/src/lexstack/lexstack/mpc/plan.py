"""What the HTMPC returns: the horizon as a value, to be sampled, shifted and followed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lexstack.mpc.limited_qp import ActiveSet
from lexstack.mpc.status import LevelStatus
from lexstack.mpc.unicycle_horizon import driven
from lexstack.types import Matrix, Vector


@dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """Inputs over the horizon, and the motion that they make from the measured state.

    Attributes:
        stamp: time of the state that it starts from [s].
        step: length of a stage [s].
        q: states 0 to N, shape (N + 1, n_q), m and rad.
        v: likewise, shape (N + 1, n), m/s and rad/s; a holonomic base in the world frame, a
            differential one forwards and about its axis.
        u: constant over each stage, shape (N, n), m/s^2 and rad/s^2.
        levels: how each level ended, highest first.
        errors: of each level's task at the states 1 to N, shapes (N, s).
        active_sets: what held at each level: a guess for the next solve.
        solve_time: wall time [s].
    """

    stamp: float
    step: float
    q: Matrix
    v: Matrix
    u: Matrix
    levels: tuple[LevelStatus, ...]
    errors: tuple[Matrix, ...]
    active_sets: tuple[ActiveSet, ...]
    solve_time: float

    @property
    def solved(self) -> bool:
        """Whether no level failed; a blocked level is not a failure, but no success either."""
        return all(level.outcome.sound for level in self.levels)

    @property
    def end(self) -> float:
        """The time up to which it says anything [s]."""
        return self.stamp + self.step * len(self.u)

    def sample(self, stamp: float) -> tuple[Vector, Vector, Vector]:
        """Return q (n_q,), v and u (n,) at a time [s]; outside the plan its nearest end."""
        elapsed = min(max(stamp - self.stamp, 0.0), self.step * len(self.u))
        stage = min(int(elapsed / self.step + 1e-9), len(self.u) - 1)
        rest = elapsed - stage * self.step
        u = self.u[stage]
        v = self.v[stage]
        if self.q.shape[1] != self.v.shape[1]:
            return driven(self.q[stage], v, u, rest), v + rest * u, u
        return self.q[stage] + rest * v + 0.5 * rest * rest * u, v + rest * u, u

    def configurations(self, times: Vector) -> Matrix:
        """Return q at times of shape (k,) [s], shape (k, n_q): where another robot must not be."""
        return np.array([self.sample(float(time))[0] for time in times])

    def input_before(self, stamp: float) -> Vector:
        """Return u_{-1} at a time [s]: the input that was in force just before, shape (n,)."""
        elapsed = (stamp - self.stamp) / self.step
        stage = int(np.ceil(elapsed - 1e-9)) - 1
        return np.asarray(self.u[min(max(stage, 0), len(self.u) - 1)])

    def shifted(self, stamp: float) -> Matrix:
        """Return the inputs as a first guess at a later time [s], shape (N, n).

        Between two stages the mean input, so that the velocities at the states stay those of the
        plan; after its end zero: the velocity is kept.
        """
        count = len(self.u)
        elapsed = max((stamp - self.stamp) / self.step, 0.0)
        whole = int(elapsed + 1e-9)
        share = max(elapsed - whole, 0.0)
        if share < 1e-9:
            share = 0.0
        padded = np.zeros((count + 1, self.u.shape[1]))
        rest = self.u[whole:]
        padded[: len(rest)] = rest
        return np.asarray((1.0 - share) * padded[:-1] + share * padded[1:])
