"""What the report says in words, and how its plots tell things apart."""

from __future__ import annotations

import json
import re
import sys
from dataclasses import replace

import numpy as np
import pytest

from lexstack.tasks import LevelConfig, StackConfig, TaskConfig
from lexstack.transition import TransitionConfig
from lexstack_bag.figures.compare import compare_metrics
from lexstack_bag.figures.figures import Analysis, compute_metrics
from lexstack_bag.figures.goals import goals_of, held_back, summary_lines
from lexstack_bag.figures.phases import find_phases
from lexstack_bag.figures.relative_errors import TITLES
from lexstack_bag.figures.series import measure
from lexstack_bag.report.build import write_report
from lexstack_bag.report.comparison import write_comparison
from lexstack_bag.report.layout import marks
from lexstack_bag.report.tables import phases_table
from lexstack_bag.report.traces import BLUE, VERMILLION
from lexstack_bag.run.reader import read_run
from lexstack_bag.run.sequences import sequences_of
from lexstack_experiments.runs import analysed
from lexstack_sim.visuals import TINTS
from support.browser import Browser
from support.channels import loop
from support.sequences import plan_topics


def figures(path):
    pattern = r"<script type='application/json' data-figure='([\w-]+)'[^>]*>(.*?)</script>"
    text = path.read_text(encoding="utf-8")
    return {name: json.loads(found) for name, found in re.findall(pattern, text, re.DOTALL)}


# ---- a deliberate cancel


@pytest.fixture(scope="module")
def cancelled():
    run = loop(transition=TransitionConfig(duration=0.4))
    run.controller.transition.ask("reach_base", 0.0, "", 2)
    run.run(20)
    assert run.controller.transition.cancel().accepted
    run.run(100)
    return analysed(run)


def test_a_switch_that_was_cancelled_on_request_is_no_missed_goal(cancelled):
    assert [phase.outcome for phase in cancelled.phases] == ["", "cancelled", "adopted"]
    (goal,) = (goal for goal in goals_of(cancelled.metrics) if "not adopted" in goal.quantity)
    assert goal.quantity == "Switches not adopted, of 2 (1 cancelled on request)"
    assert (goal.value, goal.verdict) == (0.0, "reached")
    assert any(
        "cancelled" in line and "reach_base" in line for line in summary_lines(cancelled.metrics)
    )
    assert "<td>cancelled</td>" in phases_table(cancelled.metrics)


def test_a_switch_that_another_one_replaced_says_so():
    run = loop(transition=TransitionConfig(duration=0.4))
    run.controller.transition.ask("reach_base", 0.0, "", 2)
    run.run(20)
    run.controller.transition.ask("posture", 0.0, "", 0)
    run.run(80)
    assert [phase.outcome for phase in analysed(run).phases] == ["", "replaced", "adopted"]


def test_a_sequence_that_was_cancelled_on_request_is_no_missed_goal(synthetic):
    from lexstack_bag.run.run import SequenceEvent

    events = [
        SequenceEvent(1, 20, "ht", "begin", "", ()),
        SequenceEvent(2, 70, "ht", "cancel", "", ()),
    ]
    under_way = plan_topics([("to", 10), ("give", 12)], events=events)
    run = replace(read_run(synthetic.folder), plan_topics={"robot_a": under_way})
    run = replace(
        run,
        resolved=replace(run.resolved, scenario=replace(run.resolved.scenario, name="deliver")),
    )
    (sequence,) = sequences_of(run)
    assert sequence.cancelled
    metrics = compute_metrics(run, measure(run), find_phases(run))
    (goal,) = (goal for goal in goals_of(metrics) if "sequences" in goal.quantity)
    assert goal.quantity == "Tasks of sequences not done, of 2 (1 cancelled on request)"
    assert goal.verdict == "reached"


# ---- levels, postures, tasks of one's own


@pytest.fixture(scope="module")
def held():
    """The end effectors are asked to be where they are, and the bases to be 0.5 m away."""
    wide = StackConfig(
        "wide",
        "Position above, the whole pose below it.",
        (
            LevelConfig((TaskConfig("ee_position"),)),
            LevelConfig((TaskConfig("ee_pose", parameters={"gain": 2.0}),)),
            LevelConfig((TaskConfig("posture"),)),
            LevelConfig((TaskConfig("velocity_damping"),)),
        ),
    )
    from lexstack_experiments.loop import Loop
    from support.scenario import resolved

    base = resolved()
    scenario = replace(base.scenario, events=(), initial_stack="wide", name="held")
    run = Loop(replace(base, scenario=scenario, stacks=base.stacks | {"wide": wide}))
    run.run(120)
    return analysed(run)


def test_every_task_has_a_figure_also_posture_and_those_without_an_error_in_mm(held):
    (phase,) = held.metrics.phases
    assert [level.level for level in phase.levels] == [1, 2, 3, 4]
    assert list(phase.levels[2].residual) == ["robot_a/posture", "robot_b/posture"]
    assert phase.levels[0].residual["robot_a/ee_position"] < 1e-6
    assert all(value > 0.01 for value in phase.levels[2].residual.values())
    command = held.run.chi["robot_a"]
    both = np.hypot(*phase.levels[2].residual.values())
    assert both == pytest.approx(np.mean(command.slacks[-50:, 2]), rel=0.02)
    assert phase.posture_error_mrad["robot_a"] > 10.0
    assert any(
        line.startswith(TITLES["posture_error_mrad"]) for line in summary_lines(held.metrics)
    )


def test_a_level_that_a_higher_one_holds_back_is_named(held):
    lines = held_back(held.metrics)
    assert any(
        line.startswith("wide: level 3 (robot_a/posture, robot_b/posture) by level ")
        for line in lines
    ), lines
    assert not any("level 1 (" in line for line in lines)
    assert any(
        line.startswith("level held back: wide: level 3") for line in summary_lines(held.metrics)
    )


def test_nothing_is_said_to_hold_a_level_that_the_command_was_not_solved_for(synthetic):
    """The commands of this bag are made by hand: no level's optimum."""
    run = read_run(synthetic.folder)
    assert held_back(compute_metrics(run, measure(run), find_phases(run))) == []


def test_a_distance_below_zero_is_said_to_be_an_overlap_of_spheres():
    assert TITLES["obstacle_distance_mm"] == "nearest obstacle [mm; below 0: a sphere overlaps it]"


# ---- robots' names and colours


@pytest.fixture(scope="module")
def apart():
    """One of the two robots switches alone."""
    run = loop(transition=TransitionConfig(duration=0.4))
    run.controller.transition.ask("posture_robot_b", 0.0, "", 2)
    run.run(100)
    return analysed(run)


def test_a_phase_of_some_robots_bears_their_names_everywhere(apart):
    title = apart.phases[1].title
    assert title == "posture_robot_b (robot_b)"
    assert any(line.startswith(title) for line in summary_lines(apart.metrics))
    assert f"<b>{title}</b>" in phases_table(apart.metrics)
    assert marks(apart.phases)["annotations"][0]["text"].endswith(f"→ {title}")
    comparison = compare_metrics(apart.metrics, apart.metrics)
    assert any(title in entry.group for entry in comparison.differences)


@pytest.fixture(scope="module")
def report(synthetic, tmp_path_factory):
    patch = pytest.MonkeyPatch()
    patch.setitem(sys.modules, "lexstack_sim.render", None)
    path = tmp_path_factory.mktemp("words") / "report.html"
    run = read_run(synthetic.folder)
    time_series, phases = measure(run), find_phases(run)
    write_report(path, run, time_series, phases, compute_metrics(run, time_series, phases))
    side = Analysis.of(run)
    both = compare_metrics(side.metrics, side.metrics)
    write_comparison(path.with_name("two.html"), (side, side), both)
    patch.undo()
    return path


def hue(color):
    return max(range(3), key=lambda i: color[i])


def test_a_robot_has_one_colour_in_plots_and_in_three_dimensions(report):
    assert (hue(TINTS[0]), hue(TINTS[1])) == (0, 2)  # orange, blue
    found = figures(report)
    for name in ("errors", "computation", "from-above"):
        colors = {}
        for trace in found[name]["data"]:
            robot = re.match(r"robot_[ab]", trace["name"])
            if robot and trace.get("line"):
                colors.setdefault(robot.group(), set()).add(trace["line"]["color"])
        assert colors == {"robot_a": {VERMILLION}, "robot_b": {BLUE}}, name


def test_no_two_joints_of_a_robot_have_one_colour(report):
    data = figures(report)["switch-a"]["data"]
    colors = {t["name"]: t["line"]["color"] for t in data if t["line"]["dash"] == "solid"}
    assert len(colors) == 10
    assert len(set(colors.values())) == 10


BOXES = """[...document.querySelectorAll('.js-plotly-plot')].map((plot) => {
  const box = (e) => { const b = e.getBoundingClientRect();
    return [b.left, b.top, b.right, b.bottom]; };
  return { name: plot.id, plot: box(plot),
    bar: [...plot.querySelectorAll('.modebar-group')].map(box),
    legend: [...plot.querySelectorAll('.legend .traces, .legend .legendtext')].map(box),
    titles: [...plot.querySelectorAll('text[class^=y][class$=title]')].map(box) };
})"""


def overlap(one, other):
    return min(one[2], other[2]) - max(one[0], other[0]) > 1 and (
        min(one[3], other[3]) - max(one[1], other[1]) > 1
    )


@pytest.mark.parametrize("page", ["report.html", "two.html"])
def test_no_legend_lies_under_the_tool_bar_and_no_head_is_cut_off(report, page):
    with Browser() as browser:
        browser.open(report.with_name(page).as_uri())
        browser.wait("document.documentElement.dataset.drawn")
        plots = browser.run(BOXES)
    assert len(plots) >= 2
    for plot in plots:
        assert plot["bar"], plot["name"]
        for bar in plot["bar"]:
            assert not any(overlap(bar, entry) for entry in plot["legend"]), plot["name"]
        left, top, right, bottom = plot["plot"]
        for i, title in enumerate(plot["titles"]):
            assert title[0] >= left - 1, plot["name"]
            assert title[1] >= top - 1, plot["name"]
            assert title[2] <= right + 1, plot["name"]
            assert title[3] <= bottom + 1, plot["name"]
            assert not any(overlap(title, other) for other in plot["titles"][:i]), plot["name"]


def test_the_heads_of_a_printed_comparison_are_whole(synthetic):
    run = read_run(synthetic.folder)
    metrics = compute_metrics(run, measure(run), find_phases(run))
    names = ("runs/2020-transition-sequence-lockstep", "runs/another-name-of-thirty-letters")
    from lexstack_bag.figures.compare import summary_lines as lines

    text = "\n".join(lines(compare_metrics(metrics, metrics, names)))
    assert all(name in text for name in names)


def test_columns_stay_apart_where_errors_are_large(synthetic):
    run = read_run(synthetic.folder)
    metrics = compute_metrics(run, measure(run), find_phases(run))
    large = {"robot_a": 916.19, "robot_b": 1751.23}
    phases = tuple(
        replace(phase, ee_error_mm=large, base_error_mm=large, peak_acceleration_ratio=1234.567)
        for phase in metrics.phases
    )
    rows = [line for line in summary_lines(replace(metrics, phases=phases)) if "1751.23" in line]
    assert len(rows) == 2
    for row in rows:
        assert row.split()[-7:] == [*("916.19", "/", "1751.23") * 2, "1234.567"]
