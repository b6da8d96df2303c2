"""The robots' URDF is the model that plant and library use."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

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
