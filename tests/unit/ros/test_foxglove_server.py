"""Foxglove's server: topics as they are, to those who ask; meshes and no other files."""

from __future__ import annotations

import sys
import time

import foxglove
import pytest
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.serialization import serialize_message
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String

from lexstack.errors import ConfigurationError
from lexstack_ros.messages.qos import LATCHED, STREAM
from lexstack_ros.view.foxglove import Foxglove, check_foxglove
from lexstack_ros.view.meshes import meshes_of
from lexstack_testing.ros_session import ros_session
from support.foxglove_client import Client
from support.scenario import team

PATIENCE = 20.0  # s


class Served:
    """A node with a server, publishers beside it, and clients of the server."""

    def __init__(self, node, served):
        self.node, self.server, self.clients = node, served, []
        self.executor = SingleThreadedExecutor(context=node.context)
        self.executor.add_node(node)

    def client(self):
        self.clients.append(Client(self.server.url))
        return self.clients[-1]

    def until(self, condition, *, meanwhile=lambda: None):
        end = time.monotonic() + PATIENCE
        while not condition():
            assert time.monotonic() < end, "waited in vain"
            meanwhile()
            self.executor.spin_once(timeout_sec=0.02)
            for client in self.clients:
                client.take()


@pytest.fixture
def served():
    with ros_session(children=False) as context:
        node = rclpy.create_node("shows", context=context)
        found = Served(node, Foxglove(node, 0, meshes_of(team())))
        yield found
        for client in found.clients:
            client.close()
        found.server.close()
        node.destroy_node()


def test_messages_go_on_as_they_came_and_only_while_somebody_looks(served):
    out = served.node.create_publisher(String, "words", STREAM)
    client = served.client()
    served.until(lambda: "/words" in client.channels)
    channel = client.channels["/words"]
    assert (channel["encoding"], channel["schemaEncoding"]) == ("cdr", "ros2msg")
    assert channel["schemaName"] == "std_msgs/msg/String"
    assert "string data" in channel["schema"]
    assert out.get_subscription_count() == 0
    client.subscribe("/words", 7)
    message = String(data="as it is")
    served.until(lambda: client.heard, meanwhile=lambda: out.publish(message))
    assert {number for number, _, _ in client.heard} == {7}
    assert client.heard[0][2] == serialize_message(message)
    client.close()
    served.clients.clear()
    served.until(lambda: out.get_subscription_count() == 0)


def test_who_comes_late_has_the_latched_message_too(served):
    out = served.node.create_publisher(String, "robot_description", LATCHED)
    out.publish(String(data="<robot/>"))
    for _ in range(2):
        client = served.client()
        served.until(lambda c=client: "/robot_description" in c.channels)
        client.subscribe("/robot_description")
        served.until(lambda c=client: c.heard)
        assert b"<robot/>" in client.heard[0][2]


def test_time_is_the_simulated_one_where_there_is_a_clock(served):
    clock = served.node.create_publisher(Clock, "/clock", STREAM)
    out = served.node.create_publisher(String, "words", STREAM)
    client = served.client()
    served.until(lambda: "/words" in client.channels)
    client.subscribe("/words")
    now = Clock()
    now.clock.sec, now.clock.nanosec = 12, 345

    def tick():
        clock.publish(now)
        out.publish(String(data="x"))

    served.until(lambda: 12_000_000_345 in client.times, meanwhile=tick)
    served.until(lambda: client.heard and client.heard[-1][1] == 12_000_000_345, meanwhile=tick)


def test_what_is_no_clock_is_left_out(served):
    before = Clock()
    before.clock.sec = -1
    good = Clock()
    good.clock.sec = 3
    for data in (b"", b"\x00", serialize_message(good)[:9], serialize_message(before)):
        served.server._on_clock(data)
        assert served.server._now is None
    served.server._on_clock(serialize_message(good))
    assert served.server._now == 3_000_000_000


def test_nobody_can_publish_call_or_read_other_files(served):
    client = served.client()
    mesh, path = next(iter(meshes_of(team()).items()))
    client.fetch(mesh, 1)
    client.fetch("file:///etc/passwd", 2)
    client.fetch("package://example-robot-data/../../../../etc/passwd", 3)
    served.until(lambda: client.info and len(client.assets) == 3)
    assert set(client.info["capabilities"]) == {"time", "assets"}
    assert client.assets[1] == (0, path.read_bytes())
    assert [client.assets[number][0] for number in (2, 3)] == [1, 1]


def test_every_mesh_of_the_robots_is_found():
    found = meshes_of(team())
    assert len(found) >= 16
    assert all(path.is_file() for path in found.values())
    assert all(name.startswith("package://") for name in found)


@pytest.mark.parametrize("port", ["-1", "65536", "x", "", "８", "1e3", "9" * 5000])
def test_a_port_that_is_none_is_refused(port):
    with pytest.raises(ConfigurationError, match="foxglove: expected a port from 0 to 65535"):
        check_foxglove(port)


def test_a_port_that_is_taken_is_told(served):
    port = served.server.url.rpartition(":")[2]
    with pytest.raises(ConfigurationError, match=f"port {port}"):
        Foxglove(served.node, int(port))


def test_where_the_package_is_missing_one_line_says_so(monkeypatch):
    monkeypatch.setitem(sys.modules, "foxglove", None)
    with pytest.raises(ConfigurationError, match="pip install foxglove-sdk"):
        check_foxglove("8765")


def test_a_package_of_the_same_name_is_not_taken_for_it(monkeypatch):
    monkeypatch.delattr(foxglove, "start_server")
    with pytest.raises(ConfigurationError, match="pip install foxglove-sdk"):
        check_foxglove("8765")
