"""The page of a bag: what it shows at a time, and its slider and button in a browser."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from threading import Event, Thread

import numpy as np
import pytest

from lexstack.types import PlantStatus
from lexstack_bag.run.reader import read_run
from lexstack_bag.run.run import PlanStream, PlanTopics, ProgressStream
from lexstack_bringup.commands import replay
from lexstack_ros.view.page.bag import BagPage
from lexstack_ros.view.page.server import HOST
from lexstack_ros.view.recorded import Recorded
from support.browser import Browser
from support.hostile import shown
from support.view import LivePageUser


@pytest.fixture(scope="module")
def recorded(synthetic):
    return Recorded(read_run(synthetic.folder))


def at(recorded, seconds):
    return recorded.picture(recorded.row(seconds))


def test_a_picture_is_that_of_the_last_state_before_a_time(recorded):
    assert recorded.row(-1.0) == 0
    assert recorded.row(2.0049) == recorded.row(2.0) == 200
    assert recorded.row(1e9) == len(recorded.time) - 1
    picture = at(recorded, 2.0)
    assert (picture.tick, picture.time, picture.plant) == (200, 2.0, PlantStatus.FOLLOWING)
    assert picture.q[10] == pytest.approx(at(recorded, 1.99).q[10] + 0.0288)


def test_it_speaks_of_transitions_as_the_live_page_does(recorded):
    assert at(recorded, 0.5).stack == "track"
    assert at(recorded, 0.9).stack == "track, then reach_base"
    assert at(recorded, 1.5).stack == "track → reach_base"
    assert (at(recorded, 1.5).phase, at(recorded, 1.5).alpha) == ("blending", 0.5)
    assert at(recorded, 3.5).stack == "reach_base"


def test_levels_and_solve_times_are_those_of_the_tick(recorded):
    picture = at(recorded, 1.5)
    assert picture.levels == (0.0, 0.0)
    assert picture.solve["robot_a"] == pytest.approx(0.051)
    assert picture.solve["robot_b"] == pytest.approx(0.5)
    assert np.isnan(at(recorded, 3.5).solve["robot_b"])


def test_references_are_those_in_effect(recorded):
    before, after = at(recorded, 0.4).goals.ee[0], at(recorded, 0.6).goals.ee[0]
    assert np.allclose(after.position - before.position, (0.003, 0.0, 0.004))


def test_plots_cover_the_time_before(recorded):
    curves = recorded.curves(recorded.row(2.0))
    assert (curves.time[0], curves.time[-1]) == (0.0, 2.0)
    assert curves.alpha[-1] == pytest.approx(1.0)
    assert curves.levels.shape == (2, len(curves.time))
    assert len(recorded.curves(0).time) == 1


def with_plan(recorded, steps, velocities, tick=100):
    """Return the run with one plan of robot_b, and where its sequence stands."""
    run, empty = recorded._run, ProgressStream.__dataclass_fields__
    plans = PlanStream(
        np.array([tick]),
        np.array([0.01 * tick]),
        np.array([[*steps, np.nan]]),
        np.array([[*np.ravel(velocities), *np.full(len(velocities[0]), np.nan)]]),
        np.array([0]),
    )
    fields = {name: np.zeros(1) for name in empty}
    fields |= {
        "tick": np.array([tick]),
        "count": np.array([2]),
        "index": np.array([0]),
        "task": np.array(["cup"]),
        "error": np.array([0.5]),
    }
    topics = PlanTopics(plans, ProgressStream(**fields), ())
    return Recorded(replace(run, plan_topics={"robot_b": topics}))


def test_a_horizon_is_the_integral_of_the_plan_s_velocities(recorded):
    rest, fast = np.zeros(10), np.eye(10)[0]
    run = with_plan(recorded, (0.0, 0.5, 1.0), (rest, fast, fast))
    path = at(run, 1.2).horizons[1]
    begin = run.team.tools(at(run, 1.0).q)[1].position
    # 2 m/s2 for 0.5 s, then 1 m/s for 0.5 s, along x.
    assert np.allclose(path - begin, [[0, 0, 0], [0.25, 0, 0], [0.75, 0, 0]], atol=1e-9)
    assert at(run, 1.2).sequences == ("robot_b: task 1 of 2: cup, 500 mm away, 0 ms",)
    assert at(run, 3.0).horizons == {}
    assert at(run, 3.0).sequences == ()
    assert at(run, 0.5).horizons == {}


@pytest.fixture(scope="module")
def page(recorded):
    served = BagPage("a bag", recorded)
    ends = Event()

    def advance():
        while not ends.wait(0.05):
            served.advance(0.05)

    thread = Thread(target=advance)
    thread.start()
    yield served
    ends.set()
    thread.join()
    served.close()


def test_slider_and_button_play_the_bag(page, recorded):
    with Browser((1400, 900)) as browser:
        browser.open(page.url)
        user = LivePageUser(browser, recorded.team, at(recorded, 0.0).q)
        user.until(lambda: shown(browser, "0.00 s, tick 0"))
        assert not user.has_button("Switch stack")
        user.press_key("[role=slider]", "End")
        user.until(lambda: shown(browser, "tick 399"))
        assert shown(browser, "reach_base")
        user.press_key("[role=slider]", "Home")
        user.until(lambda: shown(browser, "0.00 s, tick 0"))
        user.press("Play")
        user.until(lambda: shown(browser, "track → reach_base"))
        user.until(lambda: user.has_button("Play"))  # it has come to the end
        assert shown(browser, "tick 399")
        user.until(lambda: shown(browser, "level 2"))
        assert browser.messages == []


@pytest.mark.parametrize("value", [float("nan"), "1", None, [1.0]])
def test_a_time_that_is_none_changes_nothing(recorded, page, value):
    before = page.time
    page._go_to(value)
    assert page.time == before


def test_the_command_serves_until_ctrl_c(synthetic):
    command = [sys.executable, "-m", "lexstack_bringup.commands.replay", "--view"]
    process = subprocess.Popen(
        [*command, synthetic.folder], stdout=subprocess.PIPE, text=True, env=dict(os.environ)
    )
    try:
        line = next(line for line in process.stdout if "watch it at" in line)
        assert f"http://{HOST}:" in line
        time.sleep(1.0)
        process.send_signal(signal.SIGINT)
        assert process.wait(20) == 0
    finally:
        process.kill()


def test_the_command_refuses_what_is_no_bag(tmp_path, capsys):
    assert replay.main([str(tmp_path), "--view"]) == 2
    assert "replay:" in capsys.readouterr().err
