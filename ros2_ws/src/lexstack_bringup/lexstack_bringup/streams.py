"""Streams of targets that a scenario asks for, published as a user would."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from rclpy.publisher import Publisher

from lexstack.references import measured
from lexstack.robots import Pose, from_rpy, to_quaternion
from lexstack.types import Vector
from lexstack_config.parts import build_team, home_of
from lexstack_config.resolved import ResolvedScenario
from lexstack_config.stream import StreamConfig
from lexstack_ros.messages.conversions import pose_message


class Streams:
    """All streams of a scenario, played along simulated time."""

    def __init__(self, resolved: ResolvedScenario, publishers: Mapping[str, Publisher]) -> None:
        """Know the robots' first poses; ``publishers`` are those of the targets, by topic."""
        team = build_team(resolved)
        self._start = measured(team, home_of(team, resolved))
        self._team = team
        self._publishers = publishers
        self._streams = [[stream, 0] for stream in resolved.scenario.streams]

    def publish(self, now: float) -> None:
        """Publish what is due at a simulated time [s]; what is late goes out at once, newest last.

        Of several messages that are due together only the last one counts.
        """
        for entry in self._streams:
            stream, sent = entry
            until = min(now, stream.end)
            due = math.floor((until - stream.start) * stream.rate + 1e-9) + 1
            if due > sent:
                self._send(stream, stream.start + (due - 1) / stream.rate)
                entry[1] = due

    def _send(self, stream: StreamConfig, at: float) -> None:
        """Publish one target for a time [s]."""
        robot = self._team.index(stream.robot)
        offset = np.array(stream.swing) * math.sin(2.0 * math.pi * stream.frequency * at)
        pose = self._pose(stream, robot, offset)
        stamp = at + stream.ahead if stream.ahead else 0.0
        message = pose_message(pose, stamp, to_quaternion(pose.rotation))
        self._publishers[f"/{stream.robot}/{stream.target}_target"].publish(message)

    def _pose(self, stream: StreamConfig, robot: int, offset: Vector) -> Pose:
        """Return a target: the robot's first pose, moved by ``offset``, shape (3,)."""
        if stream.target == "ee":
            tool = self._start.ee[robot]
            return Pose(tool.position + offset, tool.rotation)
        x, y, yaw = (float(value) for value in self._start.base[robot] + offset)
        return Pose(np.array([x, y, 0.0]), from_rpy((0.0, 0.0, yaw)))
