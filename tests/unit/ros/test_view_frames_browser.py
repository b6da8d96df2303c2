"""Gizmos that come and go with the stack in effect, differential bases, and stacks as text."""

from __future__ import annotations

import time
from queue import SimpleQueue

import numpy as np
import pytest

from lexstack.robots import Pose
from lexstack_config.parts import build_team, home_of
from lexstack_config.resolved import load_scenario
from lexstack_ros.view.orders import (
    BaseTarget,
    Enable,
    Known,
    Pause,
    Push,
    Reset,
    Step,
    Switch,
    SwitchToText,
    ToolTarget,
)
from lexstack_ros.view.page.live import LivePage
from support.browser import Browser
from support.scenario import CONFIG, home, team
from support.view import LivePageUser, picture

ELBOW = (0, "panda_link5")
AWAY = Pose(np.array([0.2, -0.9, 1.1]), np.eye(3))  # m: nothing else is there
OFFERED = {"switch", "push", "plant", "enable robot_b"}


class Shown:
    """A page, a browser that looks at it, and what was asked."""

    def __init__(self, page, browser, asked, group, start):
        self.page, self.browser, self.asked = page, browser, asked
        self.user = LivePageUser(browser, group, start)

    def order(self):
        return self.asked.get(timeout=20.0)

    def press(self, text):
        """Return what a button asks for."""
        self.user.press(text)
        return self.order()


@pytest.fixture(scope="module")
def seen():
    asked = SimpleQueue()
    page = LivePage("frames", team(), home(), Known(team().names, ("posture", "track")), asked.put)
    with Browser((1400, 1000)) as browser:
        browser.open(page.url)
        shown = Shown(page, browser, asked, team(), home())
        shown.user.wait_drawn(lambda: page.show(picture(frames={ELBOW: AWAY})))
        page.offer(OFFERED)
        yield shown
        assert browser.messages == []
    page.close()


def test_a_frame_of_the_stack_in_effect_is_dragged(seen):
    seen.user.drag_along(AWAY.position, (1.0, 0.0, 0.0), 0.2, arrow=0.2)
    order = seen.order()
    assert isinstance(order, ToolTarget)
    assert (order.robot, order.frame) == ("robot_a", "panda_link5")
    assert np.allclose(order.position, AWAY.position + np.array([0.2, 0.0, 0.0]), atol=0.05)


def test_its_gizmo_goes_with_the_task(seen):
    seen.page.show(picture(0.1))
    time.sleep(0.5)
    seen.user.drag_along(AWAY.position, (1.0, 0.0, 0.0), 0.2, arrow=0.2)
    time.sleep(0.5)
    assert seen.asked.empty()  # the drag has turned the view, the last one of these tests
    assert not seen.page._targets._frames


def test_every_button_asks(seen):
    assert seen.press("Switch stack") == Switch("posture", 0.0)
    assert seen.press("Continue") == Pause(False)
    assert seen.press("One tick") == Step()
    assert seen.press("Reset") == Reset()
    assert seen.press("Enable") == Enable("robot_b", True)
    assert seen.press("Disable") == Enable("robot_b", False)
    seen.user.unfold("Push")
    assert seen.press("Push") == Push("robot_a", "base", (0.0, 40.0, 0.0), 0.5)


def test_a_stack_is_written_and_switched_to(seen):
    seen.user.unfold("Stack as text")
    order = seen.press("Switch to text")
    assert isinstance(order, SwitchToText)
    assert "name: my_stack" in order.text
    text = "name: other\nlevels:\n- tasks: [{type: posture}]\n"
    seen.user.write("YAML", text)
    assert seen.press("Switch to text") == SwitchToText(text, 0.0)


def test_a_stack_that_was_sent_can_be_chosen(seen):
    seen.page.know_stacks(("mine", "posture", "track"))
    seen.user.choose("to", "mine")
    assert seen.press("Switch stack") == Switch("mine", 0.0)
    seen.page.know_stacks(("mine", "more", "posture", "track"))
    assert seen.press("Switch stack") == Switch("mine", 0.0), "what is chosen stays"


def test_the_target_of_a_differential_base_is_dragged():
    resolved = load_scenario(CONFIG / "scenarios/drive.yaml")
    group, asked = build_team(resolved), SimpleQueue()
    start = home_of(group, resolved)
    assert group.robots[0].differential
    page = LivePage("drive", group, start, Known(group.names, ("posture",)), asked.put)
    goals = picture().goals
    goals = type(goals)(group.tools(start), tuple(group.base_poses(start)))
    shown = picture(q=start, references=goals, goals=goals, obstacles=np.zeros((0, 3)))
    try:
        with Browser((1400, 1000)) as browser:
            browser.open(page.url)
            seen = Shown(page, browser, asked, group, start)
            seen.user.wait_drawn(lambda: page.show(shown))
            seen.user.drag_along((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), 0.3, arrow=0.5)
            order = seen.order()
            assert isinstance(order, BaseTarget)
            assert np.allclose(order.place, (0.3, 0.0, 0.0), atol=0.06)
            assert browser.messages == []
    finally:
        page.close()
