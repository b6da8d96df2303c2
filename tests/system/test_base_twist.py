"""A base driven by twists, as of a joystick: holonomic and differential, and what the bag has."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from geometry_msgs.msg import TwistStamped
from std_srvs.srv import SetBool

from lexstack_bag.replay.changes import Changes
from lexstack_bag.replay.nodes import REPLAYERS, Question
from lexstack_bag.run.reader import read_run
from lexstack_config.resolved import load_scenario
from lexstack_config.sent_stacks import read_stack
from lexstack_testing.played_run import together
from lexstack_testing.user import User
from support.runs import read, short_scenario
from support.scenario import CONFIG

pytestmark = pytest.mark.system
DRIVEN = read_stack(
    "{name: driven, description: bases first, levels: [{tasks: [{type: base}]},"
    " {tasks: [{type: velocity_damping}]}]}"
)
FORWARD, TURN = 0.2, 0.4  # m/s, rad/s: an arc with a radius of 0.5 m
EVERY = 5  # ticks between two twists


def scenario(name):
    """Return a long run without events, whose stack moves bases."""
    if name == "differential":
        resolved = load_scenario(CONFIG / "scenarios/drive.yaml", CONFIG)
        values = {"events": (), "sequences": {}, "duration": 3000.0}
        resolved = replace(resolved, scenario=replace(resolved.scenario, **values))
    else:
        resolved = short_scenario(events=(), duration=3000.0, base_target={})
    resolved = replace(resolved, stacks={**resolved.stacks, DRIVEN.name: DRIVEN})
    return replace(resolved, scenario=replace(resolved.scenario, initial_stack=DRIVEN.name))


class Driver(User):
    """Sends a twist every few ticks."""

    def __init__(self, run):
        super().__init__(run)
        self.out = self.publisher(TwistStamped, "/robot_a/base_twist")
        assert self.call(SetBool, "/sim_bridge/pause", data=False).success
        self.until(lambda: self.commands)

    def base(self):
        return np.array(self.states[-1].q[:3])

    def drive(self, seconds):
        """Send twists for some simulated time; return the places of the base meanwhile."""
        twist = TwistStamped()
        twist.header.frame_id = "robot_a/base"
        twist.twist.linear.x, twist.twist.angular.z = FORWARD, TURN
        begin = sent = self.states[-1].tick
        first = len(self.states)

        def done():
            nonlocal sent
            tick = self.states[-1].tick
            if tick >= sent + EVERY:
                self.out.publish(twist)
                sent = tick
            return tick > begin + 100 * seconds

        self.until(done, "the drive")
        return np.array([state.q[:3] for state in self.states[first:]])


@pytest.fixture(scope="module", params=["holonomic", "differential"])
def driver(request, tmp_path_factory):
    with together(scenario(request.param), tmp_path_factory.mktemp("run")) as run:
        yield Driver(run)


def test_twists_in_its_own_axes_drive_the_base_along_an_arc(driver):
    places = driver.drive(6.0)[200:]
    yaw = np.unwrap(places[:, 2])
    assert np.ptp(yaw) > 0.9 * TURN * 4.0 - 0.1
    length = np.linalg.norm(np.diff(places[:, :2], axis=0), axis=1).sum()
    assert length / np.ptp(yaw) == pytest.approx(FORWARD / TURN, rel=0.05)
    ahead = np.column_stack((np.cos(yaw), np.sin(yaw)))[:-1]
    steps = np.diff(places[:, :2], axis=0)
    sideways = steps[:, 1] * ahead[:, 0] - steps[:, 0] * ahead[:, 1]
    assert np.abs(sideways.sum()) < 0.03 * length


def test_without_further_twists_it_comes_to_rest(driver):
    driver.until(lambda: np.abs(driver.commands[-1].chi).max() < 1e-3, "rest")
    place = driver.base()
    driver.spin(0.5)
    np.testing.assert_allclose(driver.base(), place, atol=5e-3)


def test_the_bag_has_it_and_replay_repeats_every_bit(driver):
    assert driver.run.end() == []
    folder = driver.run.out
    found = read(folder / "bag", "/robot_a/base_twist", "/robot_a/references")
    assert len(found["/robot_a/base_twist"]) > 50
    sent = [t for m in found["/robot_a/references"] for t in m.trajectories]
    assert {(t.robot, t.of, t.kind) for t in sent} == {("robot_a", "base", "base_twist")}
    run = read_run(folder)
    outcome = REPLAYERS["robot_a"](Question(run, Changes(), run.resolved))
    assert outcome.identical, outcome.line()
