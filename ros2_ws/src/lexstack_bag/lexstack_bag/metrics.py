"""The figures of a run, ``metrics.json``, from its bag and from nothing else."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from lexstack_core.linear import Matrix, Vector

from lexstack_bag.measures import COMMANDER, Measures
from lexstack_bag.phases import BASE_TASKS, EE_TASKS, Phase, robots_with
from lexstack_bag.run import Run, SolveStatus

STEADY_WINDOW = 0.5  # s, the end of a phase over which steady-state errors are averaged
SETTLED_BAND = 1.0  # mm, an error is settled once it stays below its steady state plus this

PerRobot = dict[str, float | None]


@dataclass(frozen=True, slots=True)
class PhaseMetrics:
    """The figures of one phase; None where its stack has no such task."""

    stack: str
    start_s: float
    settled_s: float | None  # from start_s until all errors stay in their band
    transition_s: float | None  # from the trigger to the adoption
    ee_error_mm: PerRobot  # steady state
    ee_peak_error_mm: PerRobot
    base_error_mm: PerRobot | None  # steady state
    base_error_mrad: PerRobot | None  # steady state, yaw
    peak_acceleration_ratio: float | None


@dataclass(frozen=True, slots=True)
class Metrics:
    """The figures of one run, with the keys of ``metrics.json``."""

    scenario: str
    mode: str
    seed: int
    rate_hz: float
    ticks: int
    late_ticks: int
    missing_ticks: int
    empty_bounds: int
    solver_failures: int
    peak_acceleration_ratio: float | None
    peak_jerk_ratio: float | None
    phases: tuple[PhaseMetrics, ...]
    solve_us: dict[str, dict[str, float | None]]
    messages: dict[str, int]
    recorder_lost: int

    def to_json(self) -> str:
        """Return the text of ``metrics.json``; it never holds NaN."""
        return json.dumps(asdict(self), indent=2, allow_nan=False) + "\n"


def compute_metrics(run: Run, measures: Measures, phases: tuple[Phase, ...]) -> Metrics:
    """Return the figures of a run."""
    scenario, command = run.resolved.scenario, run.chi[COMMANDER]
    return Metrics(
        scenario=scenario.name,
        mode=scenario.mode,
        seed=scenario.seed,
        rate_hz=scenario.rate,
        ticks=len(run.plant.tick),
        late_ticks=_last(run.plant.late_ticks),
        missing_ticks=_gaps(command.tick),
        empty_bounds=_empty_bounds(run),
        solver_failures=sum(
            int(np.count_nonzero(chi.status != SolveStatus.SOLVED)) for chi in run.chi.values()
        ),
        peak_acceleration_ratio=_peak(measures.acceleration_ratio),
        peak_jerk_ratio=_peak(measures.jerk_ratio),
        phases=tuple(_phase(run, measures, phase) for phase in phases),
        solve_us={
            name: {
                "median": _percentile(1e6 * chi.solve_time, 50),
                "p99": _percentile(1e6 * chi.solve_time, 99),
            }
            for name, chi in run.chi.items()
        },
        messages=run.messages,
        recorder_lost=run.lost,
    )


def _phase(run: Run, measures: Measures, phase: Phase) -> PhaseMetrics:
    """Return the figures of one phase."""
    ticks = phase.ticks(measures.time)
    steady = ticks & (measures.time >= phase.end - STEADY_WINDOW - 1e-6)
    ee = robots_with(run, phase.stack, EE_TASKS)
    base = robots_with(run, phase.stack, BASE_TASKS)

    def figures(errors: Matrix, rows: Any, take: Any, robots: tuple[str, ...]) -> PerRobot:
        return {
            name: _number(take(errors[rows, i])) if name in robots and rows.any() else None
            for i, name in enumerate(run.robots)
        }

    series = [measures.ee_error[:, run.robots.index(name)] for name in ee]
    series += [measures.base_error[:, run.robots.index(name)] for name in base]
    return PhaseMetrics(
        stack=phase.stack,
        start_s=round(phase.start, 9),
        settled_s=_settled([(errors[ticks], errors[steady]) for errors in series], run.period),
        transition_s=None if phase.adopted is None else round(phase.adopted - phase.start, 9),
        ee_error_mm=figures(measures.ee_error, steady, np.mean, ee),
        ee_peak_error_mm=figures(measures.ee_error, ticks, np.max, ee),
        base_error_mm=figures(measures.base_error, steady, np.mean, base) if base else None,
        base_error_mrad=figures(measures.yaw_error, steady, np.mean, base) if base else None,
        peak_acceleration_ratio=_peak(
            measures.acceleration_ratio[phase.ticks(measures.command_time)]
        ),
    )


def _settled(series: list[tuple[Vector, Vector]], period: float) -> float | None:
    """Return the time after which every error stays within its band [s]; None: never, or none.

    Args:
        series: per error its values in the phase and those in the steady window [mm].
        period: of the ticks [s].
    """
    times = []
    for errors, steady in series:
        if not len(errors):
            return None
        outside = np.flatnonzero(~(errors <= np.mean(steady) + SETTLED_BAND))
        last = int(outside[-1]) + 1 if len(outside) else 0
        if last == len(errors):
            return None
        times.append(last * period)
    return round(max(times), 9) if times else None


def _empty_bounds(run: Run) -> int:
    """Return the ticks with lower > upper: as robot A counted, and as the bag shows."""
    command = run.chi[COMMANDER]
    shown = int(np.count_nonzero((command.lower > command.upper).any(axis=1)))
    return max(shown, _last(command.empty_bounds))


def _gaps(ticks: Any) -> int:
    """Return how many ticks are missing between the first and the last."""
    return int(ticks[-1] - ticks[0]) + 1 - len(ticks) if len(ticks) else 0


def _last(counter: Any) -> int:
    """Return the final value of a counter, 0 without any."""
    return int(counter[-1]) if len(counter) else 0


def _peak(ratios: Matrix) -> float | None:
    """Return the largest ratio, None without any."""
    known = ratios[np.isfinite(ratios)]
    return float(known.max()) if known.size else None


def _percentile(values: Vector, percent: float) -> float | None:
    """Return a percentile, None without values."""
    return _number(np.percentile(values, percent)) if len(values) else None


def _number(value: Any) -> float | None:
    """Return a float that JSON can hold."""
    return float(value) if np.isfinite(value) else None
