"""Runs that braked, lost ticks or were reset, and bags with gaps: what the report says of them."""

from __future__ import annotations

import json
import re
import sys
from dataclasses import replace

import numpy as np
import pytest

from lexstack_bag.commands.analyze import analyze
from lexstack_bag.figures.compare import compare_metrics
from lexstack_bag.figures.figures import Analysis, compute_metrics
from lexstack_bag.figures.goals import goals_of, summary_lines
from lexstack_bag.figures.phases import find_phases
from lexstack_bag.figures.series import measure
from lexstack_bag.run.reader import read_parts, read_run
from lexstack_bag.run.run import PlantStatus
from lexstack_bag.run.wholeness import Band, bands_of, wholeness_of
from support.browser import Browser

BRAKES, FOLLOWS = 220, 300  # ticks
FIRST, SECOND = 250, 400  # ticks before a reset, and after it


def metrics_of(run):
    return compute_metrics(run, measure(run), find_phases(run))


def figures(path):
    pattern = r"<script type='application/json' data-figure='([\w-]+)'[^>]*>(.*?)</script>"
    text = path.read_text(encoding="utf-8")
    return {name: json.loads(found) for name, found in re.findall(pattern, text, re.DOTALL)}


@pytest.fixture(autouse=True)
def no_pictures(monkeypatch):
    monkeypatch.setitem(sys.modules, "lexstack_sim.render", None)


# ---- an overloaded run


def overloaded(maker):
    """The plant holds for 20 ticks and then brakes, since commands come too late for it."""

    class Overloaded(maker):
        def plant(self, tick, **fields):
            late = min(max(tick - BRAKES + 20, 0), FOLLOWS - BRAKES + 20)
            status = PlantStatus.FOLLOWING
            if BRAKES - 20 < tick <= FOLLOWS:
                status = PlantStatus.BRAKING if tick > BRAKES else PlantStatus.HOLDING
            super().plant(tick, status=int(status), missing_ticks=late, late_ticks=3 * late)

    return Overloaded


@pytest.fixture(scope="module")
def braked(write, maker, tmp_path_factory):
    return write(tmp_path_factory.mktemp("braked") / "bag", kind=overloaded(maker)).folder


@pytest.fixture(scope="module")
def braked_report(braked, tmp_path_factory):
    out = tmp_path_factory.mktemp("braked-report")
    patch = pytest.MonkeyPatch()
    patch.setitem(sys.modules, "lexstack_sim.render", None)
    analyze(braked, out)
    patch.undo()
    return out / "report.html"


def test_lost_and_late_ticks_are_those_that_the_plant_counted(braked):
    """The bag has a command for all ticks but one: most came too late for their tick."""
    metrics = metrics_of(read_run(braked))
    assert (metrics.missing_ticks, metrics.late_ticks) == (100, 300)
    assert (metrics.holding_ticks, metrics.braking_ticks) == (20, 80)
    assert metrics.commands_not_in_bag == 1
    data = json.loads(metrics.to_json())
    assert (data["missing_ticks"], data["braking_ticks"]) == (100, 80)


def test_real_robots_that_are_braked_at_the_end_of_the_scenario_have_not_failed(braked):
    run = read_run(braked)
    for last, ticks in ((BRAKES, 0), (BRAKES + 30, 30)):
        scenario = replace(run.resolved.scenario, duration=last * run.period)
        shorter = replace(run, resolved=replace(run.resolved, scenario=scenario))
        assert wholeness_of(shorter).braking_ticks == ticks


def test_no_goal_is_reached_in_a_run_that_braked(braked, synthetic):
    before = {
        goal.quantity: goal.verdict for goal in goals_of(metrics_of(read_run(synthetic.folder)))
    }
    assert before["Base error after (A)"] == "reached"
    metrics = metrics_of(read_run(braked))
    verdicts = {goal.quantity: goal.verdict for goal in goals_of(metrics)}
    assert "reached" not in verdicts.values()
    assert verdicts["Base error after (A)"] == "not judged"
    assert verdicts["End-effector error after (A)"] == "not reached"  # that is certain
    text = "\n".join(summary_lines(metrics))
    assert "not judged: the plant braked during 80 ticks" in text
    assert "not judged: the plant got no command in time in 100 ticks" in text


def test_a_lost_command_keeps_goals_about_every_tick_from_being_reached(synthetic):
    verdicts = {goal.quantity: goal for goal in goals_of(metrics_of(read_run(synthetic.folder)))}
    peak = verdicts["Peak acceleration of the command / limit"]
    assert (peak.value < 1.0, peak.verdict) == (True, "not judged")


def test_bands_begin_with_the_tick_that_was_not_followed(braked):
    holding, braking = bands_of(read_run(braked))
    assert holding == Band("holding", pytest.approx(2.0), pytest.approx(2.2))
    assert braking == Band("braking", pytest.approx(2.2), pytest.approx(3.0))


def test_braking_is_a_band_in_every_plot_over_time(braked_report):
    found = figures(braked_report)
    assert len(found) == 9
    for name, figure in found.items():
        shapes = figure["layout"].get("shapes", [])
        bands = [s for s in shapes if s["type"] == "rect" and s["name"] == "plant braking"]
        across = [
            key
            for key, axis in figure["layout"].items()
            if key.startswith("xaxis") and axis["title"]["text"] == "simulated time [s]"
        ]
        assert len(bands) == len(across) == {"from-above": 0, "switch-a": 2}.get(name, 1), name
        for band in bands:
            assert (band["x0"], band["x1"]) == (pytest.approx(2.2), pytest.approx(3.0))
            assert (band["y0"], band["y1"], band["yref"]) == (0, 1, "paper")
        assert sum(band["showlegend"] for band in bands) == bool(bands), name


def test_the_page_of_a_run_that_braked_says_so_before_any_figure(braked_report):
    text = braked_report.read_text(encoding="utf-8")
    head = text.partition("<main")[0]
    assert "No goal is called reached: the plant braked during 80 ticks" in head
    assert '<span class="yes">reached</span>' not in text
    assert '<span class="none">not judged</span>' in text


def test_bands_are_seen_in_a_browser(braked_report):
    with Browser() as page:
        page.open(braked_report.as_uri())
        page.wait("document.documentElement.dataset.drawn")
        image = page.picture("#errors .plotly")
        red, _, blue = (image[..., i].astype(int) for i in range(3))
        tinted = (red - blue > 30) & (red > 230)
        assert tinted.mean() > 0.1
        assert page.messages == []


def test_a_comparison_shows_the_bands_of_both_and_says_what_was_wrong(braked, synthetic, tmp_path):
    from lexstack_bag.report.comparison import write_comparison

    sides, metrics = [], []
    for folder in (synthetic.folder, braked):
        run = read_run(folder)
        sides.append(Analysis.of(run))
        metrics.append(sides[-1].metrics)
    path = tmp_path / "comparison.html"
    write_comparison(path, tuple(sides), compare_metrics(*metrics))
    for figure in figures(path).values():
        bands = [s for s in figure["layout"]["shapes"] if s.get("name", "").startswith("plant br")]
        assert [band["name"] for band in bands] == ["plant braking, second"]
        assert bands[0]["x0"] == pytest.approx(1.2)  # from the switch at 1 s on
    assert "Second run: the plant braked during 80 ticks" in path.read_text(encoding="utf-8")


# ---- a bag with holes


@pytest.fixture(scope="module")
def holed(write, maker, tmp_path_factory):
    class Holed(maker):
        def plant(self, tick, **fields):
            if tick % 7 != 6:
                super().plant(tick, **fields)

    return write(tmp_path_factory.mktemp("holed") / "bag", kind=Holed).folder


def test_settling_is_measured_in_time_and_not_in_rows(holed):
    """Every 7th state is not there: the 87 rows before it settles are 1 s as before."""
    metrics = metrics_of(read_run(holed))
    assert metrics.phases[1].settled_s == pytest.approx(1.0)


def test_gaps_in_the_states_are_told(holed):
    metrics = metrics_of(read_run(holed))
    assert (metrics.states_not_in_bag, metrics.longest_gap_s) == (57, pytest.approx(0.02))
    assert (
        "the states of 57 ticks are not in the bag (the longest gap lasts 0.02 s)" in metrics.gaps
    )
    assert any(line.startswith("gap: the states of 57") for line in summary_lines(metrics))


def test_a_phase_that_never_settles_is_told_apart_from_one_without_errors(synthetic):
    from dataclasses import replace

    metrics = metrics_of(read_run(synthetic.folder))
    never = replace(metrics.phases[0], settled_s=None)
    no_task = replace(never, has_errors=False)
    lines = summary_lines(replace(metrics, phases=(never, no_task)))
    rows = [line.split() for line in lines if line.startswith("track")]
    assert [row[2] for row in rows] == ["never", "–"]


# ---- a bag with a reset


@pytest.fixture(scope="module")
def reset(write, maker, tmp_path_factory):
    """A run of FIRST ticks, then a reset, then the whole run; its answers lag behind the reset."""

    class Reset(maker):
        resets = 0

        def plant(self, tick, **fields):
            super().plant(tick, resets=self.resets, **fields)

        def tick(self, tick):
            if tick == 0:
                for early in range(FIRST):
                    super().tick(early)
                self.resets = 1
            super().tick(tick)

        def solutions(self, tick):
            if tick == 0 and self.resets:  # the controller did not know of the reset yet
                self.solution("robot_a", FIRST, solve_time=1.0)
            super().solutions(tick)

    return write(tmp_path_factory.mktemp("reset") / "bag", kind=Reset).folder


def test_a_reset_begins_a_part_and_nothing_is_dropped(reset):
    first, second = read_parts(reset)
    assert (first.part, second.part) == (1, 2)
    assert [len(run.plant.tick) for run in (first, second)] == [FIRST, SECOND]
    assert [part.states for part in second.parts] == [FIRST, SECOND]
    assert np.array_equal(first.plant.tick, np.arange(FIRST))
    assert first.chi["robot_a"].tick[-1] == FIRST - 1
    assert second.chi["robot_a"].tick.tolist() == [t for t in range(SECOND) if t != 300]
    assert first.transition.tick[-1] == FIRST - 1
    assert second.transition.tick.tolist() == list(range(SECOND))
    total = read_run(reset).messages["/plant/state"] + first.messages["/plant/state"]
    assert total == FIRST + SECOND


def test_a_run_without_a_reset_is_one_part(synthetic):
    (run,) = read_parts(synthetic.folder)
    assert (run.part, run.parts) == (1, ())


def test_a_reset_whose_first_states_are_lost_is_noticed_by_its_count(write, maker, tmp_path):
    """The ticks only go up, but the plant says that it was reset in between."""

    class Late(maker):
        def plant(self, tick, **fields):
            if not 200 <= tick < 250:
                super().plant(tick, resets=int(tick >= 250), **fields)

    parts = read_parts(write(tmp_path / "bag", kind=Late).folder)
    assert [run.plant.tick[0] for run in parts] == [0, 250]


def test_each_part_has_its_own_figures_and_says_what_is_not_in_them(reset, tmp_path):
    lines = []
    metrics = analyze(reset, tmp_path, lines.append)
    assert any("2 parts, part 1: 250 states, part 2: 400 states" in line for line in lines)
    assert (metrics.part, metrics.ticks) == (2, SECOND)
    assert metrics.phases[1].start_s == pytest.approx(1.0)
    assert len(metrics.phases) == 2  # those of part 1 are not among them
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "part 2 of 2 alone; not in its figures are part 1: 250 states, 0.00 to 2.49 s" in page
    first = json.loads((tmp_path / "part-1" / "metrics.json").read_text(encoding="utf-8"))
    assert (first["part"], first["ticks"]) == (1, FIRST)
    assert [part["states"] for part in first["parts"]] == [FIRST, SECOND]
    assert (tmp_path / "part-1" / "report.html").is_file()


def test_no_goal_is_reached_in_a_run_that_was_reset(reset):
    metrics = metrics_of(read_run(reset))
    assert "reached" not in {goal.verdict for goal in goals_of(metrics)}
    assert metrics.doubts == ("the plant was reset: this is part 2 of 2 of the bag",)


def test_counters_of_the_plant_go_on_over_a_reset(write, maker, tmp_path):
    class Counting(maker):
        def plant(self, tick, **fields):
            again = tick >= 200
            moved = {"tick": tick - 200, "stamp": (tick - 200) / 100.0} if again else {}
            missing = 7 if tick >= 100 else 0
            missing += 2 if tick > 250 else 0
            self.put(
                "/plant/state",
                "lexstack_interfaces/msg/PlantState",
                **(self.state(tick) | {"resets": int(again), "missing_ticks": missing} | moved),
            )

    first, second = read_parts(write(tmp_path / "bag", kind=Counting).folder)
    assert (metrics_of(first).missing_ticks, metrics_of(second).missing_ticks) == (7, 2)


def test_a_state_of_a_stranger_begins_no_part(write, maker, tmp_path):
    """Anybody may send on /plant/state; nodes refuse such states, and so does the analysis."""

    class Visited(maker):
        def plant(self, tick, **fields):
            super().plant(tick, **fields)
            if tick in (120, 121, 300):
                super().plant(0, sender="other@host/1/0", resets=7, status=2)

    (run,) = read_parts(write(tmp_path / "bag", kind=Visited).folder)
    assert np.array_equal(run.plant.tick, np.arange(400))
    assert (run.part, run.parts) == (1, ())
    assert len(run.transition.tick) == 400
    assert metrics_of(run).braking_ticks == 0


def test_a_simulation_that_was_started_again_begins_a_part(write, maker, tmp_path):
    class Again(maker):
        def plant(self, tick, **fields):
            super().plant(tick, sender=f"plant@host/{1 + (tick >= 150)}/0", **fields)

    parts = read_parts(write(tmp_path / "bag", kind=Again).folder)
    assert [len(run.plant.tick) for run in parts] == [150, 250]
