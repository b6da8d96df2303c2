"""The report in a browser: what a person would see, looked at in pixels and in positions."""

from __future__ import annotations

import base64
import dataclasses
import sys

import numpy as np
import pytest

from lexstack_bag.figures.figures import compute_metrics
from lexstack_bag.figures.phases import find_phases
from lexstack_bag.figures.series import measure
from lexstack_bag.report.build import write_report
from lexstack_bag.run.reader import read_run
from support.browser import Browser

GROUND = np.array([0xEE, 0xF1, 0xF4])  # what is behind the robots
MINUTE = 6000  # ticks


def stretched(run, ticks):
    """The run's plant for as many ticks: the robots go round in it, and all else stays."""
    plant = run.plant
    tick = np.arange(ticks)
    angle = 2 * np.pi * tick / ticks
    q = np.repeat(plant.q[:1], ticks, axis=0)
    q[:, 0] += 0.3 * np.sin(angle)
    q[:, 2] += 0.5 * np.sin(angle)
    q[:, 3:10] += 0.2 * np.sin(np.outer(angle, np.arange(1, 8)))
    q[:, 11] += 0.4 * (1 - np.cos(angle))
    q[:, 13:20] -= 0.2 * np.sin(np.outer(angle, np.arange(1, 8)))
    rows = {
        field.name: np.resize(getattr(plant, field.name), (ticks, *value.shape[1:]))
        for field in dataclasses.fields(plant)
        if (value := getattr(plant, field.name)) is not None
    }
    chi = run.chi["robot_a"]
    columns = {
        field.name: np.resize(value, (ticks, *value.shape[1:]))
        for field in dataclasses.fields(chi)
        if (value := np.asarray(getattr(chi, field.name))) is not None
    }
    stamps = {"tick": tick, "stamp": tick / 100.0}
    return dataclasses.replace(
        run,
        plant=dataclasses.replace(plant, **(rows | stamps | {"q": q})),
        chi=run.chi | {"robot_a": dataclasses.replace(chi, **(columns | stamps))},
    )


@pytest.fixture(scope="module")
def minute(synthetic):
    return stretched(read_run(synthetic.folder), MINUTE)


@pytest.fixture(scope="module")
def report(minute, tmp_path_factory):
    patch = pytest.MonkeyPatch()
    patch.setitem(sys.modules, "lexstack_sim.render", None)
    path = tmp_path_factory.mktemp("minute") / "report.html"
    time_series, phases = measure(minute), find_phases(minute)
    write_report(path, minute, time_series, phases, compute_metrics(minute, time_series, phases))
    patch.undo()
    return path


@pytest.fixture(scope="module")
def page(report):
    with Browser() as browser:
        browser.open(report.as_uri())
        browser.wait("document.documentElement.dataset.drawn")
        yield browser
        assert browser.messages == []


def is_orange(image):
    red, green, blue = (image[..., i].astype(int) for i in range(3))
    return (red > 130) & (green < 0.65 * red) & (blue < 0.4 * red)


def is_blue(image):
    red, green, blue = (image[..., i].astype(int) for i in range(3))
    return (blue > 110) & (red < 0.45 * blue) & (green < 0.75 * blue)


def show(page, seconds):
    page.run(f"LexstackPlayer.show({seconds})")
    return page.picture("#view3d")


def projected(page, point):
    return page.run(f"LexstackPlayer.view.project({np.asarray(point).tolist()})")


def joints(run, row):
    """Where pinocchio says that the moving joints are, in the order of q, shape (n, 3)."""
    import pinocchio as pin

    points = []
    team = run.team()
    for robot, part in zip(team.robots, team.slices, strict=True):
        data = robot.pinocchio.createData()
        pin.forwardKinematics(robot.pinocchio, data, run.plant.q[row, part])
        points += [data.oMi[i].translation.copy() for i in range(1, robot.pinocchio.njoints)]
    return np.array(points)


def is_soon(times):
    return max(float(times["opened"]), float(times["viewed"])) < 2000  # ms


def test_it_opens_in_two_seconds_and_is_small(page, report):
    opened = [page.run("({...document.documentElement.dataset})")]
    # Shown with its tables and its 3-D view, without a graphics card. Others may have the machine
    # at one moment: the best of three counts.
    while not is_soon(opened[-1]) and len(opened) < 3:
        with Browser() as browser:
            browser.open(report.as_uri())
            browser.wait("document.documentElement.dataset.drawn")
            opened.append(browser.run("({...document.documentElement.dataset})"))
    assert is_soon(opened[-1]), opened
    assert report.stat().st_size < 10_000_000


@pytest.mark.parametrize("seconds", [0.0, 14.37, 30.0, 59.99])
def test_the_view_has_every_joint_where_the_model_has_it(page, minute, seconds):
    page.run(f"LexstackPlayer.show({seconds})")
    seen = page.run(
        "LexstackPlayer.view.joints.sort((a, b) => a.index - b.index).map((joint) => "
        "joint.node.getWorldPosition(new THREE.Vector3()).toArray())"
    )
    expected = joints(minute, round(100 * seconds))
    moved = [i for i in range(20) if i % 10 >= 2]  # x and y slide: their node is on its way
    assert np.allclose(np.array(seen)[moved], expected[moved], atol=2e-5)


@pytest.mark.parametrize("seconds", [0.0, 0.49, 0.5, 1.99, 2.0, 50.0])
def test_the_frames_stand_at_the_references_in_effect(page, minute, seconds):
    page.run(f"LexstackPlayer.show({seconds})")
    seen = page.run("LexstackPlayer.view.targets.map((node) => node.position.toArray())")
    expected = measure(minute).ee_target[round(100 * seconds)]
    assert np.allclose(seen, expected, atol=1e-5)


@pytest.mark.parametrize("seconds", [0.0, 15.0, 40.0])
def test_both_robots_are_seen_where_they_are(page, minute, seconds):
    image = show(page, seconds)
    assert len(np.unique(image.reshape(-1, 3), axis=0)) > 200  # not blank
    points = joints(minute, round(100 * seconds))
    for first, color in ((0, is_orange), (10, is_blue)):
        height, width = image.shape[:2]
        for x, y in (projected(page, p) for p in points[first + 3 : first + 10]):
            assert 0 < x < width
            assert 0 < y < height
            patch = image[int(y) - 2 : int(y) + 3, int(x) - 2 : int(x) + 3]
            assert (np.abs(patch - GROUND.astype(int)).max(axis=2) > 12).any()
        rows, columns = np.nonzero(color(image))
        assert len(rows) > 60
        x, y = projected(page, [*points[first + 2][:2], 0.3])
        assert np.hypot(columns.mean() - x, rows.mean() - y) < 60


def test_the_slider_moves_the_robots(page):
    before = show(page, 0.0)
    page.run(
        "(() => { const s = document.getElementById('view3d-time'); s.value = 20;"
        " s.dispatchEvent(new Event('input')); })()"
    )
    after = page.picture("#view3d")
    assert (before != after).any(axis=2).sum() > 2000
    assert page.run("document.getElementById('view3d-label').textContent").startswith("20.00 s")


def test_it_plays(page):
    page.run("LexstackPlayer.show(0); document.getElementById('view3d-play').click()")
    page.wait("Number(document.getElementById('view3d-time').value) > 0.3")
    page.run("document.getElementById('view3d-play').click()")
    assert page.run("document.getElementById('view3d-play').textContent") == "Play"


def test_zoom_on_time_is_linked(page):
    page.run(
        "Plotly.relayout('errors', {'xaxis.range[0]': 10, 'xaxis.range[1]': 20}).then(() => 0)"
    )
    page.wait("document.getElementById('poses').layout.xaxis.range[0] === 10")
    ranges = page.run("LexstackPlots.linked.map((plot) => plot.layout.xaxis.range)")
    assert len(ranges) == 7
    assert all(r == [10, 20] for r in ranges)


def test_a_click_into_a_plot_sets_the_time_everywhere(page):
    page.run("Plotly.relayout('errors', {'xaxis.range[0]': 0, 'xaxis.range[1]': 60}).then(() => 0)")
    page.run("document.getElementById('errors').emit('plotly_click', {points: [{x: 30}]}); 0")
    assert float(page.run("document.getElementById('view3d-time').value")) == 30.0
    left = page.run("parseFloat(document.querySelector('#poses .cursor').style.left)")
    axis = page.run(
        "[1, 1].map((_, i) => document.getElementById('poses')._fullLayout.xaxis)[0]._offset"
    )
    length = page.run("document.getElementById('poses')._fullLayout.xaxis._length")
    assert left == pytest.approx(axis + length / 2, abs=1.0)


def test_a_click_on_a_head_sorts_a_table(page):
    page.run("document.querySelector('#messages details').open = true")
    column = (
        "[...document.querySelectorAll('table.messages tbody tr')]"
        ".map((row) => Number(row.cells[1].textContent))"
    )
    head = "document.querySelectorAll('table.messages th')[1].click()"
    page.run(head)
    up = page.run(column)
    page.run(head)
    down = page.run(column)
    assert up == sorted(up) != down
    assert down == up[::-1]


def test_a_browser_without_webgl_says_so(report, tmp_path):
    with Browser() as browser:
        browser.call(
            "Page.addScriptToEvaluateOnNewDocument",
            source="HTMLCanvasElement.prototype.getContext = () => null",
        )
        browser.open(report.as_uri())
        browser.wait("document.documentElement.dataset.viewed")
        assert "No 3-D view" in browser.run("document.getElementById('view3d').textContent")


def test_play_data_of_an_hour_stays_small(minute):
    from lexstack_bag.report.traces import Grid
    from lexstack_bag.report.view import play_data

    hour = stretched(minute, 60 * MINUTE)
    grid = Grid.of(hour)
    series = grid.series(hour.plant.tick, hour.plant.q[:, 0])
    values = np.frombuffer(base64.b64decode(series["y"]["bdata"]), "<f4")
    assert len(values) <= 4000
    assert values.max() == pytest.approx(np.float32(hour.plant.q[:, 0].max()))
    data = play_data(minute, measure(minute), find_phases(minute))
    assert len(str(data)) < 2_500_000
