"""The live page beside a whole run: what it shows, what it asks, and what it leaves alone."""

from __future__ import annotations

import json
import urllib.error
import urllib.request
from threading import Event, Thread

import numpy as np
import pytest
from std_srvs.srv import SetBool

from lexstack_bringup.live_page import start_page
from lexstack_interfaces.msg import TransitionStatus
from lexstack_testing.played_run import apart, together
from lexstack_testing.user import User
from support.browser import Browser
from support.runs import chi_by_tick, short_scenario

pytestmark = pytest.mark.system
PATIENCE = 40.0  # s


class Visitor(User):
    """Somebody with the page open, and the player's node to see what follows from it."""

    def __init__(self, run):
        super().__init__(run, run.player)
        self.url = start_page(run.supervisor, run.out / "scenario.yaml")

    def order(self, origin=None, **content):
        """Return the answer to an order, as the page sends it."""
        request = urllib.request.Request(
            f"{self.url}order",
            json.dumps(content).encode(),
            {"Origin": origin or self.url.rstrip("/"), "Content-Type": "application/json"},
        )
        try:
            with urllib.request.urlopen(request, timeout=15) as response:
                return json.load(response)
        except urllib.error.HTTPError as error:
            return json.load(error)

    def news(self):
        """Return the next news."""
        with urllib.request.urlopen(f"{self.url}events", timeout=15) as events:
            for line in events:
                if line.startswith(b"data: "):
                    return json.loads(line[6:])
        raise AssertionError("the page was told nothing")


def listener(url, stop):
    with urllib.request.urlopen(f"{url}events", timeout=15) as events:
        while not stop.is_set() and events.readline():
            pass


def test_being_watched_does_not_change_chi(tmp_path):
    bits = []
    for name, running in (("alone", together), ("watched", apart)):
        out = tmp_path / name
        out.mkdir()
        with running(short_scenario(duration=3.0), out) as run:
            if name == "watched":
                stop = Event()
                url = start_page(run.supervisor, out / "scenario.yaml")
                Thread(target=listener, args=(url, stop), daemon=True).start()
            run.play()
            assert run.end() == []
            if name == "watched":
                stop.set()
        bits.append(chi_by_tick(out / "bag", "/robot_a/chi"))
    assert len(bits[0]) >= 300
    assert bits[0] == bits[1]


@pytest.fixture(scope="module")
def visitor(tmp_path_factory):
    scenario = short_scenario(mode="lockstep", events=(), duration=3000.0)
    with apart(scenario, tmp_path_factory.mktemp("run")) as run:
        visitor = Visitor(run)
        assert visitor.call(SetBool, "/sim_bridge/pause", data=False).success
        visitor.until(lambda: visitor.statuses)
        yield visitor


def test_the_page_is_there(visitor):
    with urllib.request.urlopen(visitor.url, timeout=15) as response:
        text = response.read().decode()
    assert "Switch stack" in text
    assert "THREE" in text


def test_news_tell_where_the_run_stands(visitor):
    heard = []

    def listen():
        news = visitor.news()
        while not news["stack"]:  # the page hears the transitions a little later than the states
            news = visitor.news()
        heard.append(news)

    Thread(target=listen).start()
    visitor.until(lambda: heard)  # the node here goes on listening meanwhile
    news = heard[0]
    visitor.until(lambda: visitor.states and visitor.states[-1].tick > news["tick"])
    state = next(s for s in visitor.states if s.tick == news["tick"])
    assert news["time"] == pytest.approx(news["tick"] / 100.0)
    assert np.allclose(news["q"], state.q, atol=1e-5)
    assert (news["plant"], news["phase"], news["stack"]) == ("following", "idle", "track")
    assert len(news["levels"]) == 2
    assert 0.0 < news["solve"]["robot_a"] < 1000.0
    assert np.shape(news["ee"]) == (2, 7)


def test_a_foreign_page_changes_nothing(visitor):
    answer = visitor.order("http://evil.example", do="switch", stack="reach_base", duration=0.5)
    assert not answer["ok"]
    tick = visitor.statuses[-1].tick
    visitor.until(lambda: visitor.statuses[-1].tick > tick + 50)
    assert all(status.id == 0 for status in visitor.statuses)


def test_a_switch_is_seen_in_the_run_and_in_the_page(visitor):
    answer = visitor.order(do="switch", stack="reach_base", duration=0.5)
    assert answer["ok"], answer
    visitor.until(lambda: visitor.statuses[-1].to_stack == "reach_base")
    visitor.until(lambda: visitor.statuses[-1].phase == TransitionStatus.IDLE)
    assert visitor.news()["stack"] == "reach_base"


def test_a_new_target_moves_the_reference(visitor):
    x, y, z = visitor.news()["ee"][1][:3]
    values = [x + 0.05, y, z]
    assert visitor.order(do="target", robot="robot_b", kind="ee", values=values)["ok"]
    visitor.until(lambda: np.allclose(visitor.news()["ee"][1][:3], values))
    assert visitor.order(do="target", robot="robot_b", kind="base", values=[2.1, 0.4, 0.1])["ok"]
    visitor.until(lambda: np.allclose(visitor.news()["base"][1], [2.1, 0.4, 0.1]))


def test_a_push_moves_the_robot(visitor):
    def bent():
        """How far the arm of the controller is from where the commands have it [rad]."""
        state = visitor.states[-1]
        return np.abs(np.subtract(state.q, state.q_star))[3:10].max()

    visitor.until(lambda: bent() < 0.003)
    answer = visitor.order(do="push", robot="robot_a", link="tool", force=[0, 40, 0], duration=2.0)
    assert answer["ok"], answer
    visitor.until(lambda: bent() > 0.01)


def test_a_refusal_is_told(visitor):
    answer = visitor.order(do="switch", stack="nowhere", duration=0.0)
    assert not answer["ok"]
    assert "stack: expected one of" in answer["message"]


def test_the_page_in_a_browser_shows_the_robots_and_its_buttons_work(visitor):
    with Browser((1320, 1000)) as page:
        page.open(visitor.url)
        page.wait("window.LexstackLive && LexstackLive.news()", PATIENCE)
        page.run("document.getElementById('to').value = 'track'")
        page.run("document.getElementById('duration').value = '0.3'")
        page.run("document.getElementById('switch').click()")
        page.wait("document.getElementById('answer').textContent.includes('track')", PATIENCE)
        page.wait("document.getElementById('stack').textContent === 'track'", PATIENCE)
        image = page.picture("#view3d").astype(int)
        bases = page.run(
            "[0, 10].map((i) => { const q = LexstackLive.news().q;"
            " return LexstackLive.view.project([q[i], q[i + 1], 0.3]); })"
        )
        red, green, blue = (image[..., i] for i in range(3))
        orange = (red > 130) & (green < 0.65 * red) & (blue < 0.4 * red)
        azure = (blue > 110) & (red < 0.45 * blue) & (green < 0.75 * blue)
        for seen, (x, y) in zip((orange, azure), bases, strict=True):
            rows, columns = np.nonzero(seen)
            assert len(rows) > 60
            assert np.hypot(columns.mean() - x, rows.mean() - y) < 60
        page.wait("document.querySelectorAll('#strips .scatterlayer .trace').length >= 3")
        assert page.messages == []


def test_it_ends_with_the_others(visitor):
    process = visitor.run.process("view")
    assert visitor.run.end() == []
    assert process.returncode == 0
    with pytest.raises(urllib.error.URLError, match="refused"):
        urllib.request.urlopen(visitor.url, timeout=5)
