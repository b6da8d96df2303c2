"""What a simulation cannot do as its files say, in lines that a person can act on."""

from __future__ import annotations

import numpy as np

from lexstack.robots import Team
from lexstack.types import Vector
from lexstack_sim.impedance import gravity
from lexstack_sim.meshes import missing_meshes


def notes(team: Team, home: Vector) -> tuple[str, ...]:
    """Return a line for each mesh that is left out, and for each joint too weak to hold its home.

    Args:
        team: the robots.
        home: where they start, shape (nq,).
    """
    lines = [line for robot in team.robots for line in missing_meshes(robot)]
    for robot, at in zip(team.robots, team.q_slices, strict=True):
        weight = np.abs(gravity(robot, robot.pinocchio.createData(), home[at]))[robot.arm_q]
        arm = robot.config.arm
        lines += [
            f"robot {robot.name}: joint {joint}: its torque limit of {most:g} does not hold the "
            f"{carried:.4g} of gravity where it starts, so it sinks (N m, or N where it slides)"
            for joint, most, carried in zip(arm.joints, arm.torque, weight, strict=True)
            if carried > most
        ]
    return tuple(lines)
