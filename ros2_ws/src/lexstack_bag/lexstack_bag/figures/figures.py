"""The figures of a run, ``metrics.json``, from its bag and from nothing else."""

from __future__ import annotations

import json
from collections.abc import Collection
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lexstack.hqp import DAMPED, NEAR
from lexstack.robots import Team
from lexstack.types import Matrix, Vector
from lexstack_bag.figures.levels import LevelMetrics, levels_of
from lexstack_bag.figures.phases import BASE_TASKS, EE_TASKS, Phase, find_phases, tasks_of
from lexstack_bag.figures.relative_errors import PerRobot, relative_errors_of
from lexstack_bag.figures.series import COMMANDER, TimeSeries, finite, measure
from lexstack_bag.figures.settling import posture_errors, settled_after
from lexstack_bag.figures.task_errors import TaskErrors, errors_of, summed_up
from lexstack_bag.run.run import Run, RunPart, SolveStatus
from lexstack_bag.run.sequences import SequenceMetrics, ratio_of, sequences_of
from lexstack_bag.run.wholeness import doubts_of, gaps_of, span_of, wholeness_of
from lexstack_bag.storage.container import Progress

STEADY_WINDOW = 0.5  # s, the end of a phase over which steady-state errors are averaged

__all__ = ["Analysis", "Metrics", "PerRobot", "PhaseMetrics", "compute_metrics"]


@dataclass(frozen=True, slots=True)
class PhaseMetrics:
    """The figures of one phase; None where its stack has no such task."""

    stack: str
    start_s: float
    settled_s: float | None  # from start_s until all errors stay in their band; None: never
    transition_s: float | None  # from the trigger to the adoption; None: not adopted
    ee_error_mm: PerRobot  # steady state
    ee_peak_error_mm: PerRobot
    base_error_mm: PerRobot | None  # steady state
    base_error_mrad: PerRobot | None  # steady state, yaw
    peak_acceleration_ratio: float | None
    relative_error_mm: PerRobot | None = None  # steady state, of an object that two robots hold
    relative_error_mrad: PerRobot | None = None
    relative_peak_error_mm: PerRobot | None = None
    relative_peak_error_mrad: PerRobot | None = None
    obstacle_distance_mm: PerRobot | None = None  # least, of the spheres; None without obstacles
    damped_share: float = 0.0  # of the command's ticks, with a level damped near a singularity
    posture_error_mrad: PerRobot | None = None  # steady state, norm over the arm's joints
    robots: tuple[str, ...] = ()  # that it is about; empty: all
    outcome: str = ""  # adopted, cancelled, aborted, replaced, under way; empty: the first phase
    has_errors: bool = True  # whether its stack has a task that can settle
    levels: tuple[LevelMetrics, ...] = ()
    tasks: tuple[TaskErrors, ...] = ()  # errors of all other tasks

    @property
    def title(self) -> str:
        """The stack, and the robots unless it is about all of them."""
        return f"{self.stack} ({', '.join(self.robots)})" if self.robots else self.stack


@dataclass(frozen=True, slots=True)
class Metrics:
    """The figures of one run, with the keys of ``metrics.json``."""

    scenario: str
    mode: str
    seed: int
    rate_hz: float
    ticks: int  # of the command, from the first to the last
    late_ticks: int  # as the plant counted
    missing_ticks: int  # for which no command came in time, as the plant counted
    empty_bounds: int
    solver_failures: int
    peak_acceleration_ratio: float | None
    peak_jerk_ratio: float | None
    phases: tuple[PhaseMetrics, ...]
    solve_us: dict[str, dict[str, float | None]]
    messages: dict[str, int]
    recorder_lost: int
    sequences: tuple[SequenceMetrics, ...] = ()
    st_over_ht: float | None = None  # time of ST-Arch over that of HT-Arch, where both are there
    damped_share: float = 0.0  # of the command's ticks, with a level damped near a singularity
    holding_ticks: int = 0  # states in which the plant held the last command
    braking_ticks: int = 0  # states in which the plant braked
    states_not_in_bag: int = 0  # ticks between the first and the last state
    longest_gap_s: float = 0.0  # between two states
    commands_not_in_bag: int = 0  # ticks from the first to the last command
    part: int = 1  # of the bag that these figures are about: a reset begins a part
    parts: tuple[RunPart, ...] = ()  # of the bag; none: it has no reset
    doubts: tuple[str, ...] = ()  # why no goal can be called reached
    gaps: tuple[str, ...] = ()  # what the bag does not have
    singular: tuple[
        str, ...
    ] = ()  # near which singularities robots were, as the controller said, and from when

    def to_json(self) -> str:
        """Return the text of ``metrics.json``; it never holds NaN."""
        return json.dumps(asdict(self), indent=2, allow_nan=False) + "\n"


@dataclass(frozen=True, slots=True)
class Analysis:
    """A run and all that is computed from it."""

    run: Run
    time_series: TimeSeries
    phases: tuple[Phase, ...]
    metrics: Metrics

    @classmethod
    def of(cls, run: Run, progress: Progress = lambda _part: None) -> Analysis:
        """Compute time series, phases and figures of a run."""
        time_series, phases = measure(run, progress), find_phases(run)
        return cls(run, time_series, phases, compute_metrics(run, time_series, phases))


def compute_metrics(run: Run, time_series: TimeSeries, phases: tuple[Phase, ...]) -> Metrics:
    """Return the figures of a run."""
    scenario, command, team = run.resolved.scenario, run.chi[COMMANDER], run.team()
    sequences, whole = sequences_of(run), wholeness_of(run)
    solve_times = {name: chi.solve_time for name, chi in run.chi.items()}
    for robot, plan_topics in run.plan_topics.items():
        solve_times[f"htmpc, {robot}"] = plan_topics.progress.solve_time
    return Metrics(
        scenario=scenario.name,
        mode=scenario.mode,
        seed=scenario.seed,
        rate_hz=scenario.rate,
        ticks=span_of(command.tick),
        empty_bounds=_empty_bounds(run),
        solver_failures=sum(
            int(np.count_nonzero(chi.status != SolveStatus.SOLVED)) for chi in run.chi.values()
        )
        + sum(sequence.failed_plans for sequence in sequences),
        peak_acceleration_ratio=_peak(time_series.acceleration_ratio),
        peak_jerk_ratio=_peak(time_series.jerk_ratio),
        phases=tuple(_phase(run, team, time_series, phase) for phase in phases),
        solve_us={
            name: {
                "median": _percentile(1e6 * times, 50),
                "p99": _percentile(1e6 * times, 99),
            }
            for name, times in solve_times.items()
        },
        messages=run.messages,
        recorder_lost=run.lost,
        sequences=sequences,
        st_over_ht=ratio_of(sequences),
        damped_share=_damped(run, np.ones(len(command.tick), dtype=np.bool_)),
        part=run.part,
        parts=run.parts,
        doubts=doubts_of(run, whole),
        gaps=gaps_of(whole),
        singular=_singular(run),
        **asdict(whole),
    )


def _phase(run: Run, team: Team, time_series: TimeSeries, phase: Phase) -> PhaseMetrics:
    """Return the figures of one phase."""
    ticks = phase.ticks(time_series.time)
    steady = ticks & (time_series.time >= phase.end - STEADY_WINDOW - 1e-6)
    ee = tasks_of(run, phase.stack, EE_TASKS)
    base = tasks_of(run, phase.stack, BASE_TASKS)
    postures = posture_errors(run, team, phase.stack)
    others = errors_of(run, team, time_series, phase, ticks)
    series = [each for both in others.values() for each in both if each is not None]

    def figures(errors: Matrix, rows: Any, take: Any, robots: Collection[str]) -> PerRobot:
        return {
            name: finite(take(errors[rows, i])) if name in robots and rows.any() else None
            for i, name in enumerate(run.robots)
        }

    return PhaseMetrics(
        stack=phase.stack,
        start_s=round(phase.start, 9),
        settled_s=settled_after(run, team, time_series, phase, ticks, steady, others=series),
        transition_s=None if phase.adopted is None else round(phase.adopted - phase.start, 9),
        ee_error_mm=figures(time_series.ee_error, steady, np.mean, ee),
        ee_peak_error_mm=figures(time_series.ee_error, ticks, np.max, ee),
        base_error_mm=figures(time_series.base_error, steady, np.mean, base) if base else None,
        base_error_mrad=figures(time_series.yaw_error, steady, np.mean, base) if base else None,
        peak_acceleration_ratio=_peak(
            time_series.acceleration_ratio[phase.ticks(time_series.command_time)]
        ),
        damped_share=_damped(run, phase.ticks(time_series.command_time)),
        **asdict(relative_errors_of(run, team, time_series, phase.stack, ticks, steady)),
        posture_error_mrad={
            name: finite(np.mean(postures[name][steady]))
            if name in postures and steady.any()
            else None
            for name in run.robots
        }
        if postures
        else None,
        robots=phase.robots,
        outcome=phase.outcome,
        has_errors=bool(ee or base or postures or series),
        levels=levels_of(run, team, time_series, phase, steady),
        tasks=summed_up(others, ticks, steady),
    )


def _damped(run: Run, ticks: NDArray[np.bool_]) -> float:
    """Return in which share of some ticks a level was damped, as the controller says."""
    reasons = [str(reason) for reason in run.chi[COMMANDER].reason[ticks]]
    damped = sum(reason.startswith(NEAR) and DAMPED in reason for reason in reasons)
    return damped / len(reasons) if reasons else 0.0


def _singular(run: Run) -> tuple[str, ...]:
    """Return what the controller said of singularities, once each, with stack and first time."""
    told, said = run.transition, dict[str, str]()
    for stamp, stack, reason in zip(told.stamp, told.to_stack, told.reason, strict=True):
        at = str(reason).find(NEAR)
        if at >= 0:
            what = f"{stack}: {str(reason)[at:]}"
            said.setdefault(what, f"{what}, from {float(stamp):.2f} s on")
    return tuple(said.values())


def _empty_bounds(run: Run) -> int:
    """Return the ticks with an empty box: as the controller said, or as the bag shows."""
    command = run.chi[COMMANDER]
    empty = (command.lower > command.upper).any(axis=1) | (command.empty_bounds > 0)
    return int(np.count_nonzero(empty))


def _peak(ratios: Matrix) -> float | None:
    """Return the largest ratio, None without any."""
    known = ratios[np.isfinite(ratios)]
    return float(known.max()) if known.size else None


def _percentile(values: Vector, percent: float) -> float | None:
    """Return a percentile, None without values."""
    return finite(np.percentile(values, percent)) if len(values) else None
