"""The only seam between messages and the library: every field is checked on its way in.

A message that does not fit raises InputError, whose text names the topic's field and what is
wrong with it; nothing of it reaches the library.
"""

from __future__ import annotations

import math
from array import array
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped
from std_msgs.msg import Header

from lexstack.errors import InputError
from lexstack.options import shown
from lexstack.references import TOOL, Target
from lexstack.robots import Pose, Team, from_quaternion
from lexstack.transition import Announcement, SourceSample, TransitionState
from lexstack.types import RobotState, Vector
from lexstack_interfaces.msg import Chi, StackRequest, TransitionStatus

if TYPE_CHECKING:  # a bridge and a recorder need messages, and no controller
    from lexstack.control import Command

WORLD = "world"
Stamped = TypeVar("Stamped", bound=Any)
_HUGE = 1e6  # m, rad, m/s, rad/s: no robot gets there
_FARTHEST = 1000.0  # m, a target farther away is a mistake
_UNIT = 1e-2  # how far a quaternion's norm may be from 1
_UPRIGHT = 1e-3  # rad, how far a base target may be tilted
_NANOSECONDS = 1_000_000_000

Placing = Callable[[Header, str], Pose | None]
"""Finds the frame in which a message is told, at its stamp; None: it is the world.

It takes the topic, for errors, and raises InputError for a frame whose pose is not known.
"""


# ---- time


def to_time(seconds: float) -> Time:
    """Return simulated time [s] as a message."""
    nanoseconds = round(seconds * 1e9)
    return Time(sec=nanoseconds // 1_000_000_000, nanosec=nanoseconds % 1_000_000_000)


def to_seconds(stamp: Time) -> float:
    """Return a stamp in seconds."""
    return float(stamp.sec) + 1e-9 * float(stamp.nanosec)


def stamped(message: Stamped, seconds: float) -> Stamped:
    """Return a message with a header that says a time [s] and the world's frame."""
    message.header.stamp = to_time(seconds)
    message.header.frame_id = WORLD
    return message


# ---- vectors


def to_array(vector: Vector) -> array[float]:
    """Return a vector as the type that float64[] fields take without a copy per element."""
    return array("d", vector.tobytes())


def to_vector(values: Any, n: int, field: str) -> Vector:
    """Return a float64[] field as a new read-only vector (n,), finite; raises InputError."""
    vector = np.array(values, dtype=np.float64)
    if vector.shape != (n,):
        raise InputError(f"{field}: expected {n} values, got {vector.size}")
    # One sum says of nearly all vectors that no value is too large, infinite or none at all.
    if not vector.dot(vector) <= _HUGE * _HUGE:
        _check_values(vector, field)
    vector.setflags(write=False)
    return vector


def _check_values(vector: Vector, field: str) -> None:
    """Raise InputError for a vector with a value that is not finite, or beyond all robots."""
    if not np.isfinite(vector).all():
        where = int(np.flatnonzero(~np.isfinite(vector))[0])
        raise InputError(f"{field}[{where}]: must be finite, got {vector[where]}")
    largest = float(np.abs(vector).max(initial=0.0))
    if largest > _HUGE:
        raise InputError(f"{field}: out of range: {largest:g}, at most {_HUGE:g}")


def check_robots(robots: list[str], team: Team, where: str) -> None:
    """Raise InputError unless a message is about this team, in its order."""
    if tuple(robots) != team.names:
        raise InputError(
            f"{where}: robots: expected {', '.join(team.names)}, got {shown(list(robots))}"
        )


# ---- state, chi, transition


def to_state(message: Any, team: Team) -> RobotState:
    """Return the plant's state of a PlantState, generated or read; raises InputError."""
    where = "/plant/state"
    check_robots(message.robots, team, where)
    return RobotState(
        message.tick,
        to_seconds(message.header.stamp),
        to_vector(message.q, team.nq, f"{where}: q"),
        to_vector(message.v, team.n, f"{where}: v"),
        to_vector(message.q_star, team.nq, f"{where}: q_star"),
        to_vector(message.command, team.n, f"{where}: command"),
    )


def to_sample(message: Any, team: Team, where: str) -> SourceSample:
    """Return a source's Chi, of all robots or of some; raises InputError. ``where``: its topic."""
    robots = _some_robots(message.robots, team, where)
    slacks = to_vector(message.slacks, len(message.slacks), f"{where}: slacks")
    chi = to_vector(message.chi, team.columns(robots).size, f"{where}: chi")
    return SourceSample(
        message.transition_id,
        message.tick,
        chi if len(robots) == len(team.robots) else _among_all(chi, robots, team),
        message.status == Chi.SOLVED,
        float(slacks[0]) if slacks.size else None,
        None if len(robots) == len(team.robots) else robots,
        message.stack,
        message.references or None,
    )


def _some_robots(names: Sequence[str], team: Team, where: str) -> tuple[int, ...]:
    """Return the places of robots that are named in the team's order; raises InputError."""
    robots = tuple(i for i, name in enumerate(team.names) if name in names)
    if not robots or tuple(team.names[i] for i in robots) != tuple(names):
        raise InputError(
            f"{where}: robots: expected some of {', '.join(team.names)}, got {shown(list(names))}"
        )
    return robots


def _among_all(chi: Vector, robots: Sequence[int], team: Team) -> Vector:
    """Return the chi of some robots with zeros for the others, shape (n,)."""
    whole = np.zeros(team.n)
    whole[team.columns(robots)] = chi
    whole.setflags(write=False)
    return whole


def chi_of_command(command: Command, message: Chi) -> Chi:
    """Return the controller's command, written into ``message``."""
    message.header.stamp = to_time(command.stamp)
    message.tick = command.tick
    message.stack = command.stack
    message.transition_id = max(state.id for state in command.transitions)
    message.references = command.revision
    message.chi = to_array(command.chi)
    message.lower = to_array(command.bounds.lower)
    message.upper = to_array(command.bounds.upper)
    message.slacks = to_array(command.slacks)
    message.status = Chi.FALLBACK if command.fallback else Chi.SOLVED
    message.empty_bounds = command.bounds.empty
    message.solve_time = command.solve_time
    message.reason = command.fallback or command.near_singularity
    message.transitions = [transition_status(command, state) for state in command.transitions]
    return message


def transition_status(command: Command, state: TransitionState) -> TransitionStatus:
    """Return where one of a command's transitions stands."""
    message = stamped(TransitionStatus(), command.stamp)
    message.tick = command.tick
    for name in ("id", "from_stack", "to_stack", "method", "alpha", "duration", "gap", "reason"):
        setattr(message, name, getattr(state, name))
    message.source = state.source.value
    message.phase = state.phase.value
    message.robots = list(state.robots)
    return message


# ---- requests to a source


def stack_request(
    announcement: Announcement, stamp: float, team: Team, text: str = ""
) -> StackRequest:
    """Return an announcement as a message; ``text``: the stack's, where a user sent it."""
    message = stamped(StackRequest(), stamp)
    message.id = announcement.id
    message.stack = announcement.stack
    message.start_tick = announcement.start_tick
    message.active = announcement.active
    message.robots = [team.names[robot] for robot in announcement.robots]
    message.stack_yaml = text if announcement.active else ""
    return message


def to_announcement(message: StackRequest, stacks: Any, team: Team) -> Announcement:
    """Return a request to a source; raises InputError for a stack or robot that is not known."""
    where = "/robot_a/stack_request"
    if message.stack not in stacks:
        known = ", ".join(sorted(stacks))
        raise InputError(f"{where}: unknown stack {shown(message.stack)}; known: {known}")
    for name in message.robots:
        if name not in team.names:
            known = ", ".join(team.names)
            raise InputError(f"{where}: robots: unknown robot {shown(name)}; known: {known}")
    robots = tuple(sorted(team.names.index(name) for name in message.robots))
    return Announcement(message.id, message.stack, message.start_tick, message.active, robots)


# ---- targets


def in_world(header: Header, where: str) -> None:
    """Return that a message is told in the world; raises InputError for any other frame."""
    if header.frame_id not in ("", WORLD):
        raise InputError(f"{where}: frame_id: expected 'world', got {shown(header.frame_id)}")


def to_stamp(header: Header, where: str) -> float:
    """Return the stamp of a target [s]; raises InputError for one that is no time."""
    if header.stamp.sec < 0 or header.stamp.nanosec >= _NANOSECONDS:
        got = f"{header.stamp.sec} s and {header.stamp.nanosec} ns"
        raise InputError(f"{where}: header.stamp: expected a time from 0 on, got {got}")
    return to_seconds(header.stamp)


def to_ee_target(
    message: PoseStamped, robot: int, where: str, placing: Placing = in_world, frame: str = TOOL
) -> Target:
    """Return a target of a frame of the robot at place ``robot``; raises InputError."""
    stamp = to_stamp(message.header, where)
    pose = placed(placing(message.header, where), to_pose(message.pose, where), where)
    return Target(stamp, robot, ee=pose, frame=frame)


def to_base_target(
    message: PoseStamped, robot: int, where: str, placing: Placing = in_world
) -> Target:
    """Return a base target (x, y, yaw); raises InputError where it is not upright."""
    stamp = to_stamp(message.header, where)
    pose = placed(placing(message.header, where), to_pose(message.pose, where), where)
    return Target(stamp, robot, base=to_place(pose, where))


def to_place(pose: Pose, where: str) -> Vector:
    """Return x, y, yaw of a pose; raises InputError where it is not upright."""
    tilt = math.acos(min(max(float(pose.rotation[2, 2]), -1.0), 1.0))
    if tilt > _UPRIGHT:
        raise InputError(
            f"{where}: orientation: a base stands upright, got a tilt of {tilt:.3f} rad"
        )
    yaw = math.atan2(pose.rotation[1, 0], pose.rotation[0, 0])
    return np.array([pose.position[0], pose.position[1], yaw])


def placed(origin: Pose | None, pose: Pose, where: str) -> Pose:
    """Return a pose that is told in a frame, in the world; raises InputError: too far away."""
    if origin is not None:
        position = origin.position + origin.rotation @ pose.position
        pose = Pose(position, origin.rotation @ pose.rotation)
    farthest = float(np.max(np.abs(pose.position)))
    if farthest > _FARTHEST:
        raise InputError(f"{where}: position: {farthest:g} m away, at most {_FARTHEST:g} m")
    return pose


def pose_message(pose: Pose, stamp: float, quaternion: Vector) -> PoseStamped:
    """Return a pose in the world frame as a message."""
    message = stamped(PoseStamped(), stamp)
    place, turn = message.pose.position, message.pose.orientation
    place.x, place.y, place.z = (float(value) for value in pose.position)
    turn.x, turn.y, turn.z, turn.w = (float(value) for value in quaternion)
    return message


def to_pose(pose: Any, where: str) -> Pose:
    """Return a checked pose, in the frame of its message."""
    return to_placement(pose.position, pose.orientation, where)


def to_placement(place: Any, turn: Any, where: str) -> Pose:
    """Return a checked pose from a vector and a quaternion of a message."""
    position = to_vector([place.x, place.y, place.z], 3, f"{where}: position")
    quaternion = to_vector([turn.x, turn.y, turn.z, turn.w], 4, f"{where}: orientation")
    norm = float(np.linalg.norm(quaternion))
    if abs(norm - 1.0) > _UNIT:
        raise InputError(f"{where}: orientation: norm must be 1, got {norm:.4f}")
    return Pose(position, from_quaternion(quaternion))
