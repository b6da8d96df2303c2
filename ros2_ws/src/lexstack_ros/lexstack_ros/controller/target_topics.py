"""Targets by topic: every message is checked, and what fits goes to the schedule."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import partial
from typing import Any

from geometry_msgs.msg import PoseStamped, TwistStamped
from nav_msgs.msg import Path
from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectory, MultiDOFJointTrajectory

from lexstack.errors import InputError, ModelError
from lexstack.references import TOOL, Hold, ReferenceSchedule, Target
from lexstack.robots import Team
from lexstack.tasks import StackConfig
from lexstack.types import RobotState
from lexstack_config.reference_topics import ReferenceTopicsConfig
from lexstack_ros.intake.frames import Frames
from lexstack_ros.intake.transform_topics import listen
from lexstack_ros.intake.transforms import EarlyError
from lexstack_ros.messages.conversions import to_base_target, to_ee_target
from lexstack_ros.messages.names import relative
from lexstack_ros.messages.qos import STREAM
from lexstack_ros.messages.target_points import Reading
from lexstack_ros.messages.targets import to_base_twist, to_path, to_posture, to_twist, to_way

Read = Callable[[Any, Reading], Iterable[Target]]

_WAIT = 0.1  # s, that a target waits for the state of its stamp: it may overtake that
_MOST_WAITING = 1000


def _pose(message: PoseStamped, reading: Reading) -> Iterator[Target]:
    """Yield the target of a frame."""
    target = to_ee_target(message, reading.robot, reading.where, reading.placing, reading.frame)
    yield replace(target, begin=reading.begin(reading.frame))


def _base(message: PoseStamped, reading: Reading) -> Iterator[Target]:
    """Yield the target of a base."""
    yield to_base_target(message, reading.robot, reading.where, reading.placing)


OF_FRAMES: dict[str, tuple[type, Read]] = {
    "ee_target": (PoseStamped, _pose),
    "ee_twist": (TwistStamped, to_twist),
    "ee_trajectory": (MultiDOFJointTrajectory, to_way),
}
"""Topics of a robot's tool, below its name, and of its other frames, below NAME/FRAME."""

OF_ROBOTS: dict[str, tuple[type, Read]] = {
    "base_target": (PoseStamped, _base),
    "base_twist": (TwistStamped, to_base_twist),
    "base_path": (Path, to_path),
    "posture_trajectory": (JointTrajectory, to_posture),
}
"""Further topics of a robot, below its name."""


class TargetTopics:
    """Subscriptions to all topics of targets: of every robot, its tools, and frames of stacks.

    Attributes:
        schedule: takes every valid target.
        refused: how many messages were not valid.
        on_posture: called with the place of a robot whose posture a topic has given a target.
    """

    def __init__(
        self,
        node: Node,
        team: Team,
        schedule: ReferenceSchedule,
        options: ReferenceTopicsConfig,
        stacks: Iterable[StackConfig] = (),
    ) -> None:
        """Put every valid target into ``schedule``; warn of the others."""
        self._node = node
        self._team = team
        self._options = options
        self.schedule = schedule
        self.refused = 0
        self._rejection = ""  # the last one since the last report
        self._frames = Frames(team)
        self._early: list[Callable[[], None]] = []
        self._known: set[str] = set()
        self.on_posture: Callable[[int], None] = lambda _robot: None
        listen(node, self._frames)
        for robot, name in enumerate(team.names):
            for kind, entry in (OF_FRAMES | OF_ROBOTS).items():
                self._subscribe(f"/{name}/{kind}", entry, robot, TOOL)
            for frame in team.robots[robot].config.tools:
                self._add_frame(robot, frame)
        for stack in stacks:
            self.add_frames(stack)

    def add_frames(self, stack: StackConfig) -> None:
        """Subscribe to the topics of the frames that a stack names."""
        for robot, frame in frames_of(stack, self._team):
            self._add_frame(robot, frame)

    def _add_frame(self, robot: int, frame: str) -> None:
        """Subscribe to the topics of one frame, if the robot has it."""
        try:
            self._team.robots[robot].frame(frame)
        except ModelError:
            return  # a stack of other robots
        for kind, entry in OF_FRAMES.items():
            topic = f"/{self._team.names[robot]}/{topic_name(frame)}/{kind}"
            self._subscribe(topic, entry, robot, frame)

    def see(self, state: RobotState) -> None:
        """Take note of a state of the plant: frames move with it, and targets may wait for it."""
        self._frames.see(state)
        if self._early:
            early, self._early = self._early, []
            for take in early:
                take()

    def report(self) -> str:
        """Return the last refusal since the last report, or ''."""
        rejection, self._rejection = self._rejection, ""
        return rejection

    def take_posture(self, robot: int, message: JointTrajectory, where: str) -> None:
        """Take the posture of an arm that comes another way; raises InputError.

        Args:
            robot: its place in the team.
            message: as on the topic.
            where: stands before every complaint.
        """
        for target in list(to_posture(message, self._reading(robot, TOOL, where))):
            self.schedule.add(target)

    def hold_posture(self, robot: int) -> None:
        """Bring the reference of an arm to rest from now on."""
        self.schedule.add(Target(0.0, robot, posture=Hold()))

    def _reading(self, robot: int, frame: str, where: str) -> Reading:
        """Return what a message of now is read with."""
        return Reading(
            self._team,
            robot,
            frame,
            where,
            self._frames,
            self.schedule.next,
            self._options,
            self._frames.state,
        )

    def _subscribe(self, topic: str, entry: tuple[type, Read], robot: int, frame: str) -> None:
        """Listen to one topic, once."""
        if topic in self._known:
            return
        self._known.add(topic)
        kind, read = entry
        take = partial(self._take, read, robot, frame, topic)
        self._node.create_subscription(kind, relative(topic), take, STREAM)

    def _take(self, read: Read, robot: int, frame: str, topic: str, message: Any) -> None:
        """Take one message; a stamp of the past means now."""
        try:
            for target in list(read(message, self._reading(robot, frame, topic))):
                self.schedule.add(target)
                if target.posture is not None:
                    self.on_posture(robot)
        except EarlyError as error:
            if error.ahead <= _WAIT and len(self._early) < _MOST_WAITING:
                self._early.append(partial(self._take, read, robot, frame, topic, message))
            else:
                self._refuse(error, topic)
        except InputError as error:
            self._refuse(error, topic)

    def _refuse(self, error: InputError, topic: str) -> None:
        """Count and tell of a message that does not fit; no flood of lines."""
        self.refused += 1
        text = str(error)
        if not text.startswith(topic):
            text = f"{topic}: {re.sub('^[a-z]+_target( of [^:]*)?: ', '', text)}"
        self._rejection = f"refused: {text}"
        self._node.get_logger().warning(self._rejection, throttle_duration_sec=1.0)


def frames_of(stack: StackConfig, team: Team) -> Iterator[tuple[int, str]]:
    """Yield the frames that a stack's tasks name, other than the tools, with their robots."""
    for level in stack.levels:
        for task in level.tasks:
            frame = task.parameters.get("frame")
            if not isinstance(frame, str) or frame == TOOL:
                continue
            names = [task.robot] if task.robot else (stack.robots or team.names)
            for name in names:
                if name in team.names:
                    yield team.names.index(name), frame


def topic_name(frame: str) -> str:
    """Return a frame's name as it may stand in a topic: letters, digits and underscores."""
    name = re.sub(r"\W", "_", frame, flags=re.ASCII)
    return name if not name[:1].isdigit() else f"_{name}"
