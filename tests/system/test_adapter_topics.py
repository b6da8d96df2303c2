"""``plant_adapter`` with small nodes in place of a robot's controllers: listeners, /tf, faults."""

from __future__ import annotations

import threading
from contextlib import contextmanager
from dataclasses import replace
from types import SimpleNamespace

import pytest
import rclpy
import yaml
from geometry_msgs.msg import TransformStamped, Twist, TwistStamped
from rclpy.context import Context
from rclpy.experimental import EventsExecutor
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray
from std_srvs.srv import SetBool
from tf2_msgs.msg import TFMessage
from trajectory_msgs.msg import JointTrajectory

from lexstack_config.resolved import load_scenario
from lexstack_interfaces.msg import PlantState
from lexstack_plant.adapters.ros2_control import PlantAdapter
from lexstack_ros.messages.qos import LATCHED
from lexstack_ros.node.options import NodeOptions
from lexstack_testing.ros_session import ros_session
from lexstack_testing.user import Bystander, InVainError
from support.scenario import CONFIG

pytestmark = [pytest.mark.system, pytest.mark.timeout(120)]

# A busy machine may be late by seconds: here it is not time that is tested.
PLANT = """
name: tf
description: "TIAGo whose base is placed by /tf."
rate: 50.0
safety: {stale: 5.0, silence: 1000.0}
robots:
  robot_a:
    model: tiago
    joint_states: {topic: /joint_states}
    base: {tf: {frame: base_link, parent: odom}, command: /cmd_vel, type: twist}
    arm: {command: /arm/joint_trajectory}
"""


class Robot:
    """What stands for TIAGo: it measures, and listens as long as its controllers run."""

    def __init__(self, node, model, home):
        self.node, self.names, self.home = node, list(model.arm.joints), home
        self.joints_out = node.create_publisher(JointState, "/joint_states", 10)
        self.tf_out = node.create_publisher(TFMessage, "/tf", 10)
        self.static_out = node.create_publisher(TFMessage, "/tf_static", LATCHED)
        fixed = transform("base_footprint", "base_link", 0.0)
        self.static_out.publish(TFMessage(transforms=[fixed]))
        self.x = 3.0
        self.heard = {}
        node.create_timer(0.02, self.measure)

    def measure(self):
        now = self.node.get_clock().now().to_msg()
        joints = JointState(name=self.names, position=list(self.home))
        joints.header.stamp = now
        self.joints_out.publish(joints)
        moving = transform("odom", "base_footprint", self.x)
        moving.header.stamp = now
        self.tf_out.publish(TFMessage(transforms=[moving]))

    def listen(self, kind, topic):
        """Run a controller."""
        heard = self.heard.setdefault(topic, [])
        return self.node.create_subscription(kind, topic, heard.append, 1000)


def transform(parent, child, x):
    """Return a transform along x."""
    entry = TransformStamped(child_frame_id=child)
    entry.header.frame_id = parent
    entry.transform.translation.x = x
    entry.transform.rotation.w = 1.0
    return entry


@pytest.fixture
def bench(tmp_path, request):
    """Yield the adapter in this process, a robot, and somebody who uses them.

    A parameter is what the plant file has of the arm.
    """
    given = load_scenario(CONFIG / "scenarios" / "drive.yaml")
    given = replace(given, scenario=replace(given.scenario, rate=50.0, mode="realtime"))
    scenario, plant = tmp_path / "scenario.yaml", tmp_path / "tf.yaml"
    scenario.write_text(given.to_yaml(), encoding="utf-8")
    content = yaml.safe_load(PLANT)
    content["robots"]["robot_a"]["arm"].update(getattr(request, "param", {}))
    plant.write_text(yaml.safe_dump(content), encoding="utf-8")
    with ros_session(children=False) as context:
        executor = EventsExecutor(context=context)
        parameters = {"scenario": str(scenario), "plant": str(plant)}
        adapter = PlantAdapter(NodeOptions(context, parameters=parameters))
        node = rclpy.create_node("robot", context=context)
        executor.add_node(adapter)
        executor.add_node(node)
        model = given.robots["tiago"]
        robot = Robot(node, model, model.arm.home)
        run = SimpleNamespace(context=context, executor=executor, check=lambda: None)
        user = Bystander(run)
        user.states = user.hear(PlantState, "/plant/state", [])
        yield SimpleNamespace(adapter=adapter, robot=robot, user=user)
        executor.shutdown()
        for each in (adapter, node, user.node):
            each.destroy_node()


@contextmanager
def another_process(beside):
    """Yield a node that DDS knows as one of another process: it may use other types."""
    context = Context()
    rclpy.init(args=[], context=context, domain_id=beside.get_domain_id())
    node = rclpy.create_node("base_controller", context=context)
    try:
        yield node
    finally:
        node.destroy_node()
        rclpy.shutdown(context=context)


def enable(bench):
    return bench.user.call(SetBool, "/robot_a/enable", data=True)


def running(bench):
    """Run both controllers, and enable the robot; return their subscriptions."""
    heard = [
        bench.robot.listen(JointTrajectory, "/arm/joint_trajectory"),
        bench.robot.listen(Twist, "/cmd_vel"),
    ]
    answers = []
    bench.user.until(lambda: answers.append(enable(bench)) or answers[-1].success, "enabling")
    return heard


def test_without_its_controllers_it_is_not_enabled_and_the_topic_is_named(bench):
    refused_until(
        bench,
        "robot_a: nobody listens to /arm/joint_trajectory (trajectory_msgs/msg/JointTrajectory): "
        "start the controller",
    )
    bench.robot.listen(JointTrajectory, "/arm/joint_trajectory")
    with another_process(bench.adapter.context) as node:
        node.create_subscription(TwistStamped, "/cmd_vel", lambda _message: None, 10)
        refused_until(
            bench,
            "robot_a: nobody listens to /cmd_vel (geometry_msgs/msg/Twist): "
            "there is a listener for geometry_msgs/msg/TwistStamped: correct the type",
        )


def refused_until(bench, message):
    """Ask again and again until the refusal is the one that is wanted; none may succeed."""
    answers = []

    def refused():
        answers.append(enable(bench))
        return answers[-1].message == message

    try:
        bench.user.until(refused)
    except InVainError:
        pytest.fail(f"{answers[-1].message} is not {message}")
    assert not any(answer.success for answer in answers)


def test_the_pose_of_tf_is_where_the_scenario_puts_the_robot(bench):
    running(bench)
    bench.user.until(lambda: bench.user.states[-1].tick > 5, "ticks")
    assert bench.user.states[-1].q[0] == 0.0
    bench.robot.x += 0.01
    # Its velocity follows from the poses: for a moment it seems to go on.
    bench.user.until(lambda: abs(bench.user.states[-1].q[0] - 0.01) < 1e-4, "its pose")
    state = bench.user.states[-1]
    assert state.status != PlantState.PAUSED
    assert bench.robot.heard["/cmd_vel"]
    assert bench.robot.heard["/arm/joint_trajectory"]


def test_a_pose_of_tf_that_jumps_stops_the_robot(bench):
    running(bench)
    bench.user.until(lambda: bench.user.states[-1].tick > 5, "ticks")
    bench.robot.x += 1.0
    bench.user.until(lambda: bench.user.states[-1].status == PlantState.PAUSED, "rest")
    assert "robot_a: the base jumped by 1 m" in bench.adapter.complaint()


@pytest.mark.parametrize("lost", [0, 1])
def test_a_controller_that_ends_stops_the_robot_with_its_topic(bench, lost):
    heard = running(bench)
    bench.user.until(lambda: bench.user.states[-1].tick > 5, "ticks")
    bench.robot.node.destroy_subscription(heard[lost])
    bench.user.until(lambda: bench.user.states[-1].status == PlantState.PAUSED, "rest")
    topic = ("/arm/joint_trajectory", "/cmd_vel")[lost]
    complaint = bench.adapter.complaint()
    assert f"disabled: robot_a: nobody listens to {topic}" in complaint
    assert not enable(bench).success


@pytest.mark.parametrize("bench", [{"command": "/arm/efforts", "type": "effort"}], indirect=True)
def test_an_arm_that_takes_torques_gets_them_until_the_end_of_the_process(bench):
    """While the platform brakes and nothing else of the node runs, states still make torques."""
    robot, adapter = bench.robot, bench.adapter
    robot.listen(Float64MultiArray, "/arm/efforts")
    robot.listen(Twist, "/cmd_vel")
    answers = []
    bench.user.until(lambda: answers.append(enable(bench)) or answers[-1].success, "enabling")
    bench.user.until(lambda: robot.heard["/arm/efforts"], "torques")
    robot.heard["/arm/efforts"].clear()
    adapter._plant._m.command[0] = 0.5  # m/s: as if it drove
    ended = threading.Event()

    def measure():
        while not ended.wait(0.01):
            robot.measure()

    thread = threading.Thread(target=measure)
    thread.start()
    adapter.close()
    ended.set()
    thread.join()
    bench.user.spin(0.5)
    assert len(robot.heard["/arm/efforts"]) > 10
    speeds = [twist.linear.x for twist in robot.heard["/cmd_vel"]]
    assert max(speeds) > 0.3
    assert speeds[-1] == 0.0
