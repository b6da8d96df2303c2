"""References by topic: the controller decides; others hear its decisions."""

from __future__ import annotations

import time
from collections.abc import Callable
from threading import Thread
from typing import Any

import numpy as np
from geometry_msgs.msg import PoseStamped
from rclpy.node import Node
from rclpy.publisher import Publisher

from lexstack.errors import InputError
from lexstack.references import (
    ReferenceSchedule,
    ReferenceTimeline,
    SetPoint,
    Setting,
    Trajectory,
    load,
)
from lexstack.robots import Pose, Team, from_rpy, to_quaternion
from lexstack.types import RobotState, Vector
from lexstack_interfaces.msg import References
from lexstack_ros.controller.transition_parameters import LeadInParameter
from lexstack_ros.messages.conversions import pose_message
from lexstack_ros.messages.names import relative
from lexstack_ros.messages.qos import LATCHED, LATEST
from lexstack_ros.messages.references import references_message, to_setting

DECISIONS = "/robot_a/references"
KEPT = "/robot_b/references"
"""What the solver has heard of them, for a controller that starts again."""

_PATIENCE = 3.0  # s of wall time, for what the solver keeps: discovery takes most of it
_SENDERS = 8  # whose decisions are kept


def load_ahead(mode: str) -> None:
    """Load what trajectories need of scipy while the node waits for the others.

    It takes 0.3 s: in the middle of a run in real time the plant would brake. In lockstep the plant
    waits, and most runs have no trajectory.
    """
    if mode == "realtime":
        Thread(target=load, name="load_ahead").start()


class HeardReferences:
    """The decisions that a topic carries, of each sender by itself.

    Attributes:
        refused: messages that did not fit.
        believed: whose decisions count; empty: the newest sender's.
    """

    def __init__(
        self,
        node: Node,
        team: Team,
        topic: str = DECISIONS,
        on_news: Callable[[References], None] = lambda _message: None,
    ) -> None:
        """Listen; ``on_news`` is called after each new decision."""
        self.refused = 0
        self.believed = ""
        self._timelines: dict[str, ReferenceTimeline] = {}
        self._node = node
        self._team = team
        self._topic = topic
        self._on_news = on_news
        self._newest = ""
        self._nothing = ReferenceTimeline(team.dt)
        node.create_subscription(References, relative(topic), self._hear, LATCHED)

    def _hear(self, message: References) -> None:
        """Take a decision; another sender begins anew."""
        try:
            setting = to_setting(message, self._team, self._topic)
        except InputError as error:
            self.refused += 1
            self._node.get_logger().warning(f"refused: {error}", throttle_duration_sec=1.0)
            return
        timeline = self._timelines.setdefault(message.sender, ReferenceTimeline(self._team.dt))
        self._newest = message.sender
        while len(self._timelines) > _SENDERS:
            del self._timelines[next(s for s in self._timelines if s not in self._counted())]
        if timeline.hear(setting) and timeline is self.timeline:
            self._on_news(message)

    @property
    def timeline(self) -> ReferenceTimeline:
        """The decisions that count."""
        name = self.believed if self.believed in self._timelines else self._newest
        return self._timelines.get(name, self._nothing)

    def _counted(self) -> tuple[str, str]:
        """Return the senders whose decisions count, or may."""
        return self.believed, self._newest


class Decisions:
    """The controller's decisions on references: made one tick ahead, before the plant goes on.

    Attributes:
        schedule: decides.
        missing: why a controller that starts again could not go on with the last ones, or ''.
    """

    def __init__(self, node: Node, team: Team, schedule: ReferenceSchedule, sender: str) -> None:
        """Create the publishers; ``sender`` names this process."""
        self.schedule = schedule
        self._node = node
        self._team = team
        self._sender = sender
        self._parameter = LeadInParameter(node, schedule.lead_in, self._lead_in)
        self._out = node.create_publisher(References, relative(DECISIONS), LATEST)
        self._goals = _Goals(node, team)
        self._kept = HeardReferences(node, team, KEPT)
        self._asked_since: float | None = None
        self.missing = ""

    def restart(self, schedule: ReferenceSchedule) -> None:
        """Decide for another schedule from now on; revisions count on."""
        schedule.count_on(self.schedule)
        self.schedule = schedule
        self._parameter.hand_on()

    def known(self, state: RobotState, late: int) -> bool:
        """Return whether the first references can be decided for a state.

        A controller that starts again, at a tick after ``late``, goes on with what the solver has
        kept; it waits for it a moment.
        """
        if self.schedule.begun or state.tick <= late:
            return True
        last = self._kept.timeline.newest
        if last is not None:
            self.schedule.resume(last, state.stamp)
            return True
        now = time.monotonic()
        self._asked_since = self._asked_since or now
        if now - self._asked_since <= _PATIENCE:
            return False
        self.missing = "no references of before were heard: they begin at the measured poses"
        return True

    def _lead_in(self, seconds: float) -> None:
        """Lead later targets in within another time [s]."""
        self.schedule.lead_in = seconds

    def tell(self) -> None:
        """Publish what was decided since the last call."""
        for setting in self.schedule.take_news():
            self._out.publish(references_message(setting, self._team, self._sender))
            self._goals.tell(setting)


class _Goals:
    """/NAME/ee_reference and /NAME/base_reference, latched: the goals in effect, for tools."""

    def __init__(self, node: Node, team: Team) -> None:
        """Create the publishers."""
        self._announced: Setting | None = None
        self._ee: list[Publisher] = []
        self._base: list[Publisher] = []
        for name in team.names:
            ee = node.create_publisher(PoseStamped, f"{name}/ee_reference", LATEST)
            base = node.create_publisher(PoseStamped, f"{name}/base_reference", LATEST)
            self._ee.append(ee)
            self._base.append(base)

    def tell(self, setting: Setting) -> None:
        """Publish the goals that have changed."""
        before, self._announced = self._announced, setting
        for robot, (out, ee) in enumerate(zip(self._ee, setting.ee, strict=True)):
            if before is None or ee is not before.ee[robot]:
                self._publish(out, _goal(ee), setting.at)
        for robot, (out, base) in enumerate(zip(self._base, setting.base, strict=True)):
            if before is None or base is not before.base[robot]:
                self._publish(out, _upright(_goal(base)), setting.at)

    @staticmethod
    def _publish(out: Publisher, goal: Pose, stamp: float) -> None:
        """Publish one goal."""
        out.publish(pose_message(goal, stamp, to_quaternion(goal.rotation)))


def _goal(point: Trajectory[Any]) -> Any:
    """Return where a reference leads to."""
    return point.goal if isinstance(point, SetPoint) else point.at(point.end)


def _upright(base: Vector) -> Pose:
    """Return x, y, yaw as a pose on the floor."""
    x, y, yaw = (float(value) for value in base)
    return Pose(np.array([x, y, 0.0]), from_rpy((0.0, 0.0, yaw)))
