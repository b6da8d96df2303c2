"""The models against finite differences and the configuration."""

import dataclasses

import numpy as np
import pinocchio as pin
import pytest

from lexstack.errors import ConfigurationError, ModelError
from lexstack.robots import FrameConfig, RobotModel, Team, description_path
from support.scenario import home, random_q, resolved, state_at, team

RNG = np.random.default_rng(1)


@pytest.mark.parametrize("_", range(20))
def test_the_jacobian_is_the_derivative_of_the_pose(_):
    robot = team().robots[1]
    q = random_q(RNG)[team().slices[1]]
    pose, jacobian = robot.tool(q)
    step = 1e-6
    for joint in range(robot.n):
        delta = np.zeros(robot.n)
        delta[joint] = step
        ahead, behind = robot.tool(q + delta)[0], robot.tool(q - delta)[0]
        linear = (ahead.position - behind.position) / (2 * step)
        angular = pin.log3(ahead.rotation @ behind.rotation.T) / (2 * step)
        np.testing.assert_allclose(jacobian[:3, joint], linear, atol=1e-7)
        np.testing.assert_allclose(jacobian[3:, joint], angular, atol=1e-7)
    assert pose.rotation @ pose.rotation.T == pytest.approx(np.eye(3), abs=1e-12)


def test_the_base_moves_the_tool_in_the_world_frame():
    robot = team().robots[0]
    q = robot.home((0.0, 0.0, 0.0))
    before = robot.tool(q)[0].position
    turned = q.copy()
    turned[:3] = [1.0, -2.0, np.pi / 2]
    after = robot.tool(turned)[0].position
    x, y, z = before
    np.testing.assert_allclose(after, [1.0 - y, -2.0 + x, z], atol=1e-12)


def test_the_tool_is_where_the_configuration_puts_it():
    config = resolved().robots["panda_summit"]
    longer = dataclasses.replace(
        config, tool=dataclasses.replace(config.tool, xyz=(0.0, 0.0, config.tool.xyz[2] + 0.1))
    )
    q = team().robots[0].home((0.0, 0.0, 0.0))
    short, long = team().robots[0].tool(q)[0], RobotModel("r", longer).tool(q)[0]
    np.testing.assert_allclose(
        long.position - short.position, 0.1 * short.rotation[:, 2], atol=1e-12
    )


def test_masses_and_armature_are_those_of_the_configuration():
    robot = team().robots[0]
    base = robot.config.base
    arm = robot.pinocchio.inertias[4:]
    platform = base.chassis_mass + 4 * base.wheels.mass
    assert robot.pinocchio.inertias[3].mass == pytest.approx(
        platform + 0.629769  # the arm's first link stands on the platform
    )
    assert sum(body.mass for body in arm) > 15.0
    np.testing.assert_array_equal(robot.pinocchio.armature[3:], robot.config.arm.armature)


def test_the_team_stacks_its_robots():
    both = team()
    assert both.n == 20
    assert both.slices == (slice(0, 10), slice(10, 20))
    q = home()
    tools = both.tools(q)
    np.testing.assert_allclose(tools[1].position - tools[0].position, [2.0, 0.0, 0.0], atol=1e-12)
    kinematics = both.kinematics(state_at(q))
    assert [j.shape for j in kinematics.jacobians] == [(6, 10), (6, 10)]
    assert np.isinf(both.limits.position_upper[[0, 1, 2, 10, 11, 12]]).all()


def test_wrong_teams_and_models_are_refused():
    robot = team().robots[0]
    with pytest.raises(ConfigurationError, match="names must differ"):
        Team((robot, robot), 0.01)
    with pytest.raises(ConfigurationError, match="unknown robot 'x'; known: robot_a, robot_b"):
        team().index("x")
    config = robot.config
    frame = FrameConfig("nothing", (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    with pytest.raises(ModelError, match="no link 'nothing'"):
        RobotModel("r", dataclasses.replace(config, tool=frame))
    arm = dataclasses.replace(config.arm, joints=(*config.arm.joints[:-1], "elbow"))
    with pytest.raises(ModelError, match="no joint 'elbow'"):
        RobotModel("r", dataclasses.replace(config, arm=arm))
    arm = dataclasses.replace(config.arm, fixed={})
    with pytest.raises(ModelError, match="movable joints"):
        RobotModel("r", dataclasses.replace(config, arm=arm))
    with pytest.raises(ModelError, match="no file"):
        description_path("none.urdf")
