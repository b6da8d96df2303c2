"""What a run's bag says tick by tick: references in effect, errors, acceleration and jerk ratios.

Shapes: T ticks of the plant, K ticks of the controller's command, N robots, n the length of chi.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lexstack.limits import JointLimits
from lexstack.references import References
from lexstack.robots import Team
from lexstack.types import Matrix, Vector
from lexstack_bag.figures.limits import limits_in_force
from lexstack_bag.run.references import references_in_effect
from lexstack_bag.run.run import Run, Single
from lexstack_bag.storage.container import Progress

COMMANDER = "robot_a"  # whose chi is the command
_MM = 1e3
_MRAD = 1e3


@dataclass(frozen=True, slots=True)
class TimeSeries:
    """A run's time series, from measured positions and the recorded command."""

    time: Vector  # (T,) s, simulated
    references: tuple[References, ...]  # T of them
    ee: NDArray[np.float64]  # (T, N, 3) m, measured tool positions
    ee_target: NDArray[np.float64]  # (T, N, 3) m
    base: NDArray[np.float64]  # (T, N, 3) m, m, rad
    base_target: NDArray[np.float64]  # (T, N, 3) m, m, rad
    ee_error: Matrix  # (T, N) mm
    base_error: Matrix  # (T, N) mm, x and y
    yaw_error: Matrix  # (T, N) mrad
    command_time: Vector  # (K,) s
    acceleration_ratio: Single  # (K, n) |a| / limit in force; nan after a gap in the ticks
    jerk_ratio: Single  # (K, n) |jerk| / limit in force; nan after a gap in the ticks


def measure(run: Run, progress: Progress = lambda _part: None) -> TimeSeries:
    """Return the time series of a run; runs forward kinematics for every tick."""
    team = run.team()
    q, time = run.plant.q, run.plant.stamp
    ee = _tools(team, q, progress)
    base = _bases(team, q)
    references = references_in_effect(run, team)
    ee_target, base_target = _positions(references, len(team.robots))
    yaw = base[:, :, 2] - base_target[:, :, 2]
    acceleration, jerk = _ratios(run, team)
    return TimeSeries(
        time,
        references,
        ee,
        ee_target,
        base,
        base_target,
        _MM * np.linalg.norm(ee - ee_target, axis=2),
        _MM * np.linalg.norm(base[:, :, :2] - base_target[:, :, :2], axis=2),
        _MRAD * np.abs(np.arctan2(np.sin(yaw), np.cos(yaw))),
        run.chi[COMMANDER].stamp,
        acceleration,
        jerk,
    )


def _bases(team: Team, q: Matrix) -> NDArray[np.float64]:
    """Return x, y, yaw of the bases at every row of q, shape (T, N, 3); of none, its mounting."""
    found = [
        q[:, part][:, robot.base_q]
        if robot.has_base
        else np.tile(robot.base_pose(q[0, part]), (len(q), 1))
        for robot, part in zip(team.robots, team.q_slices, strict=True)
    ]
    return np.stack(found, axis=1)


def _tools(team: Team, q: Matrix, progress: Progress) -> NDArray[np.float64]:
    """Return the positions of the tools at every row of q, shape (T, N, 3) [m]."""
    found = np.empty((len(q), len(team.robots), 3))
    for tick, row in enumerate(q):
        for robot, pose in enumerate(team.tools(row)):
            found[tick, robot] = pose.position
        progress((tick + 1) / len(q))
    return found


def _positions(
    references: tuple[References, ...], robots: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the targets of tools [m] and bases [m, m, rad], shape (T, N, 3) each."""
    ee, base = (np.empty((len(references), robots, 3)) for _ in range(2))
    for tick, now in enumerate(references):
        if tick and now is references[tick - 1]:  # they change seldom
            ee[tick], base[tick] = ee[tick - 1], base[tick - 1]
        else:
            ee[tick], base[tick] = [pose.position for pose in now.ee], now.base
    return ee, base


def _ratios(run: Run, team: Team) -> tuple[Single, ...]:
    """Return acceleration and jerk of the command over the limits in force, shape (K, n) each.

    A difference across a gap in the ticks is no acceleration: it is nan. The first command is
    taken against what the plant executed before it, and from rest if that was nothing.
    """
    command, dt = run.chi[COMMANDER], run.period
    before = run.plant.command[np.isin(run.plant.tick, command.tick[:1])]
    if not len(before):
        before = np.full((1, team.n), np.nan)
    acceleration = np.diff(command.chi, axis=0, prepend=before)
    acceleration /= dt
    acceleration[1:][np.diff(command.tick) != 1] = np.nan
    rest = np.where(before.any(), np.nan, np.zeros((1, team.n)))
    jerk = np.diff(acceleration, axis=0, prepend=rest)
    jerk /= dt
    limits = limits_in_force(run, team, COMMANDER)
    return tuple(
        _over_limit(rates, limits, name)
        for rates, name in ((acceleration, "acceleration"), (jerk, "jerk"))
    )


def _over_limit(rates: Matrix, limits: Sequence[JointLimits], name: str) -> Single:
    """Return rates over one of the limits in force, in place of the rates, shape (K, n)."""
    np.abs(rates, out=rates)
    first = 0
    for last in range(1, len(limits) + 1):  # they are one object for many ticks
        if last == len(limits) or limits[last] is not limits[first]:
            rates[first:last] /= getattr(limits[first], name)
            first = last
    return rates.astype(np.float32)


def finite(value: Any) -> float | None:
    """Return a number as JSON can hold it."""
    return float(value) if np.isfinite(value) else None
