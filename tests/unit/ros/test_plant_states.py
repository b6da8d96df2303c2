"""The plant's states: all in order, or the newest of those that wait."""

import time

import pytest
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.experimental import EventsExecutor
from rclpy.serialization import serialize_message

from lexstack_interfaces.msg import PlantState
from lexstack_ros.domain import own_domain
from lexstack_ros.plant_states import PlantStates
from lexstack_ros.qos import STREAM
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


@pytest.mark.parametrize("executor_type", [EventsExecutor, SingleThreadedExecutor])
@pytest.mark.parametrize(("newest", "served"), [(False, [1, 2, 3, 4, 5]), (True, [5])])
def test_a_node_that_fell_behind_serves_all_or_the_newest(context, executor_type, newest, served):
    node = rclpy.create_node("listener", context=context)
    heard = []
    states = PlantStates(node, team(), lambda s: heard.append(s.tick), lambda: None, newest=newest)
    out = node.create_publisher(PlantState, "/plant/state", STREAM)
    end = time.monotonic() + 10.0
    while out.get_subscription_count() == 0:
        assert time.monotonic() < end
        time.sleep(0.01)
    for tick in (1, 2, 3):
        out.publish(state(tick))
    out.publish(state(4, q=[0.0] * 3))  # wrong: refused, in its place
    out.publish(serialize_message(state(4))[:40])  # no message
    out.publish(state(4))
    out.publish(state(2))  # over
    out.publish(state(5))
    time.sleep(0.3)  # all wait
    executor = executor_type(context=context)
    executor.add_node(node)
    while time.monotonic() < end and (not heard or heard[-1] < 5):
        executor.spin_once(timeout_sec=0.1)
    for _ in range(10):
        executor.spin_once(timeout_sec=0.01)
    assert heard == served
    assert states.refused == 1
    assert states.skipped == (4 if newest else 0)
    executor.shutdown()
    node.destroy_node()
