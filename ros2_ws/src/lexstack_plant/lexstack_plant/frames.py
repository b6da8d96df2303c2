"""/tf and /tf_static: the links of all robots, below odom and base_link of REP-105."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from geometry_msgs.msg import TransformStamped
from rclpy.node import Node
from rclpy.serialization import serialize_message
from tf2_msgs.msg import TFMessage

from lexstack.robots import RobotModel, Team
from lexstack.types import Matrix, Vector
from lexstack_ros.messages.conversions import WORLD, to_time
from lexstack_ros.messages.qos import LATCHED, STREAM
from lexstack_sim.link_frames import LinkFrames

_HEAD = 4  # bytes before the content of a serialised message
_MARK = 987_654_321
_BASE_LINK = "base_link"


class FrameTopics:
    """The tree that robot_state_publisher would make with the frame_prefix ``NAME/``.

    Its root ``NAME/world`` hangs on ``NAME/odom``, and that on ``world``: a plant whose odometry
    drifts moves ``NAME/odom``. ``NAME/base_link`` is the platform, or what the arm stands on; a
    robot whose own description has a link of that name keeps it.
    """

    def __init__(self, node: Node, team: Team) -> None:
        """Publish what does not move, once."""
        self._team = team
        self._trees = [LinkFrames(robot) for robot in team.robots]
        static = node.create_publisher(TFMessage, "tf_static", LATCHED)
        static.publish(TFMessage(transforms=static_transforms(team)))
        self._template = _Template(
            [
                (f"{robot.name}/{parent}", f"{robot.name}/{child}")
                for robot, tree in zip(team.robots, self._trees, strict=True)
                for parent, child in zip(tree.moving.parents, tree.moving.children, strict=True)
            ]
        )
        self._out = node.create_publisher(TFMessage, "tf", STREAM)

    def publish(self, stamp: float, q: Vector) -> None:
        """Publish what moves at q, shape (nq,), if somebody listens."""
        if self._out.get_subscription_count():
            self._out.publish(self.message(stamp, q))

    def message(self, stamp: float, q: Vector) -> bytes:
        """Return the message of a stamp [s] and q, serialised."""
        found = [
            np.concatenate(tree.moving.at(tree.values(q[part])), axis=1)
            for tree, part in zip(self._trees, self._team.q_slices, strict=True)
        ]
        return self._template.filled(stamp, np.concatenate(found))


class _Template:
    """A TFMessage of m transforms in bytes, of which numbers alone change.

    To fill twenty transforms through their Python objects and to serialise them takes longer than
    a tick may; to write the numbers into the bytes takes a twentieth.
    """

    def __init__(self, pairs: Sequence[tuple[str, str]]) -> None:
        """Serialise transforms from parents to children, and look where their numbers went."""
        transforms = [_transform(parent, child) for parent, child in pairs]
        shape = (len(pairs), 7)
        marks = _MARK + np.arange(len(pairs) * 7, dtype=np.float64).reshape(shape)
        for transform, mark in zip(transforms, marks, strict=True):
            transform.header.stamp.sec, transform.header.stamp.nanosec = _MARK, _MARK + 1
            _put(transform, mark[:3].tolist(), mark[3:].tolist())
        data = serialize_message(TFMessage(transforms=transforms))
        self._head = data[:_HEAD]
        body = np.frombuffer(data[_HEAD:], np.uint8)
        self._size = len(body)
        self._body = np.zeros(-(-self._size // 8) * 8, np.uint8)
        self._body[: self._size] = body
        self._numbers, words = self._body.view(np.float64), self._body.view(np.uint32)
        (places,) = np.nonzero((self._numbers >= _MARK) & (self._numbers < _MARK + marks.size))
        self._places = places.reshape(shape)
        self._words, self._seconds = words, np.flatnonzero(words == _MARK)
        assert (self._numbers[self._places] == marks).all()
        assert len(self._seconds) == len(pairs)

    def filled(self, stamp: float, poses: Matrix) -> bytes:
        """Return the message: its stamp [s], position and quaternion of each, shape (m, 7)."""
        time_message = to_time(stamp)
        self._words[self._seconds] = time_message.sec
        self._words[self._seconds + 1] = time_message.nanosec
        self._numbers[self._places] = poses
        return bytes(self._head + self._body[: self._size].tobytes())


def static_transforms(team: Team) -> list[TransformStamped]:
    """Return the transforms of a team that do not change."""
    return [each for robot in team.robots for each in _static(robot, LinkFrames(robot))]


def _static(robot: RobotModel, tree: LinkFrames) -> list[TransformStamped]:
    """Return those of one robot: odom, the root of its tree, fixed joints, base_link."""
    name = robot.name
    found = [_transform(WORLD, f"{name}/odom"), _transform(f"{name}/odom", f"{name}/world")]
    places, turns = (rows.tolist() for rows in tree.fixed.at(tree.fixed_at))
    fixed = zip(tree.fixed.parents, tree.fixed.children, places, turns, strict=True)
    for parent, child, place, turn in fixed:
        found.append(_put(_transform(f"{name}/{parent}", f"{name}/{child}"), place, turn))
    links = {*tree.fixed.children, *tree.moving.children}
    if _BASE_LINK not in links:
        stands_on = "base" if robot.has_base else _first(tree)
        found.append(_transform(f"{name}/{stands_on}", f"{name}/{_BASE_LINK}"))
    return found


def _first(tree: LinkFrames) -> str:
    """Return the link that stands in the world: where a robot without a base is mounted."""
    joints = (tree.fixed, tree.moving)
    pairs = ((p, c) for one in joints for p, c in zip(one.parents, one.children, strict=True))
    return next((child for parent, child in pairs if parent == "world"), "world")


def _transform(parent: str, child: str) -> TransformStamped:
    """Return the identity from one frame to another."""
    result = TransformStamped(child_frame_id=child)
    result.header.frame_id = parent
    result.transform.rotation.w = 1.0
    return result


def _put(transform: TransformStamped, place: list[float], turn: list[float]) -> TransformStamped:
    """Write position and quaternion, as lists, into a transform, and return it."""
    position, rotation = transform.transform.translation, transform.transform.rotation
    position.x, position.y, position.z = place
    rotation.x, rotation.y, rotation.z, rotation.w = turn
    return transform
