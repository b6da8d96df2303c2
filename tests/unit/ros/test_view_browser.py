"""The page in a browser: what is drawn, what is dragged, which buttons ask for what."""

from __future__ import annotations

import time
from dataclasses import replace
from queue import Empty, SimpleQueue

import numpy as np
import pytest

from lexstack.robots import RobotModel, Team
from lexstack.types import PlantStatus
from lexstack_config.parts import build_team, home_of
from lexstack_ros.view.orders import BaseTarget, Cancel, Known, Pause, Switch, ToolTarget
from lexstack_ros.view.page import targets
from lexstack_ros.view.page.live import LivePage
from support.browser import Browser
from support.hostile import ALL, assert_harmless, shown
from support.scenario import home, resolved, team
from support.view import LivePageUser, picture

STACKS = ("posture", "track")
RETURN = 1.6  # s, after which a gizmo goes back to the goal
EVERYTHING = {"switch", "push", "plant", "sequences"}


class Shown:
    """A page that shows a picture, and a browser that looks at it."""

    def __init__(self, page, browser, asked):
        self.page, self.browser, self.asked = page, browser, asked
        self.user = LivePageUser(browser, team(), home())

    def order(self, seconds=20.0):
        return self.asked.get(timeout=seconds)


@pytest.fixture(scope="module")
def opened():
    asked = SimpleQueue()
    page = LivePage("title", team(), home(), Known(team().names, STACKS), asked.put)
    with Browser((1400, 1000)) as browser:
        browser.open(page.url)
        view = Shown(page, browser, asked)
        view.user.wait_drawn(lambda: page.show(picture()))
        yield view
    page.close()


@pytest.fixture
def seen(opened):
    """The page as it is at first: what was dragged goes back."""
    opened.page.offer(EVERYTHING)
    opened.user.until(lambda: opened.user.has_button("Reset"))
    time.sleep(RETURN)
    opened.page.show(picture())
    time.sleep(0.3)
    while not opened.asked.empty():
        opened.asked.get()
    yield opened
    assert opened.browser.messages == []


def test_the_robots_are_drawn_where_they_stand(seen):
    image = seen.browser.picture().astype(int)
    red, green, blue = (image[..., i] for i in range(3))
    orange = (red > 130) & (green < 0.65 * red) & (blue < 0.4 * red)
    azure = (blue > 90) & (red < 0.45 * blue) & (green < 0.75 * blue)
    for color, base in zip((orange, azure), team().base_poses(home()), strict=True):
        x, y = seen.user.pixel((base[0], base[1], 0.3))
        near = color[int(y) - 90 : int(y) + 90, int(x) - 130 : int(x) + 130]
        assert near.sum() > 150


def test_a_tool_target_is_dragged_and_sent_when_it_is_let_go(seen):
    place = team().tools(home())[0].position
    seen.user.drag_along(place, (1.0, 0.0, 0.0), 0.2)
    order = seen.order()
    assert isinstance(order, ToolTarget)
    assert order.robot == "robot_a"
    assert np.allclose(order.position, np.add(place, (0.2, 0.0, 0.0)), atol=0.05)
    assert abs(order.position[0] - place[0]) > 0.1
    with pytest.raises(Empty):  # it was sent once
        seen.order(0.5)


def test_a_base_target_moves_on_the_floor(seen):
    x, y, yaw = team().base_poses(home())[1]
    axis = (np.cos(yaw), np.sin(yaw), 0.0)
    seen.user.drag_along((x, y, 0.0), axis, -0.3, arrow=0.5)
    order = seen.order()
    assert isinstance(order, BaseTarget)
    assert order.robot == "robot_b"
    assert np.allclose(order.place, (x - 0.3 * axis[0], y - 0.3 * axis[1], yaw), atol=0.08)


def test_a_target_follows_the_hand_where_that_is_chosen(seen):
    seen.page._targets.streams = True
    try:
        place = team().tools(home())[0].position
        seen.user.drag_along(place, (1.0, 0.0, 0.0), 0.2)
        orders = [seen.order()]
        while orders[-1].position[0] < place[0] + 0.12:
            orders.append(seen.order())
    finally:
        seen.page._targets.streams = False
    assert len(orders) >= 3
    assert np.all(np.diff([order.position[0] for order in orders]) >= -1e-6)


def test_buttons_ask(seen):
    seen.user.press("Switch stack")
    assert seen.order() == Switch("posture", 0.0)
    seen.user.press("Cancel")
    assert seen.order() == Cancel()
    seen.user.press("Pause")
    assert seen.order() == Pause(True)


def test_buttons_of_what_nobody_serves_are_hidden(seen):
    assert seen.user.has_button("Switch stack")
    assert seen.user.has_button("Reset")
    assert not seen.user.has_button("Enable")
    seen.page.offer({"enable robot_b"})
    seen.user.until(lambda: seen.user.has_button("Enable"))
    assert not seen.user.has_button("Reset")


def test_answers_and_refusals_are_told(seen):
    seen.page.say("transition 7 starts")
    seen.user.until(lambda: shown(seen.browser, "transition 7 starts"))
    seen.page.refuse("no such way")
    seen.user.until(lambda: shown(seen.browser, "no such way"))


def test_a_second_page_sees_the_same(seen):
    with Browser((800, 600)) as other:
        other.open(seen.page.url)
        user = LivePageUser(other, team(), home())
        user.until(lambda: shown(other, "track"))
        assert other.messages == []


def test_nothing_is_loaded_from_elsewhere(seen):
    names = seen.browser.run("performance.getEntriesByType('resource').map((e) => e.name)")
    own = (seen.page.url, "blob:", "data:")
    assert [name for name in names if not name.startswith(own)] == []


def test_hostile_names_are_shown_and_run_nothing():
    """Names that its configuration would refuse."""
    known = resolved()
    robots = {f"{name}{ALL}": place for name, place in known.scenario.robots.items()}
    run = replace(known, scenario=replace(known.scenario, robots=robots))
    group = build_team(run)
    stacks = (f"stack{ALL}", f"other{ALL}")
    page = LivePage(
        f"name{ALL}", group, home_of(group, run), Known(group.names, stacks, stacks), lambda _: None
    )
    try:
        with Browser((1400, 1000)) as browser:
            browser.open(page.url)
            user = LivePageUser(browser, group, home())
            page.offer({*EVERYTHING, f"enable {group.names[0]}"})
            texts = {
                "stack": f"to{ALL}",
                "reason": f"reason{ALL}",
                "source": f"source{ALL}",
                "sequences": (f"task{ALL}",),
                "solve": {f"chi{ALL}": 0.4},
                "plant": PlantStatus.BRAKING,
            }
            for tick in range(12):
                page.show(picture(0.1 * tick, **texts))
                time.sleep(0.2)
            page.say(f"answer{ALL}")
            user.until(lambda: shown(browser, f"answer{ALL}"))
            for name in ("name", "to", "reason", "source", "task", "chi", "robot_a"):
                assert shown(browser, f"{name}{ALL}"), name
            page.refuse(f"refusal{ALL}")
            user.until(lambda: shown(browser, f"refusal{ALL}"))
            assert_harmless(browser)
    finally:
        page.close()


def test_a_gizmo_stays_in_the_hand_but_not_for_ever(monkeypatch):
    """A page that is closed in the middle of a drag does not say that it lets go."""
    page = LivePage("drag", team(), home(), Known(team().names, STACKS), lambda _: None)
    try:
        now = [1000.0]
        monkeypatch.setattr(targets.time, "monotonic", lambda: now[0])
        page._targets.show(picture().goals)
        grip = page._targets._grips[0]
        goal = grip.handle.position
        page._targets._moved(grip, "start")
        grip.handle.position = (9.0, 9.0, 9.0)
        now[0] += 20.0
        page._targets.show(picture().goals)
        assert np.allclose(grip.handle.position, 9.0)
        now[0] += 20.0
        page._targets.show(picture().goals)
        assert np.allclose(grip.handle.position, goal)
    finally:
        page.close()


def test_any_number_of_any_robots():
    robots = (*(RobotModel(f"r{i}", resolved().robots["panda_summit"]) for i in range(3)),)
    group = Team(robots, 0.01)
    page = LivePage("three", group, group.home(), Known(group.names, STACKS), lambda _: None)
    try:
        assert len(page._targets._grips) == 6
    finally:
        page.close()
