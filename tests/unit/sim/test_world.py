"""The world is the robots' pinocchio models, written down a second time."""

from __future__ import annotations

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from lexstack_sim.world import body_name, build_world
from support.scenario import home, team

SAMPLES = 1000
AGREEMENT = 1e-9


@pytest.fixture(scope="module")
def world():
    return build_world(team())


def random_configuration(rng):
    limits = team().limits
    lower = np.where(np.isfinite(limits.position_lower), limits.position_lower, -4.0)
    upper = np.where(np.isfinite(limits.position_upper), limits.position_upper, 4.0)
    return rng.uniform(lower, upper)


def test_kinematics_mass_matrix_and_gravity_agree_with_pinocchio(world):
    robots, data = team(), mujoco.MjData(world)
    rng = np.random.default_rng(0)
    mass = np.zeros((world.nv, world.nv))
    worst = dict.fromkeys(("position", "rotation", "mass", "gravity"), 0.0)
    for _ in range(SAMPLES):
        q = random_configuration(rng)
        data.qpos[:] = q
        mujoco.mj_fwdPosition(world, data)
        mujoco.mj_fwdVelocity(world, data)
        mujoco.mj_fullM(world, data, mass)
        for robot, part in zip(robots.robots, robots.slices, strict=True):
            model, own = robot.pinocchio, robot.pinocchio.createData()
            pin.forwardKinematics(model, own, q[part])
            for joint in range(3, model.njoints):
                body = data.body(body_name(robot, joint))
                pose = own.oMi[joint]
                note(worst, "position", body.xpos - pose.translation)
                note(worst, "rotation", body.xmat.reshape(3, 3) - pose.rotation)
            note(worst, "mass", mass[part, part] - symmetric(pin.crba(model, own, q[part])))
            gravity = pin.computeGeneralizedGravity(model, own, q[part])
            note(worst, "gravity", data.qfrc_bias[part] - gravity)
    assert max(worst.values()) <= AGREEMENT, worst


def note(worst, key, difference):
    worst[key] = max(worst[key], float(np.abs(difference).max()))


def symmetric(upper):
    return np.triu(upper) + np.triu(upper, 1).T


def test_velocity_products_agree_too(world):
    robots, data = team(), mujoco.MjData(world)
    rng = np.random.default_rng(1)
    for _ in range(20):
        q, v = random_configuration(rng), rng.uniform(-1.0, 1.0, robots.n)
        data.qpos[:], data.qvel[:] = q, v
        mujoco.mj_forward(world, data)
        for robot, part in zip(robots.robots, robots.slices, strict=True):
            model, own = robot.pinocchio, robot.pinocchio.createData()
            bias = pin.nonLinearEffects(model, own, q[part], v[part])
            np.testing.assert_allclose(data.qfrc_bias[part], bias, atol=1e-9)


def test_joints_and_actuators_are_those_of_chi_in_its_order(world):
    names = [f"{robot.name}/{joint}" for robot in team().robots for joint in robot.joints]
    assert [world.joint(i).name for i in range(world.njnt)] == names
    assert [world.actuator(i).name for i in range(world.nu)] == names


def test_the_jacobian_is_dense_and_a_divergence_does_not_reset(world):
    assert world.opt.jacobian == mujoco.mjtJacobian.mjJAC_DENSE
    assert world.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_AUTORESET


def test_looks_change_no_mass_and_no_contact(world):
    seen = build_world(team(), visuals=True)
    assert seen.ngeom > world.ngeom
    np.testing.assert_array_equal(seen.body_mass, world.body_mass)
    np.testing.assert_array_equal(seen.body_inertia, world.body_inertia)
    touching = seen.geom_contype | seen.geom_conaffinity
    assert np.count_nonzero(touching) == np.count_nonzero(world.geom_contype)


def test_nothing_touches_where_the_scenario_starts(world):
    data = mujoco.MjData(world)
    data.qpos[:] = home()
    mujoco.mj_forward(world, data)
    assert data.ncon == 0


@pytest.mark.parametrize(
    ("configuration", "touches"),
    [
        ({4: 1.2, 6: -2.4, 8: 1.5}, "chassis"),  # the arm reaches down to the platform
        ({4: 0.8, 6: -3.0, 8: 0.1}, "panda_link1"),  # the hand is folded onto the shoulder
    ],
)
def test_an_arm_touches_its_own_platform_and_shoulder(world, configuration, touches):
    data = mujoco.MjData(world)
    data.qpos[:] = home()
    for joint, angle in configuration.items():
        data.qpos[joint] = angle
    mujoco.mj_forward(world, data)
    names = {world.geom(int(geom)).name for pair in data.contact.geom for geom in pair}
    assert names
    assert all(name.startswith("robot_a/") for name in names)
    assert any(touches in name for name in names)


def test_neighbours_in_one_arm_never_touch(world):
    data, rng = mujoco.MjData(world), np.random.default_rng(2)
    for _ in range(300):
        data.qpos[:] = random_configuration(rng)
        data.qpos[10] += 20.0  # the other robot is far away
        mujoco.mj_forward(world, data)
        for pair in data.contact.geom:
            one, other = (int(world.geom_bodyid[geom]) for geom in pair)
            assert abs(one - other) >= 4
