"""Frames: the robots' trees hang in the world, where tf2_msgs is installed."""

import sys
import types
import xml.etree.ElementTree as ET

from geometry_msgs.msg import TransformStamped
from rclpy.qos import DurabilityPolicy, ReliabilityPolicy
from rclpy.serialization import serialize_message
from rosbags.typesys import Stores, get_typestore

from lexstack_plant.topics import tie_frames, tied
from lexstack_sim.urdf import robot_urdf
from support.scenario import team

JAZZY = get_typestore(Stores.ROS2_JAZZY)
KIND = "tf2_msgs/msg/TFMessage"


class Message:
    """tf2_msgs/TFMessage as Jazzy defines it; the wheels do not have it, rosbags does."""

    def __new__(cls, **fields):
        """Take fields of rclpy's messages, through their bytes, as a generated class does."""
        transforms = [
            JAZZY.deserialize_cdr(serialize_message(each), "geometry_msgs/msg/TransformStamped")
            for each in fields.pop("transforms")
            if isinstance(each, TransformStamped)
        ]
        return JAZZY.types[KIND](transforms=transforms, **fields)


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
    assert (kind, topic) == (Message, "tf_static"), "relative: a cell ties its own frames"
    assert qos.durability == DurabilityPolicy.TRANSIENT_LOCAL
    assert qos.reliability == ReliabilityPolicy.RELIABLE
    (message,) = node.published
    heard = JAZZY.deserialize_cdr(JAZZY.serialize_cdr(message, KIND), KIND)
    assert [t.child_frame_id for t in heard.transforms] == ["robot_a/world", "robot_b/world"]
    assert {t.header.frame_id for t in heard.transforms} == {"world"}
    assert {t.transform.rotation.w for t in heard.transforms} == {1.0}


def test_what_is_tied_is_the_root_of_the_tree_that_the_description_has():
    """robot_state_publisher puts NAME/ before the links of the description."""
    for robot in team().robots:
        parsed = ET.fromstring(robot_urdf(robot))
        links = {link.get("name") for link in parsed.iter("link")}
        (root,) = links - {child.get("link") for child in parsed.iter("child")}
        assert tied(robot.name).child_frame_id == f"{robot.name}/{root}"


def test_without_the_message_there_are_no_frames(monkeypatch):
    monkeypatch.setitem(sys.modules, "tf2_msgs", None)
    node = FakeNode()
    assert tie_frames(node, ["robot_a"]) is None
    assert node.published == []
