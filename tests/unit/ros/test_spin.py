"""What garbage leaves in the middleware is taken all the same."""

import time

import pytest
import rclpy
from rclpy.experimental import EventsExecutor
from rclpy.serialization import serialize_message
from std_msgs.msg import String

from lexstack_core.errors import ConfigurationError
from lexstack_ros.domain import own_domain
from lexstack_ros.spin import begin_ros, sweep
from lexstack_ros.staleness import with_info


@pytest.fixture
def context(monkeypatch):
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)
    with own_domain() as domain:
        context = rclpy.Context()
        rclpy.init(context=context, domain_id=domain)
        yield context
        rclpy.shutdown(context=context)


@pytest.mark.parametrize("informed", [False, True])
def test_good_messages_between_bytes_that_are_none_are_all_taken_in_order(context, informed):
    node = rclpy.create_node("listener", context=context)
    executor = EventsExecutor(context=context)
    heard = []
    if informed:
        callback = with_info(lambda message, info: heard.append((message.data, len(info) > 1)))
    else:
        callback = lambda message: heard.append((message.data, True))  # noqa: E731
    node.create_subscription(String, "/words", callback, 100)
    out = node.create_publisher(String, "/words", 100)
    executor.add_node(node)
    end = time.monotonic() + 10.0
    while out.get_subscription_count() == 0 and time.monotonic() < end:
        executor.spin_once(timeout_sec=0.05)
    for number in range(20):
        out.publish(b"\x00\x01")
        out.publish(serialize_message(String(data=str(number))))
        out.publish(b"\x00\x01\x00\x00\xff\xff\xff\xff")
    last = 0.0
    while len(heard) < 20 and time.monotonic() < end:
        executor.spin_once(timeout_sec=0.05)
        last = sweep(node, last)
    executor.shutdown()
    node.destroy_node()
    assert heard == [(str(number), True) for number in range(20)]


@pytest.mark.parametrize(
    ("arguments", "what"),
    [
        (["node", "--ros-args", "-p", "x"], "arguments of the node: failed to initialize"),
        (["node", "--ros-args", "--nonsense"], "--nonsense"),
        (["node", "--what"], "unknown '--what'"),
    ],
)
def test_wrong_arguments_are_a_configuration_error(arguments, what):
    with pytest.raises(ConfigurationError) as error:
        begin_ros(arguments)
    assert what in str(error.value)
    assert "\n" not in str(error.value)
    assert not rclpy.ok()
