"""The table at a run's end: its columns stay apart, however large the figures are."""

from dataclasses import replace

import pytest

from lexstack_bag.figures.figures import compute_metrics
from lexstack_bag.figures.goals import summary_lines
from lexstack_bag.figures.phases import find_phases
from lexstack_bag.figures.series import measure
from lexstack_bag.run.reader import read_run

LARGE = {"robot_a": -916190.12, "robot_b": 1751230.45}  # mm


@pytest.mark.parametrize("name", ["track", "posture_mid_range", "a_stack_with_a_very_long_name"])
def test_columns_never_run_into_each_other(synthetic, name):
    run = read_run(synthetic.folder)
    metrics = compute_metrics(run, measure(run), find_phases(run))
    phase = replace(
        metrics.phases[0],
        stack=name,
        start_s=123456.78,
        settled_s=1234567.89,
        transition_s=98765.43,
        ee_error_mm=LARGE,
        base_error_mm=LARGE,
        peak_acceleration_ratio=123456.789,
    )
    lines = summary_lines(replace(metrics, phases=(phase,), peak_acceleration_ratio=1.5e9))
    (line,) = (line for line in lines if line.startswith(name))
    pair = ["-916190.12", "/", "1751230.45"]
    figures = ["123456.78", "1234567.89", "98765.43", *pair, *pair, "123456.789"]
    assert line.split() == [name, *figures]
    (goal,) = (line for line in lines if line.startswith("Peak acceleration"))
    assert goal.split()[-3:] == ["1.5e+09", "NOT", "reached"]
