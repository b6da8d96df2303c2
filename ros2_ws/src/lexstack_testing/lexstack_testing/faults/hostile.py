"""Somebody who sends what is wrong, on the topics that our nodes hear."""

from __future__ import annotations

import copy
from collections import deque
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from geometry_msgs.msg import PoseStamped
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.serialization import serialize_message
from std_msgs.msg import String

from lexstack_interfaces.msg import Chi, PlantState, StackRequest
from lexstack_ros.messages.qos import LATCHED, STREAM

_KINDS: dict[str, type] = {
    "/plant/state": PlantState,
    "/robot_a/chi": Chi,
    "/robot_b/chi": Chi,
    "/robot_a/ee_target": PoseStamped,
    "/robot_b/base_target": PoseStamped,
    "/robot_a/request_stack": String,
    "/robot_a/stack_request": StackRequest,
}
_OLD = 300  # messages that are kept to be replayed
_NAME = "stranger@nowhere/1/0"
_LONG = "x" * 10_000
_HUGE = 1e300
FORGED = "forged"
"""The frame_id of what it sends: nobody of ours looks at it, but the analysis of the bag."""


class Stranger:
    """Publishers beside the run's own, and what was heard before.

    Attributes:
        sent: how many messages.
        heard: the last messages of the plant and of the controllers, by topic.
    """

    def __init__(self, node: Node, robots: list[str], n: int) -> None:
        """Send from ``node``, for these robots with ``n`` joints."""
        self.sent = 0
        self._robots, self._n = robots, n
        self._random = np.random.default_rng(0)
        self._out: dict[str, Publisher] = {
            topic: node.create_publisher(kind, topic, LATCHED if kind is StackRequest else STREAM)
            for topic, kind in _KINDS.items()
        }
        self.heard: dict[str, deque[Any]] = {
            topic: deque(maxlen=_OLD) for topic in ("/plant/state", "/robot_a/chi", "/robot_b/chi")
        }
        for topic, heard in self.heard.items():
            node.create_subscription(_KINDS[topic], topic, partial(self._hear, heard), STREAM)
        self._kinds: dict[str, Callable[[], None]] = {
            "unknown stacks": self._unknown,
            "NaN and inf": self._no_numbers,
            "wrong length": self._lengths,
            "stale": lambda: self._ticks(-5, -50, -(10**9)),
            "replayed": self._replay,
            "of the future": lambda: self._ticks(1000, 5000),
            "another sender": self._another,
            "garbage bytes": self._garbage,
        }

    @staticmethod
    def _hear(heard: deque[Any], message: Any) -> None:
        """Keep what others have sent."""
        if message.header.frame_id != FORGED:
            heard.append(message)

    def send(self, kind: str) -> None:
        """Send one of each topic's messages of a kind."""
        if self.heard["/plant/state"]:
            self._kinds[kind]()

    @property
    def kinds(self) -> tuple[str, ...]:
        """What can be sent; all at once would push good messages out of the queues."""
        return tuple(self._kinds)

    def _publish(self, topic: str, message: Any) -> None:
        if hasattr(message, "header") and not isinstance(message, PoseStamped):
            message.header.frame_id = FORGED
        self._out[topic].publish(message)
        self.sent += 1

    def _state(self, **values: Any) -> None:
        """Send the last state with some values changed."""
        state = copy.deepcopy(next(s for s in reversed(self.heard["/plant/state"]) if s.sender))
        for field, value in values.items():
            setattr(state, field, value)
        self._publish("/plant/state", state)

    def _chi(self, topic: str, **values: Any) -> None:
        """Send a chi with the name of its real sender, where one was heard."""
        tick = self.heard["/plant/state"][-1].tick
        last = self.heard[topic][-1] if self.heard[topic] else Chi(sender=_NAME)
        fields = {
            "robots": self._robots,
            "sender": last.sender,
            "transition_id": last.transition_id,
            "tick": tick,
            "chi": [0.5] * self._n,
        }
        self._publish(topic, Chi(**{**fields, **values}))

    def _unknown(self) -> None:
        for stack in ("dance", "", 10 * _LONG, "a\nb"):
            self._publish("/robot_a/request_stack", String(data=stack))
        self._publish("/robot_a/stack_request", StackRequest(id=999, stack="dance", active=True))

    def _no_numbers(self) -> None:
        """Send values that are no numbers or larger than anything is, and poses that are none."""
        self._values([float("nan"), float("inf")] * (self._n // 2))
        self._values([_HUGE] * self._n)
        for x, w, frame in ((float("nan"), 1.0, "world"), (1.0, 0.0, "world"), (1.0, 1.0, "map")):
            pose = PoseStamped()
            pose.header.frame_id = frame
            pose.pose.position.x, pose.pose.orientation.w = x, w
            for topic in ("/robot_a/ee_target", "/robot_b/base_target"):
                self._publish(topic, pose)

    def _lengths(self) -> None:
        """Send too few values, and robots that are not there or in another order."""
        self._values([0.1] * 3)
        self._values([])
        for robots in (self._robots[::-1], [_LONG], ["x", "y"]):
            self._state(robots=robots)
            for topic in ("/robot_a/chi", "/robot_b/chi"):
                self._chi(topic, robots=robots)

    def _values(self, wrong: list[float]) -> None:
        for field in ("q", "v", "q_star", "command"):
            self._state(**{field: wrong, "tick": self.heard["/plant/state"][-1].tick + 1})
        for topic in ("/robot_a/chi", "/robot_b/chi"):
            self._chi(topic, chi=wrong)

    def _ticks(self, *offsets: int) -> None:
        for offset in offsets:
            tick = max(0, self.heard["/plant/state"][-1].tick + offset)
            self._state(tick=tick, q=[0.2] * self._n)
            for topic in ("/robot_a/chi", "/robot_b/chi"):
                self._chi(topic, tick=tick)

    def _replay(self) -> None:
        for topic, heard in self.heard.items():
            for message in (*list(heard)[:-20:50], *list(heard)[-60:-5:10]):
                self._publish(topic, copy.deepcopy(message))
        self._state()  # the last one, once more

    def _another(self) -> None:
        tick = self.heard["/plant/state"][-1].tick
        self._state(sender=_NAME, tick=tick + 1, q=[0.2] * self._n)
        self._state(sender=_NAME, tick=0, resets=7)
        for sender in (_NAME, "", _LONG):
            self._state(sender=sender)
            self._chi("/robot_a/chi", sender=sender)
        self._chi("/robot_b/chi", sender=_NAME, transition_id=999)

    def _garbage(self) -> None:
        for topic, kind in _KINDS.items():
            good = serialize_message(kind())
            self._publish(topic, b"\x00\x01\x00\x00" + self._random.bytes(7))
            self._publish(topic, self._random.bytes(int(self._random.integers(0, 64))))
            self._publish(topic, good[: int(self._random.integers(0, len(good)))])
