"""What a fuzzer does to messages: any bytes as any message that a node hears."""

from __future__ import annotations

from array import array
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
from geometry_msgs.msg import PoseStamped
from rclpy.serialization import deserialize_message, serialize_message
from std_msgs.msg import String

from lexstack.control import Controller
from lexstack.errors import LexstackError
from lexstack.types import RobotState
from lexstack_experiments.loop import Loop
from lexstack_interfaces.msg import Chi, PlantState, StackRequest
from lexstack_interfaces.srv import ApplyWrench, SwitchStack
from lexstack_ros.intake.tick_order import TickOrder
from lexstack_ros.messages import conversions
from lexstack_ros.node.sole_sender import SoleSender
from support.fuzz_config import check_short
from support.plants import make_plant
from support.scenario import home, resolved, team

SENDER = "plant@host/1/00000000"


def state(message: PlantState) -> None:
    """Hear a state as the controllers do, and answer it: the command is inside its bounds."""
    sender, order = SoleSender("/plant/state"), TickOrder("/plant/state")
    sender.follow(SENDER)
    sender.check(message.sender)
    value = conversions.to_state(message, team())
    if order.is_new(message.sender, message.resets, value.tick):
        answer(value)


def answer(value: RobotState) -> None:
    """Compute the controller's command for a state, whatever the state is."""
    command = controller().tick(value)
    assert np.isfinite(command.chi).all(), command.fallback
    assert (command.bounds.lower <= command.chi).all()
    assert (command.chi <= command.bounds.upper).all()


def switch(request: SwitchStack.Request) -> None:
    """Ask for a switch; the answer is a value."""
    answer_ = transition().ask(request.stack, request.duration, request.method, request.at_tick)
    check_short(answer_.message)
    assert answer_.accepted == (answer_.request is not None)


def ask_by_topic(message: String) -> None:
    """Ask for a switch by topic."""
    answer_ = transition().request(message.data)
    check_short(answer_.message)


def wrench(request: ApplyWrench.Request) -> None:
    """Push a link."""
    force, torque = request.wrench.force, request.wrench.torque
    plant().apply_wrench(
        request.robot,
        request.link,
        np.array([force.x, force.y, force.z]),
        np.array([torque.x, torque.y, torque.z]),
        request.duration,
    )


TARGETS: dict[Any, Callable[[Any], object]] = {
    PlantState: state,
    Chi: lambda message: conversions.to_sample(message, team(), "/robot_b/chi"),
    StackRequest: lambda message: conversions.to_announcement(
        message, tuple(resolved().stacks), team()
    ),
    PoseStamped: lambda message: (
        conversions.to_ee_target(message, 0, "/robot_a/ee_target"),
        conversions.to_base_target(message, 1, "/robot_b/base_target"),
    ),
    SwitchStack.Request: switch,
    String: ask_by_topic,
    ApplyWrench.Request: wrench,
}


def seeds() -> list[bytes]:
    """Return a good message of every kind, with the kind's number in front."""
    return [bytes([number]) + serialize_message(good(kind)) for number, kind in enumerate(TARGETS)]


def good(kind: Any) -> Any:  # noqa: PLR0911 - one per kind
    """Return a message that is taken."""
    names, n = list(team().names), team().n
    zeros = array("d", [0.0] * n)
    if kind is PlantState:
        q = conversions.to_array(home())
        values = {"q": q, "q_star": q, "v": zeros, "command": zeros}
        return PlantState(sender=SENDER, robots=names, tick=3, **values)
    if kind is Chi:
        return Chi(sender="b@host/2/0", robots=names, chi=zeros, lower=zeros, upper=zeros)
    if kind is StackRequest:
        return StackRequest(id=1, stack="posture", robots=names, start_tick=5, active=True)
    if kind is PoseStamped:
        pose = PoseStamped()
        pose.header.frame_id, pose.pose.orientation.w = "world", 1.0
        return pose
    if kind is SwitchStack.Request:
        return SwitchStack.Request(stack="posture", duration=1.0, method="bridge", at_tick=9)
    if kind is String:
        return String(data="posture")
    push = ApplyWrench.Request(robot="robot_a", link="tool", duration=0.1)
    push.wrench.force.x = 1.0
    return push


def one(data: bytes) -> bool:
    """Deserialise and take one message; returns whether it was taken."""
    if not data:
        return False
    kind = list(TARGETS)[data[0] % len(TARGETS)]
    try:
        message = deserialize_message(data[1:], kind)
    except (RuntimeError, UnicodeDecodeError, SystemError):
        return False  # the middleware drops it
    return take(message)


def take(message: Any) -> bool:
    """Take one message as the node does; returns whether it fitted."""
    try:
        TARGETS[type(message)](message)
    except LexstackError as error:
        check_short(str(error))
        return False
    return True


@cache
def controller() -> Controller:
    """Return a controller of the default scenario."""
    return Loop(resolved()).controller


def transition() -> Any:
    """Return its transition, with room for one more request."""
    found = controller().transition
    found.cancel()
    return found


@cache
def plant() -> Any:
    """Return a plant to push."""
    return make_plant()
