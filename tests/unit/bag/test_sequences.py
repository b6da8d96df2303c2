"""Sequences of tasks: figures that can be computed on paper, and what the report says of them."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from lexstack_bag.figures.compare import compare_metrics
from lexstack_bag.figures.export import tables
from lexstack_bag.figures.figures import compute_metrics
from lexstack_bag.figures.goals import goals_of, summary_lines
from lexstack_bag.figures.phases import find_phases
from lexstack_bag.figures.series import measure
from lexstack_bag.report import sequences as page
from lexstack_bag.run.reader import read_run
from lexstack_bag.run.run import SequenceEvent
from lexstack_bag.run.sequences import executions, ratio_of, sequences_of
from support.sequences import TO, plan_topics


@pytest.fixture(scope="module")
def run(synthetic):
    plain = read_run(synthetic.folder)
    ht = plan_topics([("to", 10), ("give", 12), ("", 1)])
    st = plan_topics([("to", 24), ("give", 31), ("", 1)], "st", 40)
    return replace(plain, plan_topics={"robot_a": ht, "robot_b": st})


def metrics_of(run):
    phases = find_phases(run)
    time_series = measure(run)
    return compute_metrics(run, time_series, phases), time_series, phases


def test_times_and_errors_of_every_task(run):
    one, other = sequences_of(run)
    assert (one.robot, one.architecture, one.begun_s) == ("robot_a", "ht", pytest.approx(0.2))
    assert one.completion_s == pytest.approx(22 * 0.05)
    assert (one.done, one.count, one.plans_hz) == (2, 2, pytest.approx(20.0))
    to, give = one.tasks
    assert (to.name, to.first_s, to.done_s) == ("to", pytest.approx(0.2), pytest.approx(0.7))
    assert (give.first_s, give.done_s) == (pytest.approx(0.7), pytest.approx(1.3))
    # The last half second before give was done: its plans 12 to 21 of 0 to 22.
    assert give.error_mm == pytest.approx(np.mean(100.0 * (1.0 - np.arange(12, 22) / 22)))
    assert one.level_error_mm == {"level 1": pytest.approx(2.0), "level 2": pytest.approx(30.0)}
    assert ratio_of((one, other)) == pytest.approx(55 / 22)


def test_a_sequence_that_was_not_completed_has_no_time_and_no_ratio(run):
    cut = replace(
        run, plan_topics=run.plan_topics | {"robot_b": plan_topics([("to", 24)], "st", 40)}
    )
    metrics, _, _ = metrics_of(cut)
    other = metrics.sequences[1]
    assert (other.completion_s, other.done) == (None, 0)
    assert other.tasks[0].done_s is None
    assert metrics.st_over_ht is None


def test_a_sequence_in_place_of_another_is_one_of_its_own():
    begun = [
        SequenceEvent(i, tick, "ht", event, "", (TO,))
        for i, (tick, event) in enumerate([(20, "begin"), (45, "release"), (60, "replace")])
    ]
    rows = list(executions(plan_topics([("to", 12)], events=begun)))
    assert [part.tolist() for part in rows] == [list(range(8)), list(range(8, 12))]


def test_goals_and_lines_tell_what_was_done_and_the_ratio(run):
    metrics, _, _ = metrics_of(replace(run, resolved=renamed(run.resolved)))
    goals = {goal.quantity: goal for goal in goals_of(metrics)}
    assert goals["Tasks of sequences not done, of 4"].reached
    ratio = goals["Time of ST-Arch / time of HT-Arch"]
    assert (ratio.goal, ratio.ours, ratio.reached) == ("≥ 2.3", "2.5", True)
    assert not replace(ratio, value=2.2).reached
    text = "\n".join(summary_lines(metrics))
    assert "robot_a, HT-Arch           0.20    2 of 2            1.10      20.0      4.00" in text
    assert json.loads(metrics.to_json())["sequences"][0]["tasks"][1]["name"] == "give"


def renamed(resolved):
    """Return a scenario that is not the paper's sequence."""
    return replace(resolved, scenario=replace(resolved.scenario, name="delivery"))


def test_the_page_has_the_tables_and_figures_of_the_sequences(run):
    metrics, time_series, phases = metrics_of(run)
    html = page.section(metrics)
    assert "ST-Arch took <b>2.50</b> times as long as HT-Arch" in html
    assert html.count("<td>give</td>") == 2
    figures = {f.name: f for f in page.figures(run, time_series, phases, metrics)}
    assert list(figures) == ["tasks", "sequence-paths", "level-errors", "plan-times"]
    bars = {trace["name"]: trace for trace in figures["tasks"].traces}
    assert bars["give"]["y"] == ["robot_a, HT-Arch", "robot_b, ST-Arch"]
    assert bars["give"]["base"] == pytest.approx([0.7, 1.6])
    assert len(figures["level-errors"].traces) == 6
    assert page.figures(run, time_series, phases, replace(metrics, sequences=())) == []
    assert page.section(replace(metrics, sequences=())) == ""


def test_a_comparison_pairs_the_sequences(run):
    metrics, _, _ = metrics_of(run)
    slower = replace(metrics.sequences[0], completion_s=2.0)
    found = compare_metrics(metrics, replace(metrics, sequences=(slower,)))
    entries = {(d.group, d.figure): d for d in found.differences}
    entry = entries["sequence 1: robot_a, HT-Arch", "completion"]
    assert (entry.first, entry.second, entry.unit) == (pytest.approx(1.1), 2.0, "s")
    assert entry.better == "first"
    assert entries["sequence 2: robot_b, ST-Arch", "done"].second is None


def test_the_progress_of_each_robot_is_a_table(run):
    found = tables(run, measure(run))
    assert set(found) >= {"robot_a_plans", "robot_b_plans"}
    columns = found["robot_a_plans"]
    assert len({len(column) for column in columns.values()}) == 1
    assert columns["task"].tolist() == ["to"] * 10 + ["give"] * 13
    assert "error/level_0 [m]" not in columns, "levels are counted from 1"
    assert columns["error/level_2 [m]"].tolist() == [0.03] * 23
