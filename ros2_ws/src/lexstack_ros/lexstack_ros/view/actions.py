"""Carries out what the live page asks for, by the topics and services that anybody may use."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from typing import Any

import numpy as np
from geometry_msgs.msg import PoseStamped
from rclpy.node import Node
from std_srvs.srv import Trigger

from lexstack.references import References
from lexstack.robots import Pose, Team, from_rpy, to_quaternion
from lexstack_interfaces.srv import ApplyWrench, SwitchStack
from lexstack_ros.messages.conversions import pose_message
from lexstack_ros.messages.qos import STREAM
from lexstack_ros.view.orders import Cancel, NewTarget, Order, Push, Switch
from lexstack_ros.view.server import ViewError


class Actions:
    """Publishers and clients of a node that is a user of the run."""

    def __init__(self, node: Node, team: Team, present: Callable[[], References]) -> None:
        """Make them; ``present`` returns the references in effect."""
        self._team = team
        self._present = present
        self._targets = {
            (name, kind): node.create_publisher(PoseStamped, f"{name}/{kind}", STREAM)
            for name in team.names
            for kind in ("ee_target", "base_target")
        }
        self._switch = node.create_client(SwitchStack, "robot_a/switch_stack")
        self._cancel = node.create_client(Trigger, "robot_a/cancel_transition")
        self._push = node.create_client(ApplyWrench, "sim_bridge/apply_wrench")

    def carry_out(self, order: Order, answer: Future[str]) -> None:
        """Do what was asked; the answer comes now, or when the service has answered."""
        try:
            match order:
                case Switch():
                    request = SwitchStack.Request(stack=order.stack, duration=order.duration)
                    _call(self._switch, request, answer, lambda said: said.accepted)
                case Cancel():
                    _call(self._cancel, Trigger.Request(), answer, lambda said: said.success)
                case Push():
                    _call(self._push, _wrench(order), answer, lambda said: said.success)
                case NewTarget():
                    answer.set_result(self._send_target(order))
        except ViewError as error:
            answer.set_exception(error)

    def _send_target(self, order: NewTarget) -> str:
        """Publish a reference from now on; an end effector keeps its direction."""
        if order.kind == "ee":
            held = self._present().ee[self._team.index(order.robot)]
            pose = Pose(np.array(order.values), held.rotation)
        else:
            x, y, yaw = order.values
            pose = Pose(np.array([x, y, 0.0]), from_rpy((0.0, 0.0, yaw)))
        message = pose_message(pose, 0.0, to_quaternion(pose.rotation))
        self._targets[order.robot, f"{order.kind}_target"].publish(message)
        return f"target sent: {order.robot}, {order.kind}"


def _call(client: Any, request: Any, answer: Future[str], is_yes: Callable[[Any], bool]) -> None:
    """Call a service; its message becomes the answer, or the reason of a refusal."""
    if not client.service_is_ready():
        raise ViewError(f"{client.service_name} is not there")

    def done(future: Any) -> None:
        said = future.result()
        if is_yes(said):
            answer.set_result(said.message or "done")
        else:
            answer.set_exception(ViewError(said.message or "refused"))

    client.call_async(request).add_done_callback(done)


def _wrench(order: Push) -> ApplyWrench.Request:
    """Return the service's request."""
    request = ApplyWrench.Request(robot=order.robot, link=order.link, duration=order.duration)
    force = request.wrench.force
    force.x, force.y, force.z = order.force
    return request
