"""The targets of all robots, by topic: what robot A and robot B both listen to."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
from geometry_msgs.msg import PoseStamped
from rclpy.node import Node
from rclpy.publisher import Publisher

from lexstack_core.errors import InputError
from lexstack_core.model import Pose, Team
from lexstack_core.references import References, ReferenceSchedule
from lexstack_core.rotation import from_rpy, to_quaternion
from lexstack_ros.conversions import pose_message, to_base_target, to_ee_target
from lexstack_ros.qos import LATCHED, STREAM

_KINDS = {"ee_target": to_ee_target, "base_target": to_base_target}


class TargetTopics:
    """Subscriptions to /NAME/ee_target and /NAME/base_target of every robot."""

    def __init__(self, node: Node, team: Team, schedule: ReferenceSchedule) -> None:
        """Put every valid target into ``schedule``; warn of the others."""
        self._node = node
        self.schedule = schedule
        self.refused = 0
        for robot, name in enumerate(team.names):
            for kind in _KINDS:
                topic = f"/{name}/{kind}"
                node.create_subscription(
                    PoseStamped, topic, partial(self.take, kind, robot, topic), STREAM
                )

    def take(self, kind: str, robot: int, topic: str, message: PoseStamped) -> None:
        """Take one target; a stamp of the past means now."""
        try:
            self.schedule.add(_KINDS[kind](message, robot, topic))
        except InputError as error:
            self.refused += 1
            self._node.get_logger().warning(f"refused: {error}", throttle_duration_sec=1.0)


class ReferencesInEffect:
    """/NAME/ee_reference and /NAME/base_reference, latched: what robot A goes by now.

    For whoever comes later: a target is sent once, and a robot B that starts again has missed it.
    """

    def __init__(self, node: Node, team: Team) -> None:
        """Create the publishers."""
        self._told: References | None = None
        self._ee: list[Publisher] = []
        self._base: list[Publisher] = []
        for name in team.names:
            ee = node.create_publisher(PoseStamped, f"/{name}/ee_reference", LATCHED)
            base = node.create_publisher(PoseStamped, f"/{name}/base_reference", LATCHED)
            self._ee.append(ee)
            self._base.append(base)

    def tell(self, references: References, stamp: float) -> None:
        """Publish what has changed since the last call, at a time [s]."""
        before = self._told
        if references is before:
            return
        self._told = references
        for robot, ee in enumerate(references.ee):
            if before is None or ee is not before.ee[robot]:
                self._publish(self._ee[robot], ee, stamp)
        for robot, base in enumerate(references.base):
            if before is None or base is not before.base[robot]:
                x, y, yaw = (float(value) for value in base)
                pose = Pose(np.array([x, y, 0.0]), from_rpy((0.0, 0.0, yaw)))
                self._publish(self._base[robot], pose, stamp)

    @staticmethod
    def _publish(out: Publisher, pose: Pose, stamp: float) -> None:
        """Publish one reference."""
        out.publish(pose_message(pose, stamp, to_quaternion(pose.rotation)))


class CatchingUp:
    """What a node that comes late takes from them; one that was there from the start nothing."""

    def __init__(
        self,
        node: Node,
        team: Team,
        take: Callable[[str, int, str, PoseStamped], None],
        on_all: Callable[[], None],
    ) -> None:
        """Listen.

        Args:
            node: that may come late.
            team: the robots.
            take: puts a target into the schedule, see TargetTopics.
            on_all: called when the last missing reference has come.
        """
        self._take = take
        self._on_all = on_all
        self._late: bool | None = None
        self._waiting: list[tuple[str, int, str, PoseStamped]] = []
        self._missing: set[str] = set()  # topics that were not heard yet
        for robot, name in enumerate(team.names):
            for kind, topic in (
                ("ee_target", f"/{name}/ee_reference"),
                ("base_target", f"/{name}/base_reference"),
            ):
                self._missing.add(topic)
                hear = partial(self._hear, kind, robot, topic)
                node.create_subscription(PoseStamped, topic, hear, LATCHED)

    @property
    def complete(self) -> bool:
        """Whether all references are known: topics are connected one by one."""
        return not (self._late and self._missing)

    def join(self, tick: int) -> None:
        """Take note of the first state: a later one than the plant's first is late."""
        if self._late is None:
            self._late = tick > 0
            waiting, self._waiting = self._waiting, []
            for entry in waiting if self._late else ():
                self._take(*entry)

    def _hear(self, kind: str, robot: int, topic: str, message: PoseStamped) -> None:
        """Keep a reference until it is known whether it is needed, or take it."""
        incomplete = not self.complete
        self._missing.discard(topic)
        if self._late is None:
            self._waiting.append((kind, robot, topic, message))
        elif self._late:
            self._take(kind, robot, topic, message)
            if incomplete and self.complete:
                self._on_all()
