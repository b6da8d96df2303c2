"""The page beside a whole run: what it shows, what it asks, and what it leaves alone."""

from __future__ import annotations

import socket
from contextlib import nullcontext
from urllib.parse import urlsplit

import numpy as np
import pytest
from rclpy.serialization import deserialize_message
from std_srvs.srv import SetBool
from websockets.exceptions import InvalidStatus

from lexstack_bringup.live_page import start_page
from lexstack_config.parts import build_team, home_of
from lexstack_interfaces.msg import PlantState, TransitionStatus
from lexstack_testing.played_run import apart, together
from lexstack_testing.user import User
from support.browser import Browser
from support.foxglove_client import Client
from support.hostile import shown
from support.runs import chi_by_tick, read, short_scenario
from support.view import LivePageUser, watching

pytestmark = pytest.mark.system
ELBOW = """
name: elbow
description: robot_a keeps a link at its target, then the bases
levels:
- tasks: [{type: frame_position, robot: robot_a, parameters: {frame: panda_link5}}]
- tasks: [{type: base}]
- tasks: [{type: velocity_damping}]
"""


def test_being_watched_does_not_change_chi(tmp_path):
    bits = []
    for name, running in (("alone", together), ("watched", apart)):
        out = tmp_path / name
        out.mkdir()
        with running(short_scenario(duration=3.0), out) as run:
            watched = name == "watched"
            page = start_page(run.supervisor, out / "scenario.yaml")[0] if watched else ""
            with watching(page) if watched else nullcontext() as heard:
                run.play()
            assert run.end() == []
            assert heard is None or len(heard) > 5
        bits.append(chi_by_tick(out / "bag", "/robot_a/chi"))
    assert len(bits[0]) >= 300
    assert bits[0] == bits[1]


class Visitor(User):
    """Somebody with the page open in a browser, and the player's node to see what follows."""

    def __init__(self, run, browser):
        super().__init__(run, run.player)
        self.team = build_team(run.resolved)
        self.url, self.foxglove = start_page(
            run.supervisor, run.out / "scenario.yaml", foxglove="0"
        )
        self.browser = browser
        self.page = LivePageUser(browser, self.team, home_of(self.team, run.resolved))

    def tool(self, robot):
        """Return where a tool is [m]."""
        return self.team.tools(np.array(self.states[-1].q))[robot].position

    def frame(self, robot, name):
        """Return the pose of a frame."""
        model = self.team.robots[robot]
        q = np.array(self.states[-1].q)[self.team.q_slices[robot]]
        return model.at(q, model.frame(name))[0]

    def base(self, robot):
        """Return x, y, yaw of a base."""
        return self.team.base_poses(np.array(self.states[-1].q))[robot]

    def press(self, text):
        self.until(lambda: self.page.has_button(text), f"a button {text}")
        self.page.press(text)


@pytest.fixture(scope="module")
def visitor(tmp_path_factory):
    scenario = short_scenario(mode="lockstep", events=(), duration=3000.0)
    folder = tmp_path_factory.mktemp("run")
    with Browser((1400, 1000)) as browser, apart(scenario, folder) as run:
        visitor = Visitor(run, browser)
        assert visitor.call(SetBool, "/sim_bridge/pause", data=False).success
        visitor.until(lambda: visitor.statuses)
        browser.open(visitor.url)
        visitor.until(lambda: shown(browser, "ticks/s"), "the page to show the run")
        yield visitor


def test_the_page_tells_where_the_run_stands(visitor):
    visitor.until(lambda: shown(visitor.browser, "track"))
    assert shown(visitor.browser, "following")
    assert shown(visitor.browser, "idle")
    visitor.until(lambda: shown(visitor.browser, "level 2"), "the plots")
    assert visitor.browser.messages == []


def test_a_foreign_page_is_refused(visitor):
    with pytest.raises(InvalidStatus, match="403"), watching(visitor.url, "http://evil.example"):
        pass


def test_a_tool_target_that_is_dragged_moves_the_robot_there(visitor):
    visitor.until(lambda: np.abs(visitor.states[-1].v).max() < 1e-3, "the robots to rest")
    goal = visitor.team.tools(np.array(visitor.states[-1].q))[1]
    before = visitor.tool(1)
    visitor.page.drag_along(goal.position, goal.rotation[:, 0], 0.15)
    visitor.until(lambda: shown(visitor.browser, "target sent: robot_b, ee"))
    visitor.until(lambda: np.linalg.norm(visitor.tool(1) - before) > 0.1, "robot_b to go there")
    moved = visitor.tool(1) - before
    assert moved @ goal.rotation[:, 0] > 0.95 * np.linalg.norm(moved)


def test_a_switch_is_seen_in_the_run_and_in_the_page(visitor):
    visitor.browser.run("document.activeElement.blur()")
    visitor.page.choose("to", "reach_base")
    visitor.press("Switch stack")
    visitor.until(lambda: visitor.statuses[-1].to_stack == "reach_base")
    visitor.until(lambda: visitor.statuses[-1].phase == TransitionStatus.IDLE)
    visitor.until(lambda: shown(visitor.browser, "reach_base idle"))


def test_a_base_target_that_is_dragged_moves_the_base_there(visitor):
    visitor.until(lambda: np.abs(visitor.states[-1].v).max() < 1e-3, "the robots to rest")
    x, y, yaw = visitor.base(0)
    axis = np.array([np.cos(yaw), np.sin(yaw), 0.0])
    visitor.page.drag_along((x, y, 0.0), axis, 0.2, arrow=0.5)
    visitor.until(lambda: shown(visitor.browser, "target sent: robot_a, base"))
    visitor.until(lambda: (visitor.base(0)[:2] - (x, y)) @ axis[:2] > 0.12, "robot_a to drive")


def test_a_frame_of_a_stack_that_is_written_on_the_page_is_dragged(visitor):
    visitor.page.unfold("Stack as text")
    visitor.page.write("YAML", ELBOW)
    visitor.press("Switch to text")
    visitor.until(lambda: shown(visitor.browser, "elbow idle"))
    visitor.until(lambda: np.abs(visitor.states[-1].v).max() < 1e-3, "the robots to rest")
    before = visitor.frame(0, "panda_link5")
    axis = max(before.rotation.T, key=lambda a: visitor.page.pixels(before.position, a))
    visitor.page.drag_along(before.position, axis, 0.12, arrow=0.2)
    visitor.until(lambda: shown(visitor.browser, "target sent: robot_a, panda_link5"))
    way = 0.08  # m: the drag is as exact as pixels are

    def moved():
        return visitor.frame(0, "panda_link5").position - before.position

    visitor.until(lambda: moved() @ axis > way, "the frame to go there")
    assert np.linalg.norm(moved()) < 1.2 * (moved() @ axis)
    visitor.page.unfold("Stack as text")


def test_a_push_moves_the_robot(visitor):
    def bent(state):
        """How far the arm is from where the commands have it [rad]."""
        return np.abs(np.subtract(state.q, state.q_star))[3:10].max()

    visitor.until(lambda: bent(visitor.states[-1]) < 0.003)
    visitor.page.unfold("Push")
    visitor.page.choose("link", "tool")
    tick = visitor.states[-1].tick
    visitor.press("Push")
    # A push is short: on a busy machine its peak need not be in the newest state when it is looked.
    visitor.until(lambda: any(bent(s) > 0.01 for s in list(visitor.states) if s.tick > tick))


def test_the_plant_is_paused_and_goes_on(visitor):
    visitor.press("Pause")
    visitor.until(lambda: visitor.states[-1].status == visitor.states[-1].PAUSED)
    tick = visitor.states[-1].tick
    visitor.press("One tick")
    visitor.until(lambda: visitor.states[-1].tick == tick + 1)
    visitor.press("Continue")
    visitor.until(lambda: visitor.states[-1].tick > tick + 50)


def test_the_run_is_served_to_foxglove_with_its_markers(visitor):
    client = Client(visitor.foxglove)
    wanted = ("/plant/state", "/markers", "/tf_static", "/robot_b/robot_description")

    def heard():
        client.take()
        return {number for number, _, _ in client.heard}

    visitor.until(lambda: not heard() and set(wanted) <= client.channels.keys())
    for number, topic in enumerate(wanted):
        client.subscribe(topic, number)
    visitor.until(lambda: heard() == set(range(len(wanted))), "a message of each")
    number, stamp, data = next(each for each in client.heard if each[0] == 0)
    state = deserialize_message(data, PlantState)
    seconds = state.header.stamp.sec + 1e-9 * state.header.stamp.nanosec
    # Ticks in lockstep outrun the wall, so a message that waits is older than the newest /clock.
    assert abs(1e-9 * stamp - seconds) < 5.0, "simulated time, not the wall's"
    client.close()


def test_a_refusal_is_told(visitor):
    visitor.page.unfold("Target by numbers")
    visitor.page.write("tool: qx, qy, qz, qw", "1, 1, 0, 0")
    visitor.press("Tool")
    visitor.until(lambda: shown(visitor.browser, "orientation: norm must be 1"))


def test_it_ends_with_the_others(visitor):
    process = visitor.run.process("view")
    assert visitor.run.end() == []
    assert process.returncode == 0
    with pytest.raises(OSError, match="refused"):
        socket.create_connection(("127.0.0.1", urlsplit(visitor.url).port), timeout=5)


def test_markers_and_frames_are_in_the_bag(visitor):
    """The run has ended; rosbags opens what it recorded."""
    heard = read(visitor.run.out / "bag", "/tf", "/tf_static", "/markers", "/plant/state")
    (static,) = heard["/tf_static"]
    tree = {t.child_frame_id: t.header.frame_id for t in static.transforms}
    assert len(heard["/tf"]) > 20
    moving = heard["/tf"][-1]
    tree |= {t.child_frame_id: t.header.frame_id for t in moving.transforms}
    for name in visitor.team.names:
        assert tree[f"{name}/odom"] == "world"
        for leaf in (f"{name}/base_link", f"{name}/tool"):
            frame = leaf
            while frame in tree:
                frame = tree[frame]
            assert frame == "world"
    stamp = moving.transforms[0].header.stamp
    states = {(s.header.stamp.sec, s.header.stamp.nanosec): s.q for s in heard["/plant/state"]}
    q = states[stamp.sec, stamp.nanosec]
    (x,) = [
        t.transform.translation.x
        for t in moving.transforms
        if t.child_frame_id == "robot_b/base_x_link"
    ]
    assert x == q[visitor.team.q_slices[1]][0]
    assert len(heard["/markers"]) > 5
    kinds = {marker.ns for marker in heard["/markers"][-1].markers}
    assert kinds >= {"spheres of robot_a", "tool references", "paths"}
