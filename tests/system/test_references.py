"""References through all processes: decided once, whenever targets come and whoever sends them."""

import signal
import time
from dataclasses import replace

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from std_srvs.srv import SetBool

from lexstack.robots import Pose, to_quaternion
from lexstack_config.resolved import load_scenario
from lexstack_config.scenario import PoseConfig
from lexstack_interfaces.msg import PlantState, References
from lexstack_ros.messages.conversions import pose_message
from lexstack_ros.messages.qos import LATCHED
from lexstack_testing.played_run import apart, together
from lexstack_testing.user import User
from support.runs import acceleration_ratio, read, short_scenario, transitions
from support.scenario import CONFIG, home, team

pytestmark = pytest.mark.system
ATTEMPTS = 5  # to have a run in real time without a late command


def stream(mode, **values):
    """Return the first seconds of the scenario with a stream of targets without stamps."""
    resolved = load_scenario(CONFIG / "scenarios" / "stream.yaml", CONFIG)
    streams = tuple(
        replace(entry, end=4.0, **values.pop("stream", {})) for entry in resolved.scenario.streams
    )
    changed = {"mode": mode, "duration": 5.0, "streams": streams, **values}
    return replace(resolved, scenario=replace(resolved.scenario, **changed))


def test_a_stream_without_stamps_loses_no_b_and_the_blend_takes_its_time(tmp_path):
    """Each χ of the solver was solved with the references that the controller had at its tick."""
    with together(stream("lockstep"), tmp_path) as run:
        run.play()
        assert run.end() == []
    topics = ("/robot_a/chi", "/robot_b/chi", "/robot_a/references")
    found = read(tmp_path / "bag", *topics)
    told = transitions(tmp_path / "bag")
    assert len(found["/robot_a/references"]) > 100, "the stream came"
    assert {status.reason for status in told} == {""}
    blend = [status.tick for status in told if status.source == "robot_b"]
    assert (blend[0], blend[-1]) == (100, 200)
    assert [s.alpha for s in told if 100 <= s.tick <= 200] == sorted(
        s.alpha for s in told if 100 <= s.tick <= 200
    )
    of_a = {chi.tick: chi.references for chi in found["/robot_a/chi"]}
    newest = {chi.tick: chi.references for chi in found["/robot_b/chi"]}
    assert newest
    assert all(of_a[tick] == revision for tick, revision in newest.items())


@pytest.mark.parametrize(
    ("mode", "running"),
    [
        ("lockstep", together),
        pytest.param("realtime", apart, marks=pytest.mark.realtime),
    ],
)
def test_a_target_in_mid_blend_is_no_kick(tmp_path, mode, running):
    """The target steps; the peak is that of the bridge, in realtime as in lockstep (0.16)."""
    scenario = short_scenario(mode=mode, lead_in=0.0)
    switch = replace(scenario.scenario.events[0], duration=1.0)
    tool = _ahead_of_the_tool()
    target = replace(switch, at=1.5, switch="", duration=0.0, ee_target={"robot_a": tool})
    scenario = replace(scenario, scenario=replace(scenario.scenario, events=(switch, target)))
    # Where the plant held its command for a tick, the next command makes good for two: such a run
    # tells of the machine, and does not count.
    for attempt in range(ATTEMPTS):
        folder = tmp_path / str(attempt)
        folder.mkdir()
        with running(scenario, folder) as run:
            run.play()
            assert run.end() == []
        held = [
            state.tick
            for state in read(folder / "bag", "/plant/state")["/plant/state"]
            if 100 < state.tick < 260 and state.status == PlantState.HOLDING  # in the blend
        ]
        if not held:
            break
    assert not held, "no run without a late command"
    peak = acceleration_ratio(folder / "bag", team().limits.acceleration, 0.01)
    assert 0.05 < peak < 0.25


class Sender(User):
    """Publishes targets, and keeps what the controller decides and complains of."""

    def __init__(self, run):
        super().__init__(run)
        self.decisions = self.hear(References, "/robot_a/references", [], LATCHED)
        self.complaints = []
        self.node.create_subscription(DiagnosticArray, "/diagnostics", self._on_diagnostics, 10)
        self.targets = self.publisher(PoseStamped, "/robot_a/ee_target")
        assert self.call(SetBool, "/sim_bridge/pause", data=False).success
        self.until(lambda: self.commands and self.decisions)

    def _on_diagnostics(self, message):
        self.complaints += [s.message for s in message.status if s.name == "hqp_controller"]

    def send(self, pose, stamp):
        message = pose_message(pose, 0.0, to_quaternion(pose.rotation))
        message.header.stamp.sec = stamp
        self.targets.publish(message)


@pytest.fixture(scope="module")
def user(tmp_path_factory):
    """Return a user of a long run without targets of its own."""
    scenario = short_scenario(events=(), duration=3000.0, base_target={})
    with together(scenario, tmp_path_factory.mktemp("run")) as run:
        yield Sender(run)


def test_nothing_moves_before_somebody_asks(user):
    user.until(lambda: len(user.commands) > 100)
    first = user.decisions[0]
    np.testing.assert_array_equal(first.base, [*home()[:3], *home()[10:13]])
    assert max(np.abs(chi.chi).max() for chi in user.commands) < 1e-9


def test_a_target_with_the_wall_clock_is_refused_aloud_and_keeps_no_other_out(user):
    before = len(user.decisions)
    tool = team().tools(home())[0]
    for _ in range(40):
        user.send(moved(tool, 0.0, 0.5), int(time.time()))
    user.until(lambda: any("s ahead of the simulated time" in c for c in user.complaints))
    assert len(user.decisions) == before
    user.send(moved(tool, 0.05, 0.0), 0)
    user.until(lambda: len(user.decisions) > before)
    assert user.decisions[-1].ee[0] == pytest.approx(tool.position[0] + 0.05)
    assert user.decisions[-1].ee_lead[1] == 0.0, "the scenario's targets step"


def test_who_comes_later_hears_the_newest_decision_alone(user):
    """An older one would be acted on until the next is taken from the queue."""
    before = len(user.decisions)
    for x in (0.02, 0.03):
        user.send(moved(team().tools(home())[0], x, 0.0), 0)
        user.until(lambda seen=before: len(user.decisions) > seen)
        before = len(user.decisions)
    late = user.hear(References, "/robot_a/references", [], LATCHED)
    user.until(lambda: late)
    user.spin(0.5)
    assert [decision.revision for decision in late] == [user.decisions[-1].revision]


def test_the_lead_in_is_a_parameter(user):
    value = Parameter(name="lead_in", value=0.3).to_parameter_msg()
    answer = user.call(SetParameters, "/hqp_controller/set_parameters", parameters=[value])
    assert answer.results[0].successful
    before = len(user.decisions)
    user.send(moved(team().tools(home())[0], 0.08, 0.0), 0)
    user.until(lambda: len(user.decisions) > before)
    assert user.decisions[-1].ee_lead[1] == 0.3


@pytest.mark.realtime
def test_a_controller_that_starts_again_goes_on_with_the_last_references(tmp_path):
    """The solver keeps them; the new controller's first decision is the old one's last."""
    scenario = short_scenario(mode="realtime", events=(), duration=600.0, base_target={})
    with apart(scenario, tmp_path) as run:
        user = Sender(run)
        kept = user.hear(References, "/robot_b/references", [], LATCHED)
        before = len(user.decisions)
        user.send(moved(team().tools(home())[0], 0.03, 0.0), 0)
        user.until(lambda: len(user.decisions) > before)
        last = user.decisions[-1]
        # The controller writes to one reader after the other: killed in between, the user has the
        # decision and the solver has not.
        user.until(lambda: kept and list(kept[-1].ee) == list(last.ee))
        run.send("hqp_controller", signal.SIGKILL)
        run.start("hqp_controller")
        user.until(lambda: user.decisions[-1].sender != last.sender)
        again = user.decisions[-1]
        assert again.revision == 1
        assert list(again.ee) == list(last.ee)
        assert list(again.base) == list(last.base)
        served = len(user.commands)
        user.until(lambda: len(user.commands) > served + 20)


def moved(pose, x, z):
    """Return a pose that is moved."""
    return Pose(pose.position + np.array([x, 0.0, z]), pose.rotation)


def _ahead_of_the_tool():
    """Return a configured pose 10 cm in front of and below the first robot's tool."""
    tool = moved(team().tools(home())[0], 0.0877, -0.058)
    x, y, z = (float(value) for value in tool.position)
    a, b, c, d = (float(value) for value in to_quaternion(tool.rotation))
    return PoseConfig((x, y, z), (a, b, c, d))
