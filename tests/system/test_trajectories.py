"""Trajectories by topic through all processes: controller, solver, bag and replay agree in bits."""

from dataclasses import replace

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped, TransformStamped, TwistStamped
from std_srvs.srv import SetBool

from lexstack_bag.figures.series import measure
from lexstack_bag.replay.changes import Changes
from lexstack_bag.replay.nodes import REPLAYERS, Question
from lexstack_bag.run.reader import read_run
from lexstack_config.resolved import load_scenario
from lexstack_config.scenario import EventConfig
from lexstack_config.trajectories import PathConfig, PostureWayConfig, TwistEventConfig, WayConfig
from lexstack_interfaces.msg import References
from lexstack_ros.messages.qos import LATCHED
from lexstack_testing.played_run import together
from lexstack_testing.user import User
from support.runs import read, short_scenario
from support.scenario import CONFIG, home, team

pytestmark = pytest.mark.system
SETTLED = 160  # ticks: the trajectory begins at 1 s, and is led onto for 0.5 s
DOWN = (1.0, 0.0, 0.0, 0.0)


def play(resolved, folder):
    with together(resolved, folder) as run:
        run.play()
        assert run.end() == []
    return read_run(folder)


@pytest.fixture(scope="module")
def eight(tmp_path_factory):
    """Return the run of the scenario with the figure of eight, and its folder."""
    folder = tmp_path_factory.mktemp("eight")
    resolved = load_scenario(CONFIG / "scenarios" / "figure-of-eight.yaml", CONFIG)
    return play(resolved, folder), folder


def everything():
    """Return a run of 5 s with every kind of reference, and two switches in the middle of them."""
    q = home()[3:10].tolist()
    elbow = WayConfig((0.5, 2.0), ((-0.1, 0.1, 1.1), (-0.1, -0.1, 1.1)), (DOWN,), "panda_link4")
    way = WayConfig((1.0, 2.0, 3.0), ((0.4, 0, 0.9), (0.4, 0.2, 0.9), (0.4, 0, 0.9)), (DOWN,))
    events = (
        EventConfig(0.3, ee_trajectory={"robot_a": way}),
        EventConfig(0.4, ee_twist={"robot_b": TwistEventConfig(2.0, (0.05, 0, 0), (0, 0, 0.2))}),
        EventConfig(
            0.5,
            ee_trajectory={"robot_b": elbow},
            base_path={"robot_a": PathConfig(((0, 0, 0), (0.2, 0, 0.1), (0.4, 0.1, 0.2)))},
            posture_trajectory={"robot_a": PostureWayConfig((1.0, 3.0), (tuple(q), tuple(q)))},
        ),
        EventConfig(1.0, "reach_base"),
        EventConfig(3.0, "posture"),
    )
    return short_scenario(events=events, duration=5.0, base_target={})


@pytest.fixture(scope="module")
def mixed(tmp_path_factory):
    folder = tmp_path_factory.mktemp("mixed")
    return play(everything(), folder), folder


def test_the_figure_of_eight_is_tracked_within_a_millimetre_through_a_transition(eight):
    run, _ = eight
    series = measure(run)
    assert series.ee_error[SETTLED:].max() < 1.0  # mm
    moved = np.ptp(series.ee_target[SETTLED:, 0], axis=0)
    np.testing.assert_allclose(moved, [0.0, 0.3, 0.2], atol=2e-3)
    speed = np.linalg.norm(np.diff(series.ee_target[SETTLED:, 0], axis=0), axis=1) * 100.0
    assert 0.2 < speed.max() < 0.22  # m/s
    blended = run.transition.stamp[run.transition.source == "robot_b"]
    assert (blended[0], blended[-1]) == pytest.approx((9.0, 10.0))
    assert set(run.transition.reason.tolist()) == {""}
    assert run.chi["robot_a"].stack[-1] == "posture"


@pytest.mark.parametrize("name", ["eight", "mixed"])
def test_the_solver_has_the_same_references_and_replay_repeats_every_bit(name, request):
    run, _ = request.getfixturevalue(name)
    of_a = dict(zip(run.chi["robot_a"].tick, run.chi["robot_a"].references, strict=True))
    solver = run.chi["robot_b"]
    assert len(solver.tick) > 90
    assert all(of_a[t] == r for t, r in zip(solver.tick, solver.references, strict=True))
    assert set(run.transition.reason.tolist()) == {""}, "no loss, no residual of another tick"
    for node in ("robot_a", "robot_b"):
        outcome = REPLAYERS[node](Question(run, Changes(), run.resolved))
        assert outcome.identical, outcome.line()


def test_messages_are_recorded_raw_and_decisions_carry_what_was_taken(mixed):
    _, folder = mixed
    topics = ("ee_trajectory", "base_path", "posture_trajectory")
    found = read(folder / "bag", *(f"/robot_a/{topic}" for topic in topics), "/robot_b/ee_twist")
    assert [len(messages) for messages in found.values()] == [1, 1, 1, 40]
    sent = read(folder / "bag", "/robot_a/references")["/robot_a/references"]
    kinds = {(t.robot, t.of, t.frame, t.kind) for m in sent for t in m.trajectories}
    assert kinds >= {
        ("robot_a", "ee", "tool", "waypoints"),
        ("robot_b", "ee", "tool", "twist"),
        ("robot_b", "ee", "panda_link4", "waypoints"),
        ("robot_a", "base", "tool", "spline"),
        ("robot_a", "posture", "tool", "spline"),
    }


def test_with_another_lead_in_the_replay_decides_on_the_same_trajectories_again(mixed):
    run, _ = mixed
    changes = Changes(("lead_in=1.5",))
    outcome = REPLAYERS["robot_a"](Question(run, changes, changes.applied(run.resolved)))
    assert 28 <= outcome.first <= 35, "the first trajectory, at tick 30"
    late = outcome.tick > 450
    np.testing.assert_allclose(outcome.replayed[late], outcome.recorded[late], atol=0.05)


class Teleoperator(User):
    """Publishes targets, and keeps what the controller decides and complains of."""

    def __init__(self, run):
        super().__init__(run)
        self.decisions = self.hear(References, "/robot_a/references", [], LATCHED)
        self.complaints = []
        self.node.create_subscription(DiagnosticArray, "/diagnostics", self._on_diagnostics, 10)
        assert self.call(SetBool, "/sim_bridge/pause", data=False).success
        self.until(lambda: self.commands and self.decisions)

    def _on_diagnostics(self, message):
        self.complaints += [s.message for s in message.status if s.name == "hqp_controller"]

    def kind(self):
        """Return the kind of the tool's reference, '' of a set-point that is led in."""
        newest = self.decisions[-1].trajectories
        return newest[0].kind if newest else ""


@pytest.fixture(scope="module")
def user(tmp_path_factory):
    """Return a user of a long run without targets of its own."""
    scenario = short_scenario(events=(), duration=3000.0, base_target={})
    with together(scenario, tmp_path_factory.mktemp("run")) as run:
        yield Teleoperator(run)
        assert run.end() == []


def test_a_stream_of_twists_moves_the_tool_until_it_ends(user):
    publisher = user.publisher(TwistStamped, "/robot_a/ee_twist")
    twist = TwistStamped()
    twist.twist.linear.y = 0.1

    sent = []

    def moves():
        if not sent or len(user.commands) > sent[-1] + 4:  # one for 5 ticks
            publisher.publish(twist)
            sent.append(len(user.commands))
        return user.kind() == "twist" and np.abs(user.commands[-1].chi).max() > 0.05

    user.until(moves)
    user.until(lambda: np.abs(user.commands[-1].chi).max() < 1e-3)


def test_a_target_in_a_frame_of_tf_is_taken_and_one_in_an_unknown_frame_refused_aloud(user):
    tf2 = pytest.importorskip("tf2_msgs.msg", reason="./scripts/setup builds it")
    transforms = user.publisher(tf2.TFMessage, "/tf_static", qos=LATCHED)
    table = TransformStamped(child_frame_id="table")
    table.header.frame_id, table.transform.rotation.w = "robot_b/tool", 1.0
    transforms.publish(tf2.TFMessage(transforms=[table]))
    target = PoseStamped()
    target.header.frame_id, target.pose.orientation.w = "table", 1.0
    publisher = user.publisher(PoseStamped, "/robot_a/ee_target")
    before, sent = len(user.decisions), []

    def heard():
        if not sent or len(user.commands) > sent[-1] + 50:  # /tf_static may come after the first
            publisher.publish(target)
            sent.append(len(user.commands))
        return len(user.decisions) > before

    user.until(heard)
    goal = np.array(user.decisions[-1].ee[:3])
    np.testing.assert_allclose(goal, team().tools(home())[1].position, atol=2e-3)
    target.header.frame_id = "nowhere"
    publisher.publish(target)
    user.until(lambda: any("unknown 'nowhere'; known: world" in c for c in user.complaints))


def test_a_hold_in_the_middle_of_the_eight_brings_the_tool_to_rest(tmp_path):
    resolved = load_scenario(CONFIG / "scenarios" / "figure-of-eight.yaml", CONFIG)
    first = resolved.scenario.events[0]
    empty = {"robot_a": replace(first.ee_trajectory["robot_a"], times=(), positions=())}
    events = (first, EventConfig(3.0, ee_trajectory=empty))
    scenario = replace(resolved.scenario, events=events, duration=5.0)
    run = play(replace(resolved, scenario=scenario), tmp_path)
    assert np.abs(run.chi["robot_a"].chi[-50:]).max() < 2e-3
    assert np.abs(run.chi["robot_a"].chi[295:299]).max() > 0.05
    series = measure(run)
    assert series.ee_error[-1, 0] < 1.0
