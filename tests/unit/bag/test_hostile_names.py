"""Names and words in a bag that try to become a part of the page: in every field that is shown."""

from __future__ import annotations

import json
import re
import sys
from dataclasses import replace

import numpy as np
import pytest

from lexstack_bag.commands.analyze import analyze, compare, main
from lexstack_bag.figures.figures import compute_metrics
from lexstack_bag.figures.phases import find_phases
from lexstack_bag.figures.series import measure
from lexstack_bag.report.build import write_report
from lexstack_bag.report.page import document
from lexstack_bag.run.provenance import run_provenance
from lexstack_bag.run.reader import read_run
from support.browser import Browser
from support.hostile import ALL, IMAGE, assert_harmless, shown

FIELDS = ("from_stack", "to_stack", "source", "method", "reason")


def hostile_kind(maker):
    """A run whose messages say ALL in every text of theirs, each with the field's name behind."""

    class Hostile(maker):
        def transition(self, tick, **fields):
            words = {name: ALL + name for name in FIELDS}
            robots = ["robot_a", "robot_b" if tick < 250 else ALL + "robot"]
            number = 1 + (tick >= 250)
            super().transition(tick, id=number, robots=robots, **words)

        def solution(self, robot, tick, **fields):
            super().solution(robot, tick, **(fields | {"stack": ALL + "stack", "reason": ALL}))

        def tick(self, tick):
            super().tick(tick)
            if tick % 20 == 0:
                self.progress(tick)
            if tick == 0:
                self.sequence()
                self.put("/" + ALL + "topic", "std_msgs/msg/String", data=ALL)

        def progress(self, tick):
            self.put(
                "/htmpc/status",
                "lexstack_interfaces/msg/SequenceStatus",
                stamp=tick / 100,
                tick=tick,
                robot="robot_a",
                architecture=ALL + "architecture",
                index=0,
                count=2,
                task=ALL + "task",
                error=0.1,
                error_angle=0.0,
                window=[ALL],
                errors=np.array([0.1]),
                levels=[ALL],
                solved=True,
                solve_time=0.004,
            )

        def sequence(self):
            kind = "lexstack_interfaces/msg/Sequence"
            types = self.messages.store(kind).types
            point = types["geometry_msgs/msg/Point"](1.0, 0.5, 0.0)
            turn = types["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0)
            pose = types["geometry_msgs/msg/Pose"](point, turn)
            task = types["lexstack_interfaces/msg/SequenceTask"](
                ALL + "goal",
                "ee_position",
                ALL,
                [],
                [pose],
                np.zeros(0),
                0.0,
                0.0,
                0.02,
                0.1,
                0.0,
                False,
            )
            self.put(
                "/htmpc/sequence",
                kind,
                stamp=0.0,
                tick=0,
                robot="robot_a",
                architecture="ht",
                event="begin",
                changed=ALL,
                tasks=[task],
                coordinates=np.array([1.0, 0.5, 0.0]),
                index=0,
                released=[ALL],
            )

    return Hostile


@pytest.fixture(scope="module")
def bag(write, maker, resolved, tmp_path_factory):
    """The bag; what stands in its metadata and the file's name are hostile as well."""
    folder = tmp_path_factory.mktemp("hostile") / "bag"
    facts = {
        key: value + ALL for key, value in run_provenance(resolved).items() if key != "scenario"
    }
    told = replace(resolved, scenario=replace(resolved.scenario, description=ALL + "description"))
    facts["scenario"] = told.to_yaml()
    made = write(folder, kind=hostile_kind(maker), facts=facts)
    file = next(made.folder.glob("*.mcap"))
    return file.rename(file.with_name(f"{IMAGE}.mcap"))


@pytest.fixture(scope="module")
def out(bag, tmp_path_factory):
    folder = tmp_path_factory.mktemp("hostile-report")
    patch = pytest.MonkeyPatch()
    patch.setitem(sys.modules, "lexstack_sim.render", None)
    analyze(bag, folder)
    compare(bag, bag, folder, lambda _line: None)
    patch.undo()
    return folder


def looked_at(path):
    """Open a page, its folded parts as well, and point at its plots."""
    page = Browser()
    page.open(path.as_uri())
    page.wait("document.documentElement.dataset.drawn")
    page.run("document.querySelectorAll('details').forEach(d => { d.open = true; })")
    page.run("document.querySelectorAll('#view3d-marks button').forEach(b => b.click())")
    return page


def test_the_report_of_a_hostile_bag_shows_its_names_and_runs_none(out):
    with looked_at(out / "report.html") as page:
        assert_harmless(page)
        for what in ("to_stack", "stack", "topic", "description", "task"):
            assert shown(page, ALL + what), what
        assert shown(page, f"{IMAGE}.mcap")
        legends = page.run("[...document.querySelectorAll('.js-plotly-plot')].length")
        assert legends > 8
        assert page.run("document.getElementById('view3d-label').textContent").find("<img") > 0


def test_texts_in_plots_are_drawn_as_they_are(out):
    with looked_at(out / "report.html") as page:
        drawn = page.run(
            "[...document.querySelectorAll('#poses .annotation-text')].map(t => t.textContent)"
        )
        assert any(ALL.replace("\n", " ") in text for text in drawn), drawn


def test_the_comparison_of_hostile_bags_runs_none_of_their_names(out):
    with looked_at(out / "comparison.html") as page:
        assert_harmless(page)
        for what in ("to_stack", "topic"):
            assert shown(page, ALL + what), what
        assert shown(page, f"{IMAGE}.mcap")


def test_names_of_robots_and_of_the_scenario_are_escaped_too(synthetic, tmp_path, monkeypatch):
    """The configuration allows no such names, but a page shall not rely on that."""
    monkeypatch.setitem(sys.modules, "lexstack_sim.render", None)
    run = read_run(synthetic.folder)
    scenario = run.resolved.scenario
    robots = {f"{name}{ALL}": place for name, place in scenario.robots.items()}
    scenario = replace(scenario, name=f"name{ALL}", robots=robots)
    run = replace(run, resolved=replace(run.resolved, scenario=scenario), targets=())
    time_series, phases = measure(run), find_phases(run)
    path = tmp_path / "report.html"
    write_report(path, run, time_series, phases, compute_metrics(run, time_series, phases))
    with looked_at(path) as page:
        assert_harmless(page)
        for name in (*robots, f"name{ALL}"):
            assert shown(page, name), name


def test_an_inline_script_does_not_run_even_if_it_gets_into_a_page(tmp_path):
    path = tmp_path / "page.html"
    path.write_text(document("t", f"<p>{IMAGE}</p><script>window.hacked=2</script>"))
    with Browser() as page:
        page.open(path.as_uri())
        page.wait("document.readyState === 'complete'")
        assert page.run("window.hacked") is None
        refused = [text for text in page.messages if "Content Security Policy" in text]
        assert len(refused) >= 2


def test_every_page_has_a_nonce_of_its_own_and_allows_no_other_script():
    policies = [re.search(r'Policy" content="([^"]+)"', document("t", "b")) for _ in range(2)]
    rules = [dict(r.split(" ", 1) for r in found.group(1).split("; ")) for found in policies]
    assert all(re.fullmatch(r"'nonce-[\w-]{24}'", rule["script-src"]) for rule in rules)
    assert rules[0]["script-src"] != rules[1]["script-src"]


def test_data_for_scripts_cannot_end_their_element(out):
    text = (out / "report.html").read_text(encoding="utf-8")
    blocks = re.findall(r"<script type='application/json'[^>]*>(.*?)</script>", text, re.DOTALL)
    assert len(blocks) > 10
    for block in blocks:
        assert "<" not in block
        json.loads(block)


def test_names_do_not_steer_the_terminal(write, maker, tmp_path, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "lexstack_sim.render", None)

    class Steering(maker):
        def transition(self, tick, **fields):
            super().transition(tick, to_stack="\x1b[2Jgone\r\x07", **fields)

    made = write(tmp_path / "bag", kind=Steering)
    assert main([str(made.folder), "--out", str(tmp_path)]) == 0
    assert main([str(made.folder), str(made.folder), "--out", str(tmp_path)]) == 0
    said = "".join(capsys.readouterr())
    assert "?[2Jgone??" in said
    assert not set(said) & set("\x1b\r\x07")
