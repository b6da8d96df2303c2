"""The targets of all robots, by topic: what robot A and robot B both listen to."""

from __future__ import annotations

from functools import partial

from geometry_msgs.msg import PoseStamped
from rclpy.node import Node

from lexstack_core.errors import InputError
from lexstack_core.model import Team
from lexstack_core.references import ReferenceSchedule
from lexstack_ros.conversions import to_base_target, to_ee_target
from lexstack_ros.qos import STREAM

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
                    PoseStamped, topic, partial(self._take, kind, robot, topic), STREAM
                )

    def _take(self, kind: str, robot: int, topic: str, message: PoseStamped) -> None:
        """Take one target; a stamp of the past means now."""
        try:
            self.schedule.add(_KINDS[kind](message, robot, topic))
        except InputError as error:
            self.refused += 1
            self._node.get_logger().warning(f"refused: {error}", throttle_duration_sec=1.0)
