"""Frames: the robots' trees hang in the world, where tf2_msgs is installed."""

import sys
import types

from rclpy.qos import DurabilityPolicy

from lexstack_sim.topics import tie_frames, tied


class Message:
    """Stands for tf2_msgs/TFMessage, which the wheels do not have."""

    def __init__(self, transforms):
        self.transforms = transforms


class FakeNode:
    """A node that keeps what is published."""

    def __init__(self):
        self.published = []

    def create_publisher(self, kind, topic, qos):
        self.created = (kind, topic, qos)
        return types.SimpleNamespace(publish=self.published.append)


def test_the_root_of_every_robot_is_the_world():
    transform = tied("robot_a")
    assert (transform.header.frame_id, transform.child_frame_id) == ("world", "robot_a/world")
    turn, place = transform.transform.rotation, transform.transform.translation
    assert (turn.x, turn.y, turn.z, turn.w) == (0.0, 0.0, 0.0, 1.0)
    assert (place.x, place.y, place.z) == (0.0, 0.0, 0.0)


def test_frames_are_published_once_and_latched_where_the_message_is_installed(monkeypatch):
    package = types.ModuleType("tf2_msgs.msg")
    package.TFMessage = Message
    monkeypatch.setitem(sys.modules, "tf2_msgs", types.ModuleType("tf2_msgs"))
    monkeypatch.setitem(sys.modules, "tf2_msgs.msg", package)
    node = FakeNode()
    assert tie_frames(node, ["robot_a", "robot_b"]) is not None
    kind, topic, qos = node.created
    assert (kind, topic, qos.durability) == (
        Message,
        "/tf_static",
        DurabilityPolicy.TRANSIENT_LOCAL,
    )
    (message,) = node.published
    assert [t.child_frame_id for t in message.transforms] == ["robot_a/world", "robot_b/world"]


def test_without_the_message_there_are_no_frames(monkeypatch):
    monkeypatch.setitem(sys.modules, "tf2_msgs", None)
    node = FakeNode()
    assert tie_frames(node, ["robot_a"]) is None
    assert node.published == []
