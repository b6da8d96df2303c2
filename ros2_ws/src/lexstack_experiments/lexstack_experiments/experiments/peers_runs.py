"""One reach of one law in the ideal plant, q' = v, and what there is to say of it."""

from __future__ import annotations

from dataclasses import dataclass
from time import thread_time
from typing import Protocol

import numpy as np

from lexstack.robots import Pose, Team
from lexstack.tasks import pose_error
from lexstack.types import Vector
from lexstack_experiments.experiments.peers_cases import DT, Reach

SECONDS = 10.0  # simulated, for a reach
NEAR = 1e-3  # m and rad, of the norms of both errors
_STAYS = 0.25  # s, so long it must be near
_STILL, _RESTS = 1e-3, 0.5  # of the velocity limits; s: after so long it stays where it is
_ROUNDING = 1e-6  # of a limit


class Law(Protocol):
    """Joint velocities for a state.

    Attributes:
        team: the arm with the limits that the law is to keep.
    """

    team: Team

    def begin(self, start: Vector, goal: Pose) -> None:
        """Get ready for another reach, from rest."""
        ...

    def velocity(self, q: Vector, last: Vector) -> Vector:
        """Return the velocities of the coming period, given those of the last one; (n,) each."""
        ...


@dataclass(frozen=True, slots=True)
class Run:
    """What one reach came to.

    Attributes:
        time: from when on the tool stays near its goal [s]; None: it does not.
        ticks: how many there were.
        over: ticks in which some joint is beyond its limit of position, velocity, acceleration.
        sizes: how far at most: rad; times the limit; times the limit.
        preparing: CPU time before the first tick [s].
        steps: CPU time of each tick, shape (ticks,), s.
    """

    time: float | None
    ticks: int
    over: tuple[int, int, int]
    sizes: tuple[float, float, float]
    preparing: float
    steps: Vector


def run(law: Law, reach: Reach, own: Team) -> Run:
    """Return what a law makes of a reach; it ends at the goal, at rest elsewhere, or in time.

    Args:
        law: whose turn it is.
        reach: from where to where.
        own: the arm with all its limits, whether the law knows them or not.
    """
    begun = thread_time()
    law.begin(reach.start, reach.goal)
    preparing = thread_time() - begun
    q, v = reach.start.copy(), np.zeros_like(reach.start)
    steps: list[float] = []
    over, sizes = np.zeros(3, dtype=int), np.array([0.0, 0.0, 0.0])
    near = still = 0
    for _ in range(round(SECONDS / DT)):
        error = pose_error(own.tools(q)[0], reach.goal)
        there = max(np.linalg.norm(error[:3]), np.linalg.norm(error[3:])) < NEAR
        near = near + 1 if there else 0
        if near > _STAYS / DT or still > _RESTS / DT:
            break
        begun = thread_time()
        new = law.velocity(q, v)
        steps.append(thread_time() - begun)
        q = q + DT * new
        beyond = _beyond(own, q, new, v)
        over += beyond > (_ROUNDING, 1.0 + _ROUNDING, 1.0 + _ROUNDING)
        sizes = np.maximum(sizes, beyond)
        v = new
        moving = float((np.abs(v) / own.limits.velocity).max()) > _STILL
        still = 0 if moving or there else still + 1
    time = DT * (len(steps) - near + 1) if near else None
    counts, largest = tuple(over.tolist()), tuple(sizes.tolist())
    return Run(time, len(steps), counts, largest, preparing, np.array(steps))


def _beyond(team: Team, q: Vector, new: Vector, old: Vector) -> Vector:
    """Return how far positions are outside [rad], and speeds and accelerations per limit, (3,)."""
    limits = team.limits
    outside = np.maximum(limits.position_lower - q, q - limits.position_upper)
    speed = np.abs(new) / limits.velocity
    acceleration = np.abs(new - old) / (DT * limits.acceleration)
    return np.array([max(outside.max(), 0.0), speed.max(), acceleration.max()])
