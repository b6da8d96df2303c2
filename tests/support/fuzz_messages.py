"""What a fuzzer does to messages: any bytes as any message that a node hears."""

from __future__ import annotations

from array import array
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
from geometry_msgs.msg import PoseStamped, Transform, TransformStamped, TwistStamped
from nav_msgs.msg import Path
from rclpy.serialization import deserialize_message, serialize_message
from std_msgs.msg import String
from trajectory_msgs.msg import (
    JointTrajectory,
    JointTrajectoryPoint,
    MultiDOFJointTrajectory,
    MultiDOFJointTrajectoryPoint,
)

from lexstack.control import Controller
from lexstack.errors import LexstackError
from lexstack.references import ReferenceSchedule, measured
from lexstack.types import RobotState
from lexstack_config.reference_topics import ReferenceTopicsConfig
from lexstack_experiments.loop import Loop
from lexstack_interfaces.msg import Chi, PlantState, References, StackRequest
from lexstack_interfaces.srv import ApplyWrench, SwitchStack
from lexstack_ros.intake.frames import Frames
from lexstack_ros.intake.tick_order import TickOrder
from lexstack_ros.messages import conversions, targets
from lexstack_ros.messages.references import references_message, to_setting
from lexstack_ros.messages.target_points import Reading
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


def target(read: Callable[[Any, Reading], Any]) -> Callable[[Any], None]:
    """Return what takes a target and follows it for a while: every reference is finite."""

    def take_(message: Any) -> None:
        value = RobotState(3, 0.03, home(), 0.0 * home(), home(), 0.0 * home())
        frames = Frames(team())
        frames.see(value)
        schedule = ReferenceSchedule(measured(team(), home()), lead_in=0.5, horizon=60.0, dt=0.01)
        schedule.decide(0.03)
        options = ReferenceTopicsConfig()
        reading = Reading(
            team(), 0, "tool", "/robot_a/topic", frames, schedule.next, options, value
        )
        for one_ in list(read(message, reading)):
            schedule.add(one_)
        for stamp in (0.04, 0.5, 59.0, 70.0):
            found = schedule.at(stamp)
            assert np.isfinite(found.ee[0].position).all()
            assert np.isfinite(found.base[0]).all()
            assert all(np.isfinite(p).all() for p in found.motion.postures.values())
        sent = references_message(schedule.timeline.newest, team(), "me")
        assert to_setting(sent, team(), "here").revision == schedule.timeline.newest.revision

    return take_


def transforms(message: TransformStamped) -> None:
    """Hear a transform, and look for its frame."""
    frames = Frames(team())
    frames.transforms.hear([message])
    pose = PoseStamped()
    pose.header.frame_id = message.child_frame_id
    frames(pose.header, "/robot_a/ee_target")


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
    TwistStamped: target(targets.to_twist),
    MultiDOFJointTrajectory: target(targets.to_way),
    Path: target(targets.to_path),
    JointTrajectory: target(targets.to_posture),
    References: lambda message: to_setting(message, team(), "/robot_a/references"),
    TransformStamped: transforms,
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
    if kind in MOVING:
        return good_target(kind)
    if kind is SwitchStack.Request:
        return SwitchStack.Request(stack="posture", duration=1.0, method="bridge", at_tick=9)
    if kind is String:
        return String(data="posture")
    push = ApplyWrench.Request(robot="robot_a", link="tool", duration=0.1)
    push.wrench.force.x = 1.0
    return push


def _reading() -> Reading:
    """Return what a message for the first robot is read with."""
    options = ReferenceTopicsConfig()
    return Reading(team(), 0, "tool", "/robot_a/topic", Frames(team()), 0.0, options, None)


MOVING = (
    *(TwistStamped, MultiDOFJointTrajectory, Path, JointTrajectory, TransformStamped, References),
)


def good_target(kind: Any) -> Any:
    """Return a target that moves, or what tells of one."""
    if kind is TransformStamped:
        message = TransformStamped(child_frame_id="camera")
        message.header.frame_id, message.transform.rotation.w = "world", 1.0
        return message
    if kind is References:
        schedule = ReferenceSchedule(measured(team(), home()), dt=0.01)
        for one_ in targets.to_way(good_target(MultiDOFJointTrajectory), _reading()):
            schedule.add(one_)
        schedule.decide(0.0)
        return references_message(schedule.timeline.newest, team(), "me")
    if kind is TwistStamped:
        message = TwistStamped()
        message.twist.linear.x = 0.1
        return message
    if kind is Path:
        poses = [good(PoseStamped) for _ in range(3)]
        for k, pose in enumerate(poses):
            pose.header.stamp.sec, pose.pose.position.x = k + 1, 0.2 * k
            pose.header.frame_id = ""  # the path's
        return Path(poses=poses)
    message, joints = kind(), team().robots[0].joints[3:]
    for k in range(2):
        point: Any
        if kind is MultiDOFJointTrajectory:
            point = MultiDOFJointTrajectoryPoint(transforms=[Transform()])
            point.transforms[0].rotation.w = 1.0
        else:
            message.joint_names = list(joints)
            point = JointTrajectoryPoint(positions=home()[3:10].tolist())
        point.time_from_start.sec = k + 1
        message.points.append(point)
    return message


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
