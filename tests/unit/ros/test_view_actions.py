"""What becomes of orders: topics, services and actions that anybody may use, and their answers."""

from __future__ import annotations

from concurrent.futures import Future
from types import SimpleNamespace

import numpy as np
import pytest

from lexstack.robots import from_rpy, to_quaternion
from lexstack_config.resolved import load_scenario
from lexstack_ros.view import actions, orders
from lexstack_ros.view.actions import Actions
from support.scenario import CONFIG, team

SCENARIO = load_scenario(CONFIG / "scenarios/deliver-both.yaml").scenario
ANSWER = {"accepted": True, "success": True, "message": "as asked"}


def done(value):
    future = Future()
    future.set_result(value)
    return future


class Client:
    """A service or an action that is there, or not, and answers at once."""

    def __init__(self, name):
        self.srv_name, self.ready, self.asked = name, True, []
        self.answer = SimpleNamespace(**ANSWER)
        self.cancelled = 0

    def service_is_ready(self):
        return self.ready

    server_is_ready = service_is_ready

    def call_async(self, request):
        self.asked.append(request)
        return done(self.answer)

    def send_goal_async(self, goal):
        self.asked.append(goal)
        result = SimpleNamespace(success=False, done=1, message="lost its way")
        return done(
            SimpleNamespace(
                accepted=self.answer.accepted,
                get_result_async=lambda: done(SimpleNamespace(result=result)),
                cancel_goal_async=self.cancel,
            )
        )

    def cancel(self):
        self.cancelled += 1


class Node:
    """Stands for a node: keeps clients and publishers by name."""

    def __init__(self):
        self.clients, self.sent = {}, {}

    def create_client(self, _kind, name):
        return self.clients.setdefault(f"/{name}", Client(f"/{name}"))  # in no namespace

    def create_publisher(self, _kind, topic, _qos):
        self.sent[f"/{topic}"] = []
        return SimpleNamespace(publish=self.sent[f"/{topic}"].append)


@pytest.fixture
def run(monkeypatch):
    monkeypatch.setattr(
        actions, "ActionClient", lambda node, _kind, name: Node.create_client(node, None, name)
    )
    node, told, refused = Node(), [], []
    made = Actions(node, team(), SCENARIO, told.append, refused.append)
    return SimpleNamespace(node=node, told=told, refused=refused, actions=made)


@pytest.mark.parametrize(
    ("order", "service", "fields"),
    [
        (orders.Switch("track", 0.5), "/robot_a/switch_stack", {"stack": "track", "duration": 0.5}),
        (orders.Cancel(), "/robot_a/cancel_transition", {}),
        (orders.Pause(True), "/sim_bridge/pause", {"data": True}),
        (orders.Pause(False), "/sim_bridge/pause", {"data": False}),
        (orders.Step(), "/sim_bridge/step", {}),
        (orders.Reset(), "/sim_bridge/reset", {}),
        (orders.Enable("robot_b", True), "/robot_b/enable", {"data": True}),
        (
            orders.Push("robot_a", "tool", (1.0, 2.0, 3.0), 0.5),
            "/sim_bridge/apply_wrench",
            {"robot": "robot_a", "link": "tool", "duration": 0.5},
        ),
    ],
)
def test_an_order_is_a_request(run, order, service, fields):
    run.actions.carry_out(order)
    (request,) = run.node.clients[service].asked
    assert {name: getattr(request, name) for name in fields} == fields
    assert run.told == ["as asked"]
    asked = [name for name, client in run.node.clients.items() if client.asked]
    assert asked == [service]


def test_a_refusal_and_an_absence_are_told(run):
    client = run.node.clients["/robot_a/enable"]
    client.answer = SimpleNamespace(success=False, message="the state is stale")
    run.actions.carry_out(orders.Enable("robot_a", True))
    client.ready = False
    run.actions.carry_out(orders.Enable("robot_a", True))
    assert run.refused == ["the state is stale", "/robot_a/enable is not there"]
    assert len(client.asked) == 1


def test_targets_are_poses_in_the_world_from_now_on(run):
    turn = tuple(to_quaternion(from_rpy((0.1, 0.2, 0.3))))
    run.actions.carry_out(orders.ToolTarget("robot_b", (0.1, 0.2, 0.9), turn))
    (tool,) = run.node.sent["/robot_b/ee_target"]
    place, rotation = tool.pose.position, tool.pose.orientation
    assert (place.x, place.y, place.z) == (0.1, 0.2, 0.9)
    assert (rotation.x, rotation.y, rotation.z, rotation.w) == turn
    assert tool.header.frame_id == "world"
    assert (tool.header.stamp.sec, tool.header.stamp.nanosec) == (0, 0)
    run.actions.carry_out(orders.BaseTarget("robot_a", (1.0, -2.0, np.pi)))
    (base,) = run.node.sent["/robot_a/base_target"]
    assert (base.pose.position.x, base.pose.position.y, base.pose.position.z) == (1.0, -2.0, 0.0)
    assert base.pose.orientation.z == pytest.approx(1.0)


def test_a_sequence_of_the_scenario_is_a_goal(run):
    name = min(SCENARIO.sequences)
    run.actions.carry_out(orders.Execute(name))
    client = run.node.clients["/htmpc/execute_sequence"]
    (goal,) = client.asked
    assert goal.robot == SCENARIO.sequences[name].robot
    assert len(goal.tasks) == len(SCENARIO.sequences[name].tasks)
    assert run.told == [f"sequence {name} begins", f"sequence {name}: 1 done: lost its way"]
    run.actions.carry_out(orders.Stop())
    assert client.cancelled == 1


def test_a_sequence_that_is_refused_or_not_there_says_so(run):
    name = min(SCENARIO.sequences)
    run.actions.carry_out(orders.Stop())
    client = run.node.clients["/htmpc/execute_sequence"]
    client.answer.accepted = False
    run.actions.carry_out(orders.Execute(name))
    client.ready = False
    run.actions.carry_out(orders.Execute(name))
    assert run.refused == [
        "this page has begun no sequence",
        f"sequence {name}: refused; the log of htmpc says why",
        "/htmpc/execute_sequence is not there",
    ]


def test_what_is_offered_is_what_is_served(run):
    everything = {"switch", "push", "plant", "sequences", "enable robot_a", "enable robot_b"}
    assert set(run.actions.offered()) == everything
    for gone, name in (("/robot_b/enable", "enable robot_b"), ("/sim_bridge/step", "plant")):
        run.node.clients[gone].ready = False
        everything.remove(name)
        assert set(run.actions.offered()) == everything


def test_held_tasks_are_released_by_name(run):
    held = {
        f"{entry.robot}/{task.name}"
        for entry in SCENARIO.sequences.values()
        for task in actions.tasks_of(entry)
        if task.held
    }
    run.actions.carry_out(orders.Release())
    assert {message.data for message in run.node.sent["/htmpc/release"]} == held
    assert bool(run.refused) == (not held)
