"""Frames: every robot's tree of links, below odom and base_link, where pinocchio has them."""

from __future__ import annotations

import types
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from rclpy.qos import DurabilityPolicy, ReliabilityPolicy
from rclpy.serialization import deserialize_message, serialize_message
from rosbags.typesys import Stores, get_typestore
from tf2_msgs.msg import TFMessage

from lexstack.robots import RobotModel, Team
from lexstack_config.resolved import load_robot
from lexstack_plant.frames import FrameTopics, static_transforms
from lexstack_sim.urdf import robot_urdf
from support.scenario import random_q, team

ROBOTS = sorted((Path(__file__).parents[3] / "config/robots").glob("*.yaml"))
JAZZY = get_typestore(Stores.ROS2_JAZZY)


class FakeNode:
    """A node that keeps what is published, by topic."""

    def __init__(self, listeners=1):
        self.published, self.qos, self.listeners = {}, {}, listeners

    def create_publisher(self, _kind, topic, qos):
        self.published[topic], self.qos[topic] = [], qos
        return types.SimpleNamespace(
            publish=self.published[topic].append, get_subscription_count=lambda: self.listeners
        )


def pose_of(transform):
    place, turn = transform.transform.translation, transform.transform.rotation
    rotation = pin.Quaternion(turn.w, turn.x, turn.y, turn.z).toRotationMatrix()
    return pin.SE3(rotation, np.array([place.x, place.y, place.z]))


def tree_of(group, q):
    """Return parent and pose of every frame at q, by name; a frame has one parent."""
    topics = FrameTopics(FakeNode(), group)
    moving = deserialize_message(topics.message(1.0, q), TFMessage)
    transforms = [*static_transforms(group), *moving.transforms]
    found = {t.child_frame_id: (t.header.frame_id, pose_of(t)) for t in transforms}
    assert len(found) == len(transforms)
    return found


def in_world(tree, frame):
    pose = pin.SE3.Identity()
    while frame != "world":
        frame, step = tree[frame]
        pose = step * pose
    return pose


@pytest.mark.parametrize("path", ROBOTS, ids=lambda path: path.stem)
def test_the_links_of_every_robot_are_where_pinocchio_has_them(path):
    robot = RobotModel("one", load_robot(path))
    group = Team((robot,), 0.01)
    q = group.home() + np.random.default_rng(3).uniform(-0.2, 0.2, group.nq)
    tree = tree_of(group, q)
    text = robot_urdf(robot)
    links = {link.get("name") for link in ET.fromstring(text).findall("link")}
    assert {f"one/{link}" for link in links} <= tree.keys()
    model, data = robot.pinocchio, robot.pinocchio.createData()
    pin.framesForwardKinematics(model, data, robot.positions(q))
    compared = 0
    for link in links - {"world"}:
        if model.existFrame(link, pin.FrameType.BODY):
            expected = data.oMf[model.getFrameId(link, pin.FrameType.BODY)]
            assert in_world(tree, f"one/{link}").isApprox(expected, 1e-9), link
            compared += 1
    assert compared >= 2
    tool, _ = robot.tool(q)
    assert np.allclose(in_world(tree, "one/tool").translation, tool.position)
    assert np.allclose(in_world(tree, "one/tool").rotation, tool.rotation)


def test_odom_is_below_the_world_and_base_link_below_odom():
    q = random_q(np.random.default_rng(8))
    tree = tree_of(team(), q)
    for robot, part in zip(team().robots, team().q_slices, strict=True):
        assert tree[f"{robot.name}/odom"][0] == "world"
        frame, above = f"{robot.name}/base_link", []
        while frame != "world":
            frame = tree[frame][0]
            above.append(frame)
        assert f"{robot.name}/odom" in above
        pose = in_world(tree, f"{robot.name}/base_link")
        x, y, yaw = q[part][:3]
        assert np.allclose(pose.translation, (x, y, 0.0))
        assert np.allclose(pose.rotation, pin.rpy.rpyToMatrix(0.0, 0.0, yaw))


def test_what_stands_is_told_once_and_kept_what_moves_as_tf2_listens():
    node = FakeNode()
    FrameTopics(node, team())
    assert len(node.published["tf_static"]) == 1
    assert node.qos["tf_static"].durability == DurabilityPolicy.TRANSIENT_LOCAL
    for topic in ("tf", "tf_static"):
        assert node.qos[topic].reliability == ReliabilityPolicy.RELIABLE
    assert node.qos["tf"].durability == DurabilityPolicy.VOLATILE


def test_nothing_is_told_where_nobody_listens():
    for listeners in (0, 1):
        node = FakeNode(listeners=listeners)
        FrameTopics(node, team()).publish(0.0, team().home())
        assert len(node.published["tf"]) == listeners


def test_the_message_is_that_of_jazzy():
    topics = FrameTopics(FakeNode(), team())
    topics.message(7.0, team().home() + 0.1)
    data = topics.message(2.5, team().home())
    heard = JAZZY.deserialize_cdr(data, "tf2_msgs/msg/TFMessage")
    assert len(heard.transforms) == 2 * 10
    stamps = {(t.header.stamp.sec, t.header.stamp.nanosec) for t in heard.transforms}
    assert stamps == {(2, 500_000_000)}
    message = deserialize_message(data, TFMessage)
    assert deserialize_message(serialize_message(message), TFMessage) == message
