"""What the bridge publishes: every message is made once and filled again."""

from __future__ import annotations

import numpy as np
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rclpy.publisher import Publisher
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import String

from lexstack.robots import RobotModel, Team, to_quaternion
from lexstack.types import RobotState, Vector
from lexstack_interfaces.msg import PlantState
from lexstack_plant.frames import FrameTopics
from lexstack_plant.pacing import Sparse
from lexstack_ros.messages.cdr import Buffer
from lexstack_ros.messages.conversions import WORLD, to_array, to_time
from lexstack_ros.messages.qos import LATCHED, STREAM
from lexstack_ros.node.sole_sender import sender_name
from lexstack_sim.coordinates import following
from lexstack_sim.plant_state import Status
from lexstack_sim.urdf import robot_urdf

_CLOCK_RATE = 100.0  # Hz of wall time, at most
_TOOLS_RATE = 50.0  # Hz of wall time
_VECTORS = ("q", "v", "q_star", "command")


class PlantTopics:
    """/plant/state at every tick, /clock, and what tools show of each robot."""

    def __init__(self, node: Node, team: Team, rate: float, *, tools: bool = True) -> None:
        """Create the publishers for ticks at ``rate`` [Hz]; publish the robots' descriptions.

        Without ``tools`` there is /plant/state alone: real robots have clock and topics of their
        own.
        """
        self._state = PlantState(robots=list(team.names), sender=sender_name(node))
        self._state.header.frame_id = WORLD
        self._buffer: Buffer | None = None
        self._resets = 0
        self._state_out = node.create_publisher(PlantState, "plant/state", STREAM)
        if not tools:
            return
        self._clock = Clock()
        self._clock_out = node.create_publisher(Clock, "clock", STREAM)
        self._clock_due, self._tools_due = (
            Sparse(each, 1.0 / rate) for each in (_CLOCK_RATE, _TOOLS_RATE)
        )
        self._robots = [
            (_RobotTopics(node, robot), at, part)
            for robot, at, part in zip(team.robots, team.q_slices, team.slices, strict=True)
        ]
        self._frames = FrameTopics(node, team)

    def publish(
        self, state: RobotState, status: Status, late_ticks: int, missing: int, commander: str
    ) -> None:
        """Publish a state: this is what every other process waits for."""
        if self._buffer is None or commander != self._state.commander:
            self._state.commander = commander
            for name in _VECTORS:
                setattr(self._state, name, to_array(getattr(state, name)))
            self._buffer = Buffer(self._state)
        put, stamp = self._buffer.put, to_time(state.stamp)
        put("header.stamp.sec", stamp.sec)
        put("header.stamp.nanosec", stamp.nanosec)
        put("tick", state.tick)
        put("resets", self._resets)
        for name in _VECTORS:
            self._buffer.put_all(name, getattr(state, name))
        put("status", int(status))
        put("late_ticks", late_ticks)
        put("missing_ticks", missing)
        self._state_out.publish(self._buffer.data)

    def count_reset(self) -> None:
        """Say in every state from now on that the plant was reset once more."""
        self._resets += 1

    def publish_for_tools(self, state: RobotState, effort: Vector) -> None:
        """Publish the rest, at its own rates: after the state, while others compute."""
        if self._clock_due():
            self._clock.clock = to_time(state.stamp)
            self._clock_out.publish(self._clock)
        if self._tools_due():
            for topics, at, part in self._robots:
                topics.publish(state.stamp, state.q[at], state.v[part], effort[at])
            self._frames.publish(state.stamp, state.q)


class _RobotTopics:
    """/NAME/joint_states, /NAME/ee_pose, /NAME/odom of a base, once /NAME/robot_description."""

    def __init__(self, node: Node, robot: RobotModel) -> None:
        """Create the publishers of one robot; one without a base has no odometry."""
        self._robot = robot
        name, fixed = robot.name, robot.config.arm.fixed
        self._fixed = np.array(list(fixed.values()))
        self._nothing = np.zeros(len(fixed))
        self._following = following(robot)
        mimics = [robot.pinocchio.names[1 + row] for row in self._following]
        self._weightless = np.zeros(len(mimics))
        self._joints = JointState(name=[*robot.coordinates, *mimics, *fixed])
        self._pose = PoseStamped()
        self._odometry = Odometry(child_frame_id=f"{name}/base")
        for message in (self._joints, self._pose, self._odometry):
            message.header.frame_id = WORLD
        self._joints_out = node.create_publisher(JointState, f"{name}/joint_states", STREAM)
        self._pose_out = node.create_publisher(PoseStamped, f"{name}/ee_pose", STREAM)
        self._odometry_out = (
            node.create_publisher(Odometry, f"{name}/odom", STREAM) if robot.has_base else None
        )
        self._description_out = node.create_publisher(String, f"{name}/robot_description", LATCHED)
        self._description_out.publish(String(data=robot_urdf(robot)))

    def publish(self, stamp: float, q: Vector, v: Vector, effort: Vector) -> None:
        """Publish the robot's part of the state.

        Args:
            stamp: simulated time [s].
            q: positions, shape (nq_robot,).
            v: velocities as chi, shape (n_robot,).
            effort: along q, shape (nq_robot,).
        """
        time = to_time(stamp)
        self._joints.header.stamp = self._pose.header.stamp = self._odometry.header.stamp = time
        rates = self._robot.rate_matrix(q) @ v if self._robot.differential else v
        mimic_q, mimic_v = self._mimics(q, rates)
        self._joints.position = to_array(np.concatenate([q, mimic_q, self._fixed]))
        self._joints.velocity = to_array(np.concatenate([rates, mimic_v, self._nothing]))
        self._joints.effort = to_array(np.concatenate([effort, self._weightless, self._nothing]))
        self._joints_out.publish(self._joints)
        self._publish_pose(q)
        if self._odometry_out is not None:
            self._publish_odometry(q, rates, self._odometry_out)

    def _mimics(self, q: Vector, v: Vector) -> tuple[Vector, Vector]:
        """Return positions and velocities of the joints that mimic others."""
        joints, rows = self._robot.map, self._following
        if joints is None:
            return self._weightless, self._weightless
        return joints.positions(q)[rows], joints.matrix[rows] @ v

    def _publish_pose(self, q: Vector) -> None:
        """Publish the pose of the tool in the world."""
        tool, _ = self._robot.tool(q)
        place, turn = self._pose.pose.position, self._pose.pose.orientation
        place.x, place.y, place.z = tool.position.tolist()
        turn.x, turn.y, turn.z, turn.w = to_quaternion(tool.rotation).tolist()
        self._pose_out.publish(self._pose)

    def _publish_odometry(self, q: Vector, v: Vector, out: Publisher) -> None:
        """Publish the base's pose in the world, and its velocity in its own frame."""
        x, y, yaw = q[:3].tolist()
        pose, twist = self._odometry.pose.pose, self._odometry.twist.twist
        pose.position.x, pose.position.y = x, y
        pose.orientation.z, pose.orientation.w = float(np.sin(yaw / 2)), float(np.cos(yaw / 2))
        cosine, sine = float(np.cos(yaw)), float(np.sin(yaw))
        vx, vy, rate = v[:3].tolist()
        twist.linear.x, twist.linear.y = cosine * vx + sine * vy, cosine * vy - sine * vx
        twist.angular.z = rate
        out.publish(self._odometry)
