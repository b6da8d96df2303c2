"""A plant file from controllers that run: small nodes with the topics of ros2_control's."""

from __future__ import annotations

import os
import threading

import pytest
import rclpy
import yaml
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from rclpy.executors import SingleThreadedExecutor
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory

from lexstack_bringup.commands import find_plant
from lexstack_config.plant_file import check_plant, load_plant
from lexstack_config.resolved import load_scenario
from support.scenario import CONFIG, ROOT

pytestmark = [pytest.mark.system, pytest.mark.timeout(120)]

JOINTS = ["torso_lift_joint", *(f"arm_{i}_joint" for i in range(1, 8))]


@pytest.fixture
def robot(monkeypatch):
    """Run the controllers of a TIAGo in a context of their own; yield their nodes."""
    domain = os.environ.get("ROS_DOMAIN_ID", "0")
    monkeypatch.setenv("LEXSTACK_ROOT", str(ROOT))
    context = rclpy.Context()
    rclpy.init(args=[], context=context, domain_id=int(domain))
    executor = SingleThreadedExecutor(context=context)

    def made(name):
        node = rclpy.create_node(name, context=context)
        executor.add_node(node)
        return node

    states, base = made("joint_state_broadcaster"), made("base_controller")
    arm, gripper = made("whole_body_controller"), made("gripper_controller")
    out = states.create_publisher(JointState, "/joint_states", 10)
    # Two publishers of one topic, each with a part of the joints.
    parts = [["head_1_joint", *JOINTS[4:]], JOINTS[:4]]
    states.create_timer(0.05, lambda: [out.publish(JointState(name=part)) for part in parts])
    for node, joints in ((arm, JOINTS), (gripper, ["finger"])):
        node.declare_parameter("joints", joints)
        topic = f"/{node.get_name()}/joint_trajectory"
        node.create_subscription(JointTrajectory, topic, lambda _message: None, 10)
    base.create_subscription(TwistStamped, "/base_controller/cmd_vel", lambda _message: None, 10)
    base.create_publisher(Odometry, "/base_controller/odom", 10)
    thread = threading.Thread(target=executor.spin)
    thread.start()
    yield {node.get_name(): node for node in (states, base, arm, gripper)}
    executor.shutdown()
    thread.join()
    rclpy.shutdown(context=context)


def test_the_file_of_a_robot_is_found_and_can_be_used(robot, tmp_path, capsys):
    assert find_plant.main(["drive", "--name", "tiago_found", "--wait", "2"]) == 0
    path = tmp_path / "tiago_found.yaml"
    path.write_text(capsys.readouterr().out, encoding="utf-8")
    plant = load_plant(path)
    check_plant(plant, load_scenario(CONFIG / "scenarios" / "drive.yaml"), "found")
    found = plant.robots["robot_a"]
    assert found.arm.command == "/whole_body_controller/joint_trajectory"
    assert found.joint_states.topic == "/joint_states"
    assert found.base.command == "/base_controller/cmd_vel"
    assert found.base.odometry == "/base_controller/odom"


def test_what_is_missing_is_said(robot, capsys):
    robot["whole_body_controller"].set_parameters(
        [rclpy.Parameter("joints", value=JOINTS[1:])],
    )
    assert find_plant.main(["drive", "--wait", "2"]) == 1
    printed = capsys.readouterr()
    assert "its controller lacks torso_lift_joint" in printed.err
    assert "not complete: the file" in printed.err
    assert "command" not in yaml.safe_load(printed.out)["robots"]["robot_a"]["arm"]


def test_wrong_arguments_are_refused(capsys):
    assert find_plant.main(["no_such_scenario"]) == 2
    assert "unknown scenario" in capsys.readouterr().err
