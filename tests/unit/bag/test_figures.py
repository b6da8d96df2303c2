"""The figures of the run made by hand, each computed on paper."""

from __future__ import annotations

import json

import pytest

from lexstack_bag.figures.figures import Metrics, compute_metrics
from lexstack_bag.figures.phases import find_phases
from lexstack_bag.figures.series import measure
from lexstack_bag.run.reader import read_run


@pytest.fixture(scope="module")
def metrics(synthetic) -> Metrics:
    run = read_run(synthetic.folder)
    return compute_metrics(run, measure(run), find_phases(run))


def test_the_whole_run(metrics, synthetic):
    assert (metrics.scenario, metrics.mode, metrics.seed) == ("transition-sequence", "lockstep", 7)
    assert metrics.rate_hz == 100.0
    assert metrics.ticks == 400
    assert metrics.late_ticks == 2
    assert metrics.missing_ticks == 0  # the plant got all of them
    assert metrics.commands_not_in_bag == 1
    assert (metrics.states_not_in_bag, metrics.longest_gap_s) == (0, 0.0)
    assert (metrics.holding_ticks, metrics.braking_ticks) == (0, 0)
    assert metrics.doubts == ()
    assert metrics.gaps == ("the commands of 1 tick are not in the bag, so peaks may be missing",)
    assert metrics.empty_bounds == 2
    assert metrics.solver_failures == 2
    assert metrics.recorder_lost == 3
    assert metrics.messages == synthetic.counts


def test_acceleration_and_jerk_leave_gaps_out(metrics):
    assert metrics.peak_acceleration_ratio == pytest.approx(0.5)
    assert metrics.peak_jerk_ratio == pytest.approx(1.0)


def test_solve_times(metrics):
    # 1 to 100 us, four times each, but 1 us thrice: the 200th of 399 is 51 us.
    assert metrics.solve_us["robot_a"]["median"] == pytest.approx(51.0)
    assert metrics.solve_us["robot_a"]["p99"] == pytest.approx(99.02)
    assert metrics.solve_us["robot_b"] == pytest.approx({"median": 500.0, "p99": 500.0})


def test_the_first_phase(metrics):
    first = metrics.phases[0]
    assert (first.stack, first.start_s, first.transition_s) == ("track", 0.0, None)
    assert first.settled_s == 0.0
    assert first.ee_error_mm == pytest.approx({"robot_a": 5.0, "robot_b": 0.0}, abs=1e-9)
    assert first.ee_peak_error_mm == pytest.approx({"robot_a": 5.0, "robot_b": 0.0}, abs=1e-9)
    assert first.base_error_mm is None
    assert first.base_error_mrad is None
    assert first.peak_acceleration_ratio == pytest.approx(0.5)


def test_the_phase_after_the_switch(metrics):
    assert len(metrics.phases) == 2
    second = metrics.phases[1]
    assert (second.stack, second.start_s, second.transition_s) == ("reach_base", 1.0, 1.0)
    assert second.settled_s == 1.0  # robot B's base is 50 mm off until then, 2 mm after
    assert second.ee_error_mm == pytest.approx({"robot_a": 5.0, "robot_b": 1.0}, abs=1e-9)
    assert second.base_error_mm == pytest.approx({"robot_a": 0.0, "robot_b": 2.0}, abs=1e-9)
    assert second.base_error_mrad == pytest.approx({"robot_a": 0.0, "robot_b": 10.0}, abs=1e-9)
    assert second.peak_acceleration_ratio == pytest.approx(0.1)


def test_the_file_has_the_promised_keys(metrics):
    data = json.loads(metrics.to_json())
    assert list(data) == [
        "scenario",
        "mode",
        "seed",
        "rate_hz",
        "ticks",
        "late_ticks",
        "missing_ticks",
        "empty_bounds",
        "solver_failures",
        "peak_acceleration_ratio",
        "peak_jerk_ratio",
        "phases",
        "solve_us",
        "messages",
        "recorder_lost",
        "sequences",
        "st_over_ht",
        "damped_share",
        "holding_ticks",
        "braking_ticks",
        "states_not_in_bag",
        "longest_gap_s",
        "commands_not_in_bag",
        "part",
        "parts",
        "doubts",
        "gaps",
        "singular",
    ]
    assert "NaN" not in metrics.to_json()
