"""The plant's states: all in order, or the newest of those that wait."""

import time

import pytest
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.experimental import EventsExecutor
from rclpy.serialization import serialize_message

from lexstack_bringup.domain import own_domain
from lexstack_interfaces.msg import PlantState
from lexstack_ros.intake.plant_states import PlantStates
from lexstack_ros.messages.qos import STREAM
from lexstack_ros.node.calls import wait_until
from support.scenario import home, team


@pytest.fixture
def context(monkeypatch):
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)
    with own_domain() as domain:
        context = rclpy.Context()
        rclpy.init(context=context, domain_id=domain)
        yield context
        rclpy.shutdown(context=context)


def state(tick, **values):
    q = home().tolist()
    rest = [0.0] * len(q)
    fields = {"q": q, "v": rest, "q_star": q, "command": rest, "robots": list(team().names)}
    return PlantState(tick=tick, sender="sim_bridge@h/1/0", **{**fields, **values})


def served(context, executor_type, newest, messages):
    """Return what a node that fell behind heard, until tick 5, and its states."""
    node = rclpy.create_node("listener", context=context)
    heard = []
    states = PlantStates(
        node, team(), lambda s: heard.append(s.tick), lambda: heard.append("reset"), newest=newest
    )
    out = node.create_publisher(PlantState, "/plant/state", STREAM)
    end = time.monotonic() + 10.0
    while out.get_subscription_count() == 0:
        assert time.monotonic() < end
        time.sleep(0.01)
    for message in messages:
        out.publish(message)
    time.sleep(0.3)  # all wait
    executor = executor_type(context=context)
    executor.add_node(node)
    wait_until(executor, lambda: heard and heard[-1] == 5, 10.0)
    wait_until(executor, lambda: False, 0.1)
    executor.shutdown()
    node.destroy_node()
    return heard, states


@pytest.mark.parametrize("executor_type", [EventsExecutor, SingleThreadedExecutor])
@pytest.mark.parametrize(
    ("newest", "wanted"), [(0, [1, 2, 3, 4, 5]), (1, [5]), (2, [4, 5]), (5, [5]), (6, [5])]
)
def test_a_node_that_fell_behind_serves_all_or_the_newest(context, executor_type, newest, wanted):
    wrong = state(4, q=[0.0] * 3)  # refused, in its place, as bytes are that are no message
    no_message = serialize_message(state(4))[:40]
    over = state(2)
    messages = [state(1), state(2), state(3), wrong, no_message, state(4), over, state(5)]
    heard, states = served(context, executor_type, newest, messages)
    assert heard == wanted
    assert states.refused == 2
    assert states.skipped == 5 - len(wanted)


def test_nothing_of_before_a_reset_is_served_after_it(context):
    messages = [state(18), state(19), state(1, resets=1), state(5, resets=1)]
    heard, states = served(context, EventsExecutor, 6, messages)
    assert heard == ["reset", 5], "18 was due"
    assert states.skipped == 1
