"""The MuJoCo world of robots of any URDF against pinocchio, in random configurations."""

from __future__ import annotations

from functools import cache

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from lexstack.robots import RobotModel, Team
from lexstack_config.resolved import load_robot
from lexstack_sim.coordinates import Coordinates
from lexstack_sim.world import body_name, build_world
from support.scenario import CONFIG

TWELVE = (
    *("panda", "ur5", "ur10", "xarm7", "so101", "z1", "kinova"),
    *("tiago", "tiago_dual", "baxter", "pr2", "g1"),
)
SAMPLES = 150
AGREEMENT = 1e-9  # relative to the largest entry


@cache
def team_of(name):
    config = load_robot(CONFIG / "robots" / f"{name}.yaml")
    return Team((RobotModel(name, config, (0.3, -0.2, 0.7, 0.5)),), 0.01)


@cache
def world_of(name):
    world = build_world(team_of(name))
    return world, Coordinates(world, team_of(name))


def random_q(robot, rng):
    lower, upper = robot.limits.position_lower[robot.arm], robot.limits.position_upper[robot.arm]
    free = ~np.isfinite(lower)
    arm = rng.uniform(np.where(free, -4.0, lower), np.where(free, 4.0, upper))
    return np.concatenate((rng.uniform(-4.0, 4.0, robot.base_q.stop), arm))


def same(found, expected, scale=0.0):
    scale = max(scale, float(np.abs(expected).max()))
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=AGREEMENT * scale)


def mass_of(world, data):
    full = np.zeros((world.nv, world.nv))
    mujoco.mj_fullM(world, data, full)
    return full


@pytest.mark.parametrize("name", TWELVE)
def test_kinematics_mass_matrix_gravity_and_velocity_products_are_pinocchio_s(name):
    (robot,), (world, places) = team_of(name).robots, world_of(name)
    data, rng = mujoco.MjData(world), np.random.default_rng(3)
    model, own = robot.pinocchio, robot.pinocchio.createData()
    slopes = np.eye(robot.nq) if robot.map is None else robot.map.matrix
    matrix = places.matrix
    assert robot.differential == (name == "tiago")
    joints = range(1 + 2 * robot.has_base, model.njoints)
    bodies = [world.body(body_name(robot, joint)).id for joint in joints]
    for _ in range(SAMPLES):
        q, v = random_q(robot, rng), rng.uniform(-1.0, 1.0, robot.nq)
        places.put(data, q)
        data.qvel[:] = 0.0
        mujoco.mj_fwdPosition(world, data)
        mujoco.mj_fwdVelocity(world, data)
        pin.forwardKinematics(model, own, robot.positions(q))
        poses = [own.oMi[joint] for joint in joints]
        same(data.xpos[bodies], np.array([pose.translation for pose in poses]), 1.0)
        same(data.xmat[bodies], np.array([pose.rotation.ravel() for pose in poses]))
        chi = matrix @ robot.rate_matrix(q)  # qvel of each entry of chi
        same(chi.T @ mass_of(world, data) @ chi, robot.mass_matrix(q))
        gravity = slopes.T @ pin.computeGeneralizedGravity(model, own, robot.positions(q))
        same(matrix.T @ data.qfrc_bias, gravity, 1.0)
        data.qvel[:] = matrix @ v
        mujoco.mj_fwdVelocity(world, data)
        bias = slopes.T @ pin.nonLinearEffects(model, own, robot.positions(q), slopes @ v)
        same(matrix.T @ data.qfrc_bias, bias, 1.0)
