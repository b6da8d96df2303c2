"""Builds the report of a run."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from lexstack_bag.figures.figures import Metrics
from lexstack_bag.figures.phases import Phase
from lexstack_bag.figures.series import TimeSeries
from lexstack_bag.report import control, motion, sequences, switches, view
from lexstack_bag.report.bands import with_bands
from lexstack_bag.report.page import page
from lexstack_bag.report.pictures import pictures
from lexstack_bag.report.traces import Grid
from lexstack_bag.run.run import Run
from lexstack_bag.run.wholeness import bands_of


def write_report(
    path: Path,
    run: Run,
    time_series: TimeSeries,
    phases: tuple[Phase, ...],
    metrics: Metrics,
    progress: Callable[[str], None] = lambda _line: None,
) -> None:
    """Write the report of a run to one HTML file."""
    grid = Grid.of(run)
    levels = control.levels(run, phases, grid)
    figures = [
        motion.stacks(phases, grid),
        *sequences.figures(run, time_series, phases, metrics),
        motion.poses(run, time_series, phases, grid),
        motion.errors(run, time_series, phases, grid),
        motion.from_above(run, time_series),
        *switches.switches(run, phases, grid),
        control.computation(run, phases, grid),
        *([] if levels is None else [levels]),
        control.smoothness(run, time_series, phases, grid),
        control.bounds(run, phases, grid),
    ]
    bands = bands_of(run)
    figures = [with_bands(figure, bands) for figure in figures]
    progress(f"drew {len(figures)} figures")
    moving, no_view = view.view(run, time_series, phases)
    if no_view:
        progress(f"no 3-D view: {no_view}")
    shots, reason = pictures(run, time_series, phases)
    progress(f"rendered {len(shots)} pictures" if shots else f"no pictures: {reason}")
    path.write_text(page(run, metrics, figures, moving, shots, reason), encoding="utf-8")
