"""``stand_in``: robots in MuJoCo behind the topics of ros2_control's controllers, as a node."""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from time import time, time_ns
from typing import Any

import numpy as np
from geometry_msgs.msg import Twist, TwistStamped
from rclpy.clock import Clock as SteadyClock
from rclpy.clock import ClockType
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Bool, Float64MultiArray
from std_srvs.srv import SetBool
from trajectory_msgs.msg import JointTrajectory

from lexstack_config.plant_file import check_plant, load_plant
from lexstack_plant.hardware.messages import seconds_of
from lexstack_plant.hardware.spline import Point
from lexstack_ros.intake.delays import with_info
from lexstack_ros.intake.drain import waiting
from lexstack_ros.messages.conversions import to_time
from lexstack_ros.node.diagnostics import Diagnostics, Health, all_of
from lexstack_ros.node.options import FROM_COMMAND_LINE, NodeOptions
from lexstack_ros.node.parameters import scenario_parameter, text_parameter
from lexstack_ros.node.readiness import READY
from lexstack_ros.node.spin import run_node
from lexstack_testing.stand_in.habits import parse_habits
from lexstack_testing.stand_in.lateness import LATE, Lateness
from lexstack_testing.stand_in.robots import StandIn
from lexstack_testing.stand_in.state_topics import STATES, StateTopics

_LOOK = 0.004  # s between two looks at the clock: every state that is due goes out then
_SILENT = 1.0  # s between two warnings that the robots are behind the clock
_SLICE = 0.002  # s from one /clock to the next
_COMMANDS = QoSProfile(depth=100)  # more than come while this process has no time
Take = Callable[[Any, float], None]
"""Takes a command that was sent at a time [s since 1970]."""


class StandInNode(Node):
    """Moves the robots with the wall's clock, and passes messages on."""

    def __init__(self, options: NodeOptions = FROM_COMMAND_LINE) -> None:
        """Put the robots where the scenario starts; raises LexstackError for a wrong parameter."""
        super().__init__(**options.arguments("stand_in"))
        resolved = scenario_parameter(self)
        path = Path(text_parameter(self, "plant", "file of the plant"))
        habits = text_parameter(self, "habits", "all, or NAME=VALUE,...", "")
        self._file = load_plant(path)
        check_plant(self._file, resolved, str(path))
        chosen, simulated = parse_habits(habits), self._file.use_sim_time
        self._clock_out = self.create_publisher(Clock, "clock", STATES) if simulated else None
        # Seconds since now, not since 1970: there a double has steps of 0.2 us, and the drives
        # would feel them.
        self._epoch = 0 if simulated else int(time())
        now = self._simulated = 1.0 if simulated else self._now()
        self.robots = StandIn(resolved, self._file, chosen, now, resolved.scenario.seed)
        self.lateness, self._warned = Lateness(), -np.inf
        self._began = self._commanded = False
        self._told: dict[str, str] = {}
        self._commands: list[tuple[Subscription, Take]] = []
        self._states = StateTopics(self, self._epoch)
        for name in resolved.scenario.robots:
            self._connect(name)
        stop = self._file.safety.stop
        self._stop_out = None if stop is None else self.create_publisher(Bool, stop, STATES)
        look = _SLICE / chosen.speed if simulated else _LOOK
        self.create_timer(look, self._on_timer, clock=SteadyClock(clock_type=ClockType.STEADY_TIME))
        Diagnostics(self, self._health)
        print(READY, flush=True)

    def _connect(self, name: str) -> None:
        """Make the topics and services of one robot."""
        config = self._file.robots[name]
        self._states.add(name, config)
        kind, take = Float64MultiArray, self._on_values
        if config.arm.type == "joint_trajectory":
            kind, take = JointTrajectory, self._on_trajectory
        self._hear(kind, config.arm.command, partial(take, name))
        self.create_service(SetBool, f"{name}/stand_in/stop", partial(self._on_stop, name))
        if config.base is None:
            return
        twist = TwistStamped if config.base.type == "twist_stamped" else Twist
        self._hear(twist, config.base.command, partial(self._on_twist, name))

    def _hear(self, kind: type, topic: str, take: Take) -> None:
        """Hear commands; each counts from when it was sent, however busy this process is."""

        def hear(message: Any, info: dict[str, int]) -> None:
            self._commanded = True
            take(message, self._sent(info))

        subscription = self.create_subscription(kind, topic, with_info(hear), _COMMANDS)
        self._commands.append((subscription, take))

    def _sent(self, info: dict[str, int]) -> float:
        """Return when a message was sent, by the robots' clock [s]."""
        if self._clock_out is not None:
            return self._simulated
        return 1e-9 * (info["source_timestamp"] - 1_000_000_000 * self._epoch)

    def _now(self) -> float:
        """Return the time of the wall [s since the epoch]."""
        return 1e-9 * (time_ns() - 1_000_000_000 * self._epoch)

    def _on_trajectory(self, name: str, message: JointTrajectory, now: float) -> None:
        """Take a trajectory; one without a stamp begins when it was sent."""
        stamp = message.header.stamp
        start = (
            stamp.sec - self._epoch + 1e-9 * stamp.nanosec if stamp.sec or stamp.nanosec else now
        )
        order = [message.joint_names.index(joint) for joint in self.robots.robots[name].names]
        points = [
            Point(
                start + seconds_of(point.time_from_start),
                np.array(point.positions)[order],
                np.array(point.velocities)[order],
                np.array(point.accelerations)[order],
            )
            for point in message.points
        ]
        self.robots.command_arm(name, points, now)

    def _on_values(self, name: str, message: Float64MultiArray, now: float) -> None:
        """Take positions or velocities."""
        self.robots.command_arm(name, np.array(message.data), now)

    def _on_twist(self, name: str, message: Any, now: float) -> None:
        """Take the velocity of a platform."""
        twist = message.twist if isinstance(message, TwistStamped) else message
        values = np.array([twist.linear.x, twist.linear.y, twist.angular.z])
        self.robots.command_base(name, values, now)

    def _on_stop(
        self, name: str, request: SetBool.Request, response: SetBool.Response
    ) -> SetBool.Response:
        """Press a robot's emergency stop, or release it."""
        (self.robots.press if request.data else self.robots.release)(name)
        if self._stop_out is not None:
            self._stop_out.publish(Bool(data=request.data))
        response.success = True
        return response

    def _on_timer(self) -> None:
        """Move the robots up to now, and send what they measure."""
        # What was sent before now counts before now, though the executor has not handed it over.
        now = self._now()
        for subscription, take in self._commands:
            for message, info in waiting(subscription):
                self._commanded = True
                take(message, self._sent(info))
        if self._clock_out is not None:
            now = self._simulated = self._simulated + _SLICE
            self._clock_out.publish(Clock(clock=to_time(now)))
        else:
            self._count(now)
        for sent in self.robots.advance(now):
            self._states.publish(sent)
        self._tell()

    def _count(self, now: float) -> None:
        """Count how far the robots are behind the clock; they go the way that they were sent.

        Whoever commands them sees old states, as of a driver that stood still.
        """
        if not self._began:
            self.robots.begin(now)  # what a node does before it is spun is no lateness
            self._began = True
        if not self._commanded:
            return  # the processes find each other, which takes time too
        behind = now - self.robots.next_states
        self.lateness.add(behind)
        if behind > LATE and now > self._warned + _SILENT:
            self._warned = now
            self.get_logger().warning(f"{1e3 * behind:.0f} ms behind the clock")

    def _tell(self) -> None:
        """Say once which drives have stopped."""
        stopped = self.robots.stopped()
        for name, reason in stopped.items():
            if self._told.get(name) != reason:
                self.get_logger().error(f"{name}: {reason}")
        self._told = stopped

    def close(self) -> None:
        """Say how late all was."""
        if self._clock_out is None:
            self.get_logger().info(str(self.lateness))

    def _health(self) -> Health:
        """Return how the robots are."""
        told = "; ".join(f"{name}: {reason}" for name, reason in self._told.items())
        if self._clock_out is not None:
            return Health(told)
        late, newest = self.lateness.report()
        counted = {
            "behind the clock, at most [ms]": f"{1e3 * newest:.1f}",
            "late looks": f"{self.lateness.late} of {self.lateness.looks}",
        }
        return Health(all_of(told, late), counted)


def main() -> int:
    """Run the stand-in; returns the exit code."""
    return run_node(StandInNode)


if __name__ == "__main__":
    sys.exit(main())
