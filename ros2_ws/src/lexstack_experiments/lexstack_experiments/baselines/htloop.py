"""Closed loops of paper H with an ideal double-integrator plant: tracking, and task sequences."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from lexstack.hqp import Solution
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

Solve = tuple[float, Vector, Vector, Plan | Solution]
"""The time [s], q and v to which a solve led, and the solve."""


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

    @classmethod
    def of(cls, q: Vector, solves: list[Solve]) -> Record:
        """Return what came of solves, from rest at q (n,)."""
        answers = [answer for *_, answer in solves]
        return cls(
            np.array([0.0, *(time for time, *_ in solves)]),
            np.array([q, *(q for _, q, _, _ in solves)]),
            np.array([np.zeros_like(q), *(v for _, _, v, _ in solves)]),
            np.array([answer.solve_time for answer in answers]),
            tuple(answer.levels for answer in answers if isinstance(answer, Plan)),
            sum(not answer.solved for answer in answers),
        )


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
) -> Record:
    """Follow tracks from rest at q, one solve per stage."""

    def wanted(now: float, _q: Vector) -> tuple[Objective, ...]:
        return objectives_of(tracks, now + optimiser.horizon.times, preview)

    return _driven(optimiser, q, seconds, wanted, around)


def follow_htidkc(
    controller: Htidkc, q: Vector, tracks: tuple[Track, ...], seconds: float
) -> Record:
    """Follow tracks from rest at q; a failed solve brakes as the controller would, and counts."""
    step, begin = controller.period, q
    v, solves = np.zeros_like(q), list[Solve]()
    for k in range(round(seconds / step)):
        now = np.array([k * step])
        references = tuple((track.kind, track.trajectory.at(now)[0]) for track in tracks)
        solution = controller.solve(q, v, references)
        v = solution.chi
        q = q + step * v
        solves.append(((k + 1) * step, q, v, solution))
    return Record.of(begin, solves)


def carry_out(
    optimiser: Htmpc,
    q: Vector,
    sequence: Sequence,
    longest: float,
    *,
    around: Around | None = None,
    event: Callable[[Sequence, RobotPose], Sequence] = lambda sequence, _pose: sequence,
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
    done: list[tuple[float, str]] = []

    def wanted(now: float, q: Vector) -> tuple[Objective, ...] | None:
        nonlocal sequence
        pose = RobotPose.of(optimiser.robot, now, q)
        before = event(sequence, pose)
        sequence = before.advanced(pose)
        if sequence.first != before.first:
            done.append((now, before.window[0].name))
        return None if sequence.done else sequence.objectives(now + optimiser.horizon.times[1:])

    return _driven(optimiser, q, longest, wanted, around), tuple(done)


def _driven(
    optimiser: Htmpc,
    q: Vector,
    seconds: float,
    wanted: Callable[[float, Vector], tuple[Objective, ...] | None],
    around: Around | None,
) -> Record:
    """Return the loop from rest at q, by what is wanted at a time [s] and place; None ends it."""
    step, begin = optimiser.config.step, q
    v, plan, solves = np.zeros_like(q), None, list[Solve]()
    for k in range(round(seconds / step)):
        now = k * step
        objectives = wanted(now, q)
        if objectives is None:
            break
        scene = None if around is None else around(now + optimiser.horizon.times[1:])
        plan = optimiser.solve(Start(now, q, v), objectives, plan, scene)
        q, v = plan.q[1], plan.v[1]
        solves.append((now + step, q, v, plan))
    return Record.of(begin, solves)
