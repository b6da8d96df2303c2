"""Two runs side by side: every figure is there, with its unit, and says which is better."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from lexstack_bag.figures.compare import MESSAGES, RUN, compare_metrics, summary_lines
from lexstack_bag.figures.figures import Metrics, compute_metrics
from lexstack_bag.figures.phases import find_phases
from lexstack_bag.figures.series import measure
from lexstack_bag.run.reader import read_run


@pytest.fixture(scope="module")
def metrics(synthetic) -> Metrics:
    run = read_run(synthetic.folder)
    return compute_metrics(run, measure(run), find_phases(run))


def entry(comparison, group, figure, unit=None):
    matching = [d for d in comparison.differences if (d.group, d.figure) == (group, figure)]
    (found,) = [d for d in matching if unit in (None, d.unit)]
    return found


def test_a_run_is_the_same_as_itself(metrics):
    comparison = compare_metrics(metrics, metrics)
    assert comparison.setup["seed"] == ("7", "7")
    assert len(comparison.differences) > 30
    assert {d.change for d in comparison.differences} <= {0.0, None}
    assert {d.better for d in comparison.differences if d.change == 0.0} == {"same"}
    told = ("the commands of 1 tick are not in the bag, so peaks may be missing",) * 2
    assert comparison.setup["not as it should be"] == told
    assert len(summary_lines(comparison)) == 4 + 1 + 1


def test_figures_units_and_who_is_better(metrics):
    last = metrics.phases[1]
    errors = {"robot_a": 2.0, "robot_b": last.ee_error_mm["robot_b"]}
    phases = (metrics.phases[0], replace(last, ee_error_mm=errors, base_error_mm=None))
    other = replace(metrics, phases=phases, late_ticks=5, rate_hz=200.0, seed=8)
    comparison = compare_metrics(metrics, other, ("old", "new"))
    assert comparison.setup["seed"] == ("7", "8")

    error = entry(comparison, "phase 2: reach_base", "ee error, robot_a")
    assert (error.unit, error.better) == ("mm", "second")
    assert (error.first, error.second) == pytest.approx((5.0, 2.0))
    assert (error.change, error.relative) == pytest.approx((-3.0, -0.6))
    late = entry(comparison, RUN, "late ticks")
    assert (late.unit, late.change, late.better) == ("", 3, "first")
    rate = entry(comparison, RUN, "rate")
    assert (rate.unit, rate.change, rate.better) == ("Hz", 100.0, None)
    base = entry(comparison, "phase 2: reach_base", "base error, robot_b", "mm")
    assert base.first == pytest.approx(2.0)
    assert (base.second, base.change, base.better) == (None, None, None)
    assert entry(comparison, RUN, "solve, robot_a, p99").unit == "µs"
    assert entry(comparison, MESSAGES, "/plant/state").first == 400
    text = "\n".join(summary_lines(comparison))
    assert "phase 2: reach_base, ee error, robot_a [mm]" in text
    assert "late ticks" in text


def test_phases_are_paired_by_their_stacks(metrics):
    track, reach = metrics.phases
    longer = replace(metrics, phases=(track, replace(reach, stack="posture"), reach))
    comparison = compare_metrics(metrics, longer)
    assert entry(comparison, "phase 2: posture", "start").first is None
    assert entry(comparison, "phase 3: reach_base", "ee error, robot_a").change == 0.0


def test_the_file_has_the_derived_figures_and_no_nan(metrics):
    text = compare_metrics(metrics, replace(metrics, late_ticks=0)).to_json()
    assert "NaN" not in text
    (late,) = [d for d in json.loads(text)["differences"] if d["figure"] == "late ticks"]
    assert late == {
        "group": "run",
        "figure": "late ticks",
        "unit": "",
        "first": 2,
        "second": 0,
        "change": -2,
        "relative": -1.0,
        "better": "second",
    }
