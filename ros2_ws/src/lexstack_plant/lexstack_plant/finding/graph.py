"""What runs now, from the ROS graph, a message of each JointState, and controllers' parameters."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

from rcl_interfaces.msg import ParameterValue
from rcl_interfaces.srv import GetParameters
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import JointState

from lexstack_plant.finding.endpoints import COMMANDS, JOINT_STATE, STATES, VALUES, Endpoint
from lexstack_ros.node.calls import NoAnswerError, call, wait_until

_ANSWER = 2.0  # s of wall time for a controller's parameters
_STATES = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
_JOINTS, _INTERFACE = "joints", "interface_name"  # of controllers of ros2_controllers


def find_endpoints(node: Node, executor: Executor, seconds: float) -> list[Endpoint]:
    """Return what there is after ``seconds`` of wall time in which others may be discovered.

    A controller that has parameters ``joints`` and ``interface_name``, as those of
    ros2_controllers have, says by them what it moves.
    """
    wait_until(executor, lambda: False, seconds)
    found = []
    for topic, kinds in node.get_topic_names_and_types():
        for kind in kinds:
            if kind in STATES and _others(node.get_publishers_info_by_topic(topic), node, kind):
                found.append(Endpoint(topic, kind))
            listeners = _others(node.get_subscriptions_info_by_topic(topic), node, kind)
            if kind in COMMANDS and listeners:
                asked = partial(_parameter, node, executor, listeners[0])
                found.append(_commanded(Endpoint(topic, kind), asked))
    return _with_joints(node, executor, found, seconds)


def _others(infos: list[Any], node: Node, kind: str) -> list[str]:
    """Return the nodes at the ends of a topic, from the root, but for our own."""
    return [
        f"{info.node_namespace.rstrip('/')}/{info.node_name}"
        for info in infos
        if info.topic_type == kind and info.node_name != node.get_name()
    ]


def _commanded(endpoint: Endpoint, asked: Callable[[str], ParameterValue]) -> Endpoint:
    """Return a topic of commands with what its listener's parameters say."""
    joints = tuple(asked(_JOINTS).string_array_value)
    interface = asked(_INTERFACE).string_value if endpoint.kind == VALUES else ""
    return replace(endpoint, joints=joints, interface=interface)


def _parameter(node: Node, executor: Executor, listener: str, name: str) -> ParameterValue:
    """Return a parameter of a node; empty where it has none, or does not answer.

    One is asked at a time: a node returns none at all where it lacks one of them.
    """
    service = f"{listener}/get_parameters"
    nothing = ParameterValue()
    if service not in dict(node.get_service_names_and_types()):
        return nothing
    request = GetParameters.Request(names=[name])
    try:
        answer = call(node, executor, GetParameters, service, request, _ANSWER)
    except NoAnswerError:
        return nothing
    return answer.values[0] if answer.values else nothing


def _with_joints(
    node: Node, executor: Executor, found: list[Endpoint], seconds: float
) -> list[Endpoint]:
    """Return endpoints with the joints of messages that come within ``seconds``."""
    names: dict[str, dict[str, None]] = {e.topic: {} for e in found if e.kind == JOINT_STATE}

    def hear(topic: str, message: JointState) -> None:
        names[topic].update(dict.fromkeys(message.name))

    heard = [
        node.create_subscription(JointState, topic, partial(hear, topic), _STATES)
        for topic in names
    ]
    # One topic may have several publishers: all get the same time.
    wait_until(executor, lambda: False, seconds if heard else 0.0)
    for subscription in heard:
        node.destroy_subscription(subscription)
    return [
        replace(each, joints=tuple(names[each.topic])) if each.kind == JOINT_STATE else each
        for each in found
    ]
