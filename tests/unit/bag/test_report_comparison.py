"""The page of two runs: figures side by side, traces over each other from the switches on."""

from __future__ import annotations

import base64
import dataclasses
import json
import re

import numpy as np
import pytest

from lexstack_bag.figures.compare import compare_metrics
from lexstack_bag.figures.figures import Analysis, compute_metrics
from lexstack_bag.figures.phases import find_phases
from lexstack_bag.report.comparison import write_comparison
from lexstack_bag.run.reader import read_run
from support.browser import Browser

LATER = 0.4  # s, by which the second run's trigger is later


def side(run):
    return Analysis.of(run)


def later(run):
    """The same run with everything but the plant LATER, and a command twice as fast."""
    status, chi = run.transition, run.chi["robot_a"]
    ticks = round(LATER * 100)
    return dataclasses.replace(
        run,
        transition=dataclasses.replace(
            status, tick=status.tick + ticks, stamp=status.stamp + LATER
        ),
        chi=run.chi
        | {
            "robot_a": dataclasses.replace(
                chi, tick=chi.tick + ticks, stamp=chi.stamp + LATER, chi=2 * chi.chi
            )
        },
    )


def page_of(first, second, path):
    sides = side(first), side(second)
    metrics = [compute_metrics(s.run, s.time_series, s.phases) for s in sides]
    write_comparison(path, sides, compare_metrics(*metrics, ("one", "<other>")))
    return path


@pytest.fixture(scope="module")
def path(synthetic, tmp_path_factory):
    run = read_run(synthetic.folder)
    return page_of(run, later(run), tmp_path_factory.mktemp("two") / "comparison.html")


def figures(path):
    pattern = r"<script type='application/json' data-figure='([\w-]+)'[^>]*>(.*?)</script>"
    text = path.read_text(encoding="utf-8")
    return {name: json.loads(found) for name, found in re.findall(pattern, text, re.DOTALL)}


def values(trace):
    y = np.frombuffer(base64.b64decode(trace["y"]["bdata"]), "<f4")
    return trace["x0"] + trace["dx"] * np.arange(len(y)), y


def test_traces_are_aligned_at_the_switch(path):
    traces = {t["name"]: t for t in figures(path)["switch-1"]["data"]}
    curves = [values(traces[f"α, {which}"]) for which in ("first", "second")]
    for time, alpha in curves:
        begins = time[np.flatnonzero(alpha[time >= 0] > 0.005)[0] + np.argmax(time >= 0)]
        assert begins == pytest.approx(0.01, abs=0.011)
    assert np.allclose(np.interp(0.5, *curves[0]), np.interp(0.5, *curves[1]), atol=1e-6)


def test_the_runs_differ_in_style_and_carry_units(path):
    data = figures(path)["switch-1"]["data"]
    assert {t["line"]["dash"] for t in data if "first" in t["name"]} == {"solid"}
    assert {t["line"]["dash"] for t in data if "second" in t["name"]} == {"dash"}
    errors = [t for t in data if t["yaxis"] == "y"]
    assert len(errors) == 4
    assert all(t["hovertemplate"].endswith(" mm") for t in errors)


def test_both_commands_are_there_for_every_joint(path):
    traces = figures(path)["commands"]["data"]
    assert len(traces) == 2 * 20
    first, second = (values(t)[1] for t in traces[26:28])
    assert np.nanmax(second) == pytest.approx(2 * np.nanmax(first))
    assert np.nanmax(first) > 0


def test_what_differs_stands_in_the_table(path):
    text = path.read_text(encoding="utf-8")
    rows = [re.findall(r"<td>(.*?)</td>", row) for row in re.findall(r"<tr>(.*?)</tr>", text)]
    row = next(r for r in rows if r[:2] == ["run", "peak acceleration ratio"])
    assert float(row[4]) == pytest.approx(2 * float(row[3]), rel=1e-3)
    assert row[6:] == ["+100.0 %", "the first"]
    assert "&lt;other&gt;" in text
    assert "<other>" not in text


def test_equal_runs_have_no_difference(synthetic, tmp_path):
    run = read_run(synthetic.folder)
    text = page_of(run, run, tmp_path / "same.html").read_text(encoding="utf-8")
    assert "<p>None.</p>" in text
    assert "messages: 0 of" in text


def test_a_run_without_a_switch_can_be_compared(synthetic, plant_alone, tmp_path):
    path = page_of(
        read_run(synthetic.folder), read_run(plant_alone.folder), tmp_path / "alone.html"
    )
    found = figures(path)
    assert list(found) == ["switch-1", "commands"]
    assert "Only one of the runs" in path.read_text(encoding="utf-8")


def test_the_page_opens_in_a_browser(path):
    with Browser() as page:
        page.open(path.as_uri())
        page.wait("document.documentElement.dataset.drawn")
        assert page.run("document.querySelectorAll('.js-plotly-plot').length") == 2
        assert page.messages == []


def two_channels(run):
    """The same run with a message for each robot: of robot_b another alpha."""
    status = run.transition

    def twice(name):
        values = getattr(status, name)
        if name == "robots":
            return np.array(["robot_a", "robot_b"] * len(status.tick), dtype=object)
        other = np.full_like(values, 0.125) if name == "alpha" else values
        return np.stack((values, other), axis=1).reshape(-1)

    fields = [field.name for field in dataclasses.fields(status)]
    status = dataclasses.replace(status, **{name: twice(name) for name in fields})
    return dataclasses.replace(run, transition=status)


def test_of_several_transitions_at_once_a_switch_shows_its_own(synthetic, tmp_path):
    run = two_channels(read_run(synthetic.folder))
    phases = find_phases(run)
    assert phases[1].robots == ("robot_a",)
    page = page_of(run, run, tmp_path / "comparison.html")
    alpha = next(t for t in figures(page)["switch-1"]["data"] if t["name"] == "α, first")
    drawn = np.frombuffer(base64.b64decode(alpha["y"]["bdata"]), "<f4")
    assert drawn[np.isfinite(drawn)].max() == 1.0
    assert not (drawn == 0.125).any()
