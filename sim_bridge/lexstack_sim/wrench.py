"""Pushes: forces and torques on a link for a while."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from lexstack.errors import InputError
from lexstack.options import shown
from lexstack.robots import RobotModel
from lexstack.types import Vector
from lexstack_sim.world import body_name

_STRONGEST = 1e4  # N, N m: more throws 150 kg out of the world


@dataclass(frozen=True, slots=True)
class Wrench:
    """A force and a torque in world axes at the origin of a link.

    Attributes:
        body: MuJoCo's number of the body that carries the link.
        offset: the link's origin in the body's frame, shape (3,), m.
        force: shape (3,), N.
        torque: shape (3,), N m.
        end: simulated time at which it ends [s].
    """

    body: int
    offset: Vector
    force: Vector
    torque: Vector
    end: float


def wrench_on(
    world: mujoco.MjModel, robot: RobotModel, link: str, force: Vector, torque: Vector, end: float
) -> Wrench:
    """Return a wrench on a link (any frame of the robot: ``base``, ``panda_link3``, ``tool``).

    Raises:
        InputError: the link is unknown, or a value is not finite.
    """
    model = robot.pinocchio
    if not model.existFrame(link) or model.frames[model.getFrameId(link)].parentJoint == 0:
        raise InputError(f"wrench: robot {robot.name} has no link {shown(link)}")
    for name, vector in (("force", force), ("torque", torque)):
        if np.shape(vector) != (3,) or not np.isfinite(vector).all():
            raise InputError(f"wrench: {name}: expected 3 finite numbers, got {vector}")
        if np.abs(vector).max() > _STRONGEST:
            raise InputError(f"wrench: {name}: at most {_STRONGEST:g} per axis, got {vector}")
    frame = model.frames[model.getFrameId(link)]
    body = world.body(body_name(robot, frame.parentJoint)).id
    offset = np.array(frame.placement.translation)
    return Wrench(body, offset, np.array(force), np.array(torque), end)


def apply_wrenches(world: mujoco.MjModel, data: mujoco.MjData, wrenches: list[Wrench]) -> None:
    """Write the sum of the wrenches at the present configuration into the applied forces."""
    mujoco.mj_kinematics(world, data)
    mujoco.mj_comPos(world, data)
    data.qfrc_applied[:] = 0.0
    for wrench in wrenches:
        point = data.xpos[wrench.body] + data.xmat[wrench.body].reshape(3, 3) @ wrench.offset
        mujoco.mj_applyFT(
            world, data, wrench.force, wrench.torque, point, wrench.body, data.qfrc_applied
        )
