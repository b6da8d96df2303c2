"""What a real arm carries and rubs against, and its model does not know of."""

from __future__ import annotations

import mujoco
import numpy as np
import pinocchio as pin

from lexstack.robots import RobotModel, Team
from lexstack_config.plant import PlantConfig
from lexstack_sim.coordinates import joint_name
from lexstack_sim.world import body_name, set_inertia

# MuJoCo's friction creeps under a steady load; this near to 1 it hardly does.
_STICTION = 0.9999


def add_payload_friction(
    world: mujoco.MjModel, data: mujoco.MjData, team: Team, config: PlantConfig
) -> None:
    """Add payload and friction to a compiled world; the pinocchio models stay as they are."""
    if config.friction:
        for robot in team.robots:
            for joint in robot.joints[robot.arm]:
                dof = world.joint(joint_name(robot, joint)).dofadr[0]
                world.dof_frictionloss[dof] = config.friction
                world.dof_solimp[dof, :2] = _STICTION
    if config.payload:
        for robot in team.robots:
            _add_payload(world, robot, config.payload)
    if config.friction or config.payload:
        mujoco.mj_setConst(world, data)


def _add_payload(world: mujoco.MjModel, robot: RobotModel, mass: float) -> None:
    """Add a point mass [kg] at the origin of a robot's tool."""
    model = robot.pinocchio
    frame = model.frames[model.getFrameId("tool")]
    load = pin.Inertia(mass, frame.placement.translation, np.zeros((3, 3)))
    total = model.inertias[frame.parentJoint] + load
    set_inertia(world, world.body(body_name(robot, frame.parentJoint)).id, total)
