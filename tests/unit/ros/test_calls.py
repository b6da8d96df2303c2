"""Calls with a deadline: a server knows a client before it is asked, and nobody waits for ever."""

import time

import pytest
from rclpy.experimental import EventsExecutor
from rclpy.node import Node
from std_srvs.srv import Trigger

from lexstack_ros.node import calls
from lexstack_testing.ros_session import ros_session


@pytest.fixture
def asking():
    """Yield a node that calls, and its executor."""
    with ros_session(children=False) as context:
        node = Node("asks", context=context)
        executor = EventsExecutor(context=context)
        executor.add_node(node)
        yield node, executor
        executor.shutdown()
        node.destroy_node()


def test_a_new_client_lets_the_server_know_it_before_it_asks(asking, monkeypatch):
    """The middleware loses the answer to a client that the server does not know yet."""
    node, executor = asking
    asked = []

    def serve(_, response):
        asked.append(time.monotonic())
        response.success = True
        return response

    node.create_service(Trigger, "/serves", serve)
    ready = []
    made = node.create_client

    def watched(kind, name):
        client = made(kind, name)
        is_ready = client.service_is_ready

        def seen():
            if is_ready() and not ready:
                ready.append(time.monotonic())
            return bool(ready)

        client.service_is_ready = seen
        return client

    monkeypatch.setattr(node, "create_client", watched)
    assert calls.call(node, executor, Trigger, "/serves", Trigger.Request(), 20.0).success
    assert asked[0] - ready[0] >= 0.3
    assert not list(node.clients), "the client is gone"


def test_nobody_serves_a_name_is_said_with_the_name(asking):
    node, executor = asking
    with pytest.raises(calls.NoAnswerError, match=r"/missing: nobody serves it within 0\.2 s"):
        calls.call(node, executor, Trigger, "/missing", Trigger.Request(), 0.2)
    assert not list(node.clients), "the client is gone"
