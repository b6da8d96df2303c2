"""The report: one file that loads nothing, with every figure in it."""

from __future__ import annotations

import base64
import json
import re
import subprocess
import sys

import numpy as np
import pytest

from lexstack_bag.commands.analyze import analyze
from lexstack_bag.report import pictures

MEGABYTE = 1_000_000


@pytest.fixture(scope="module")
def out(synthetic, tmp_path_factory):
    folder = tmp_path_factory.mktemp("out")
    patch = pytest.MonkeyPatch()
    # Without a graphics driver, as on many machines.
    patch.setitem(sys.modules, "lexstack_sim.render", None)
    analyze(synthetic.folder, folder)
    patch.undo()
    return folder


@pytest.fixture(scope="module")
def html(out):
    return (out / "report.html").read_text(encoding="utf-8")


def figures(html: str) -> dict[str, dict]:
    pattern = r"<script type='application/json' data-figure='([\w-]+)'[^>]*>(.*?)</script>"
    return {name: json.loads(text) for name, text in re.findall(pattern, html, re.DOTALL)}


def values(trace: dict) -> np.ndarray:
    assert trace["y"]["dtype"] == "f4"
    return np.frombuffer(base64.b64decode(trace["y"]["bdata"]), "<f4")


def test_every_figure_is_there(html):
    found = figures(html)
    assert list(found) == [
        "timeline",
        "poses",
        "errors",
        "from-above",
        "switch-a",
        "computation",
        "levels",
        "smoothness",
        "bounds",
    ]
    assert html.count("<h2>") == 5 + len(found) + 1
    for name in found:
        assert f"<div id='{name}'" in html


def test_every_axis_at_the_edge_has_a_title_with_a_unit(html):
    for name, figure in figures(html).items():
        for key, axis in figure["layout"].items():
            if key.startswith("yaxis") and name != "timeline":
                assert re.search(r"\[.+\]", axis["title"]["text"])
        across = [a for k, a in figure["layout"].items() if k.startswith("xaxis")]
        title = "x [m]" if name == "from-above" else "simulated time [s]"
        assert any(axis["title"]["text"] == title for axis in across)


def test_what_is_shown_under_the_pointer_has_a_unit(html):
    for name, figure in figures(html).items():
        for trace in figure["data"]:
            if trace["name"] != "α" and name != "smoothness":
                assert re.search(
                    r"\} (mm|m|ms|s|m/s|rad/s|rad|m/s, rad/s)$", trace["hovertemplate"]
                )


def test_lines_of_one_plot_differ_in_colour_or_style(html):
    for figure in figures(html).values():
        lines = [t for t in figure["data"] if t.get("mode") == "lines" and t.get("visible", True)]
        seen = {(t.get("yaxis"), t["line"]["color"], t["line"]["dash"]) for t in lines}
        bounds = sum("bound" in t["name"] for t in lines)  # the two edges of one area
        assert len(seen) == len(lines) - bounds // 2


def test_switches_are_marked_with_their_stack(html):
    layout = figures(html)["poses"]["layout"]
    assert [shape["x0"] for shape in layout["shapes"]] == [1.0]
    assert layout["annotations"][0]["text"] == "<b>(A)</b> → reach_base"


def test_the_gap_in_the_command_shows(html):
    command = next(t for t in figures(html)["bounds"]["data"] if t["name"] == "command")
    assert (command["x0"], command["dx"]) == (0.0, 0.01)
    y = values(command)
    assert np.flatnonzero(np.isnan(y)).tolist() == [300]
    assert y[50] == pytest.approx(0.03)


def test_one_joint_of_all_is_shown(html):
    traces = figures(html)["bounds"]["data"]
    assert len(traces) == 4 * 20
    assert [trace["visible"] for trace in traces] == [True] * 4 + [False] * 76
    assert html.count("<option>") == 20


def test_the_source_is_dashed_and_ends_with_the_blend(html):
    traces = figures(html)["switch-a"]["data"]
    dashed = [trace for trace in traces if trace["line"]["dash"] == "dash"]
    assert len(dashed) == 20
    times = dashed[0]["x0"] + dashed[0]["dx"] * np.flatnonzero(~np.isnan(values(dashed[0])))
    assert times[0] == pytest.approx(1.0)
    assert times[-1] == pytest.approx(1.99)


def test_it_loads_nothing(html):
    own = re.sub(r"<script type='text/plain' id='plotly'>.*?</script>", "", html, flags=re.DOTALL)
    assert len(own) < len(html) - MEGABYTE
    own = re.sub(
        r"<script nonce=\"[^\"]+\">/\*\*\n \* @license\n[^<]*Three.js Authors.*?</script>",
        "",
        own,
        flags=re.DOTALL,
    )
    assert not re.findall(r"https?://", own)
    assert "default-src 'none'" in own
    assert not re.findall(r"<(?:link|iframe|object)|@import|<script[^>]*\ssrc=", html)


def test_it_is_not_too_large(out):
    assert (out / "report.html").stat().st_size < 5 * MEGABYTE


def test_goals_are_computed(html):
    # EE 5 mm and base 2 mm after (A): the first misses our goal, the second does not.
    row = re.findall(r"<tr><td>([^<]*)</td><td>([^<]*)</td>.*?class=\"(\w+)\"", html)
    words = {name: word for name, _, word in row}
    assert words["End-effector error after (A)"] == "no"
    assert words["Base error after (A)"] == "yes"
    assert words["Ticks with an empty box of bounds"] == "no"
    assert words["Switches not adopted, of 1"] == "yes"


def test_without_pictures_it_says_why(html):
    assert "No pictures: " in html
    assert "lexstack_sim.render" in html


def test_pictures_are_embedded(synthetic, monkeypatch):
    from types import SimpleNamespace

    from lexstack_bag.figures.phases import find_phases
    from lexstack_bag.figures.series import measure
    from lexstack_bag.run.reader import read_run

    asked = []

    def snapshots(resolved, qs, targets, stamps):
        asked.extend(qs)
        assert stamps == pytest.approx([1.0, 3.99])
        assert all(list(by_robot) == ["robot_a", "robot_b"] for by_robot in targets)
        return [np.zeros((4, 6, 3), np.uint8) for _ in qs]

    monkeypatch.setitem(sys.modules, "lexstack_sim.render", SimpleNamespace(snapshots=snapshots))
    run = read_run(synthetic.folder)
    shots, reason = pictures.pictures(run, measure(run), find_phases(run))
    assert reason == ""
    assert len(shots) == 2
    assert shots[0].caption.startswith("<b>(A)</b> 1.00 s")
    assert all(shot.uri.startswith("data:image/jpeg;base64,/9j/") for shot in shots)
    assert np.array_equal(asked[0], run.plant.q[100])
    assert np.array_equal(asked[1], run.plant.q[399])


def command(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "lexstack_bag.commands.analyze", *arguments],
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )


def test_the_command_prints_the_tables(synthetic, tmp_path):
    done = command(str(synthetic.folder.parent), "--out", str(tmp_path / "new"))
    assert done.returncode == 0, done.stderr
    assert "read 1" in done.stdout
    assert re.search(r"Base error after \(A\) +< 50 mm +≤ 5 mm +2 mm +reached", done.stdout)
    assert json.loads((tmp_path / "new" / "metrics.json").read_text())["recorder_lost"] == 3
    assert (tmp_path / "new" / "report.html").is_file()


@pytest.mark.parametrize("arguments", [["nowhere"], []])
def test_a_bad_argument_ends_with_2(arguments):
    done = command(*arguments)
    assert done.returncode == 2
    assert "Traceback" not in done.stderr


def test_help():
    done = command("--help")
    assert done.returncode == 0
    assert "report.html" in done.stdout


def test_a_run_without_a_command_is_analysed_as_well(plant_alone, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "lexstack_sim.render", None)
    metrics = analyze(plant_alone.folder, tmp_path)
    assert metrics.ticks == 0
    assert metrics.peak_acceleration_ratio is None
    assert [phase.stack for phase in metrics.phases] == ["track"]
    assert metrics.solve_us["robot_a"] == {"median": None, "p99": None}
    assert len(figures((tmp_path / "report.html").read_text(encoding="utf-8"))) == 7
