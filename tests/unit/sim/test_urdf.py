"""The robots' URDF is the model that plant and library use."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np
import pinocchio as pin

from lexstack.robots import robot_from_urdf
from lexstack_config.parts import home_of
from lexstack_sim.urdf import robot_urdf
from support.scenario import resolved, team


def test_a_urdf_parser_finds_the_same_robot():
    robot = team().robots[0]
    parsed = pin.buildModelFromXML(robot_urdf(robot))
    fixed = robot.config.arm.fixed
    posture = pin.neutral(parsed)
    for joint, value in fixed.items():
        posture[parsed.joints[parsed.getJointId(joint)].idx_q] = value
    model = pin.buildReducedModel(parsed, [parsed.getJointId(name) for name in fixed], posture)
    assert tuple(model.names[1:]) == robot.joints
    model.armature = robot.pinocchio.armature
    rng = np.random.default_rng(0)
    home = home_of(team(), resolved())[team().slices[0]]
    for _ in range(20):
        q = home + rng.uniform(-0.5, 0.5, robot.n)
        theirs = np.concatenate([q[:2], [np.cos(q[2]), np.sin(q[2])], q[3:]])
        data, own = model.createData(), robot.pinocchio.createData()
        pin.framesForwardKinematics(model, data, theirs)
        tool = data.oMf[model.getFrameId("tool")]
        np.testing.assert_allclose(tool.translation, robot.tool(q)[0].position, atol=1e-9)
        np.testing.assert_allclose(tool.rotation, robot.tool(q)[0].rotation, atol=1e-9)
        mass = np.triu(pin.crba(model, data, theirs))
        np.testing.assert_allclose(mass, np.triu(pin.crba(robot.pinocchio, own, q)), atol=1e-8)


INERTIAL = (
    '<inertial><origin xyz="0.1 0 0.05"/><mass value="2"/>'
    '<inertia ixx="0.1" iyy="0.2" izz="0.15" ixy="0.01" ixz="0" iyz="0"/></inertial>'
)
PLATE = f"""<robot name="plate">
  <link name="ground"/><link name="foot">{INERTIAL}</link><link name="plate">{INERTIAL}</link>
  <link name="arm">{INERTIAL}</link><link name="slide_x_link">{INERTIAL}</link>
  <joint name="foot_joint" type="revolute"><parent link="ground"/><child link="foot"/>
    <origin xyz="0.1 0.2 0.3" rpy="0.3 -0.2 0.4"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" velocity="1" effort="10"/></joint>
  <joint name="slide" type="planar"><parent link="foot"/><child link="plate"/>
    <origin xyz="0.2 -0.1 0.4" rpy="-0.5 0.6 0.7"/><axis xyz="0 0 1"/>
    <limit lower="-0.4" upper="0.6" velocity="0.7" effort="33"/></joint>
  <joint name="lift" type="prismatic"><parent link="plate"/><child link="arm"/>
    <origin xyz="0 0.3 0.1" rpy="0.1 0.2 0.3"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" velocity="1" effort="10"/></joint>
  <joint name="hand_joint" type="fixed"><parent link="arm"/><child link="slide_x_link"/>
    <origin xyz="0.05 0 0.2" rpy="0.2 0 0"/></joint>
</robot>"""


SLIDES = {"slide_x": 0.7, "slide_y": 0.6, "slide_yaw": 0.5}
FORCES = {"slide_x": 33.0, "slide_y": 22.0, "slide_yaw": 11.0}


def plate(**place):
    """Return the robot; pinocchio's parser has no limits of a planar joint."""
    return robot_from_urdf(PLATE, tool="slide_x_link", velocity=SLIDES, torque=FORCES, **place)


def test_a_planar_joint_is_three_joints_of_the_same_motion():
    """Its links are where they are in the library, also beside a link with a name of ours."""
    robot = plate(place=(1.0, 2.0, 0.5, 0.7))
    assert robot.joints == ("foot_joint", "slide_x", "slide_y", "slide_yaw", "lift")
    parsed = pin.buildModelFromXML(robot_urdf(robot))
    assert tuple(parsed.names[1:]) == robot.joints
    rng = np.random.default_rng(0)
    for _ in range(10):
        q = rng.uniform(-1.0, 1.0, robot.n)
        theirs = np.concatenate([q[:3], [np.cos(q[3]), np.sin(q[3])], q[4:]])
        data, own = parsed.createData(), robot.pinocchio.createData()
        pin.framesForwardKinematics(parsed, data, theirs)
        for link in ("foot", "plate", "arm", "slide_x_link", "tool"):
            found, (pose, _) = data.oMf[parsed.getFrameId(link)], robot.at(q, robot.frame(link))
            np.testing.assert_allclose(found.translation, pose.position, atol=1e-9)
            np.testing.assert_allclose(found.rotation, pose.rotation, atol=1e-9)
        mass = np.triu(pin.crba(parsed, data, theirs)) - np.diag(parsed.armature)
        ours = np.triu(pin.crba(robot.pinocchio, own, q)) - np.diag(robot.pinocchio.armature)
        np.testing.assert_allclose(mass, ours, atol=1e-8)


def test_the_joints_of_a_planar_one_have_its_limits():
    robot = plate()
    root = ET.fromstring(robot_urdf(robot))
    limits = {joint.get("name"): joint.find("limit") for joint in root.iter("joint")}
    for i, axis in enumerate(("x", "y", "yaw"), start=1):
        limit = limits[f"slide_{axis}"]
        assert float(limit.get("velocity")) == robot.limits.velocity[i] == SLIDES[f"slide_{axis}"]
        assert float(limit.get("effort")) == FORCES[f"slide_{axis}"]
