"""Closed loops of paper H with an ideal double-integrator plant: tracking, and task sequences."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from lexstack.mpc import (
    CollisionScene,
    Htmpc,
    Kind,
    LevelStatus,
    Objective,
    Plan,
    RobotPose,
    Sequence,
    Start,
    Trajectory,
)
from lexstack.types import Matrix, Vector
from lexstack_experiments.baselines.htidkc import Htidkc

Around = Callable[[Vector], CollisionScene]
"""What is in the way at the times of the states 1 to N [s]."""


@dataclass(frozen=True, slots=True)
class Track:
    """A task that is followed over time."""

    kind: Kind
    trajectory: Trajectory


@dataclass(frozen=True, slots=True, eq=False)
class Record:
    """What happened in a closed loop, state by state.

    Attributes:
        times: shape (m,), s.
        q: shape (m, n).
        v: shape (m, n).
        solve_times: of the command that led away from each state but the last, (m - 1,), s.
        levels: status of the levels of each solve; empty for a controller without.
        failures: solves that failed.
    """

    times: Vector
    q: Matrix
    v: Matrix
    solve_times: Vector
    levels: tuple[tuple[LevelStatus, ...], ...]
    failures: int


def objectives_of(
    tracks: tuple[Track, ...], times: Vector, preview: bool = True
) -> tuple[Objective, ...]:
    """Return the levels for the states 1 to N.

    Args:
        tracks: highest first.
        times: of the states 0 to N [s].
        preview: False makes HTMPC_WPT: the horizon sees only where the reference is now.
    """
    when = times[1:] if preview else np.full(len(times) - 1, times[0])
    return tuple(
        Objective(f"{i}/{track.kind}", track.kind, track.trajectory.at(when))
        for i, track in enumerate(tracks)
    )


def follow_htmpc(
    optimiser: Htmpc,
    q: Vector,
    tracks: tuple[Track, ...],
    seconds: float,
    *,
    preview: bool = True,
    around: Around | None = None,
    watch: Callable[[Plan], None] = lambda _plan: None,
) -> Record:
    """Follow tracks from rest at q, one solve per stage; ``watch`` sees every plan."""
    step = optimiser.config.step
    book = _Book(q)
    v, plan = np.zeros_like(q), None
    for k in range(round(seconds / step)):
        now = k * step
        times = now + optimiser.horizon.times
        objectives = objectives_of(tracks, times, preview)
        surroundings = None if around is None else around(times[1:])
        plan = optimiser.solve(Start(now, q, v), objectives, plan, surroundings)
        watch(plan)
        q, v = plan.q[1], plan.v[1]
        book.add(now + step, q, v, plan.solve_time, plan.solved, plan.levels)
    return book.record()


def follow_htidkc(
    controller: Htidkc, q: Vector, tracks: tuple[Track, ...], seconds: float
) -> Record:
    """Follow tracks from rest at q; a failed solve brakes as the core does, and is counted."""
    step = controller.period
    book = _Book(q)
    v = np.zeros_like(q)
    for k in range(round(seconds / step)):
        now = np.array([k * step])
        references = tuple((track.kind, track.trajectory.at(now)[0]) for track in tracks)
        solution = controller.solve(q, v, references)
        v = solution.chi
        q = q + step * v
        book.add((k + 1) * step, q, v, solution.solve_time, solution.solved, ())
    return book.record()


def carry_out(
    optimiser: Htmpc,
    q: Vector,
    sequence: Sequence,
    longest: float,
    *,
    around: Around | None = None,
    event: Callable[[Sequence, RobotPose], Sequence] = lambda sequence, _present: sequence,
) -> tuple[Record, tuple[tuple[float, str], ...]]:
    """Do a sequence of tasks from rest at q; returns the record, and when each task was done.

    Args:
        optimiser: of the robot.
        q: shape (n,).
        sequence: at its start.
        longest: after which it is given up [s].
        around: what is in the way.
        event: called at every state before it counts: releases, moves targets, inserts, cancels.
    """
    step = optimiser.config.step
    book = _Book(q)
    v, plan = np.zeros_like(q), None
    done: list[tuple[float, str]] = []
    for k in range(round(longest / step)):
        now = k * step
        present = RobotPose.of(optimiser.robot, now, q)
        before = event(sequence, present)
        sequence = before.advanced(present)
        if sequence.first != before.first:
            done.append((now, before.window[0].name))
        if sequence.done:
            break
        times = now + optimiser.horizon.times[1:]
        surroundings = None if around is None else around(times)
        plan = optimiser.solve(Start(now, q, v), sequence.objectives(times), plan, surroundings)
        q, v = plan.q[1], plan.v[1]
        book.add(now + step, q, v, plan.solve_time, plan.solved, plan.levels)
    return book.record(), tuple(done)


class _Book:
    """Collects a record."""

    def __init__(self, q: Vector) -> None:
        """Begin at rest at q, shape (n,)."""
        self._times, self._q, self._v = [0.0], [q], [np.zeros_like(q)]
        self._solve_times: list[float] = []
        self._levels: list[tuple[LevelStatus, ...]] = []
        self._failures = 0

    def add(
        self,
        time: float,
        q: Vector,
        v: Vector,
        solve_time: float,
        solved: bool,
        levels: tuple[LevelStatus, ...],
    ) -> None:
        """Add the state after a solve."""
        self._times.append(time)
        self._q.append(q)
        self._v.append(v)
        self._solve_times.append(solve_time)
        self._failures += not solved
        if levels:
            self._levels.append(levels)

    def record(self) -> Record:
        """Return all that was added."""
        return Record(
            np.array(self._times),
            np.array(self._q),
            np.array(self._v),
            np.array(self._solve_times),
            tuple(self._levels),
            self._failures,
        )
