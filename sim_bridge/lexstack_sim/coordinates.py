"""Where the entries of q stand in MuJoCo's vectors, and the joints that follow them."""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray

from lexstack.errors import ModelError
from lexstack.robots import RobotModel, Team
from lexstack.types import Matrix, Vector

Indices = NDArray[np.intp]


class Coordinates:
    """From q and its derivative to MuJoCo's qpos and qvel, and back.

    MuJoCo numbers joints along the tree of bodies, q as the robot's file lists them; and joints
    that mimic others have places of their own in MuJoCo. Every joint has one coordinate, so its
    place is the same in qpos and in qvel. ``Driving`` has the way from q' to chi.

    Attributes:
        places: of the entries of q, shape (nq,).
        followers: places of the mimicking joints, shape (m,).
        ratios: of their velocities to q', shape (m, nq): qpos[followers] = ratios q + offsets.
        offsets: shape (m,), rad or m.
        direct: whether qpos is q and qvel is q'.
    """

    def __init__(self, world: mujoco.MjModel, team: Team) -> None:
        """Look the joints up; raises ModelError where joints or actuators are not q's."""
        names = [joint_name(robot, joint) for robot in team.robots for joint in robot.coordinates]
        actuators = [world.actuator(i).name for i in range(world.nu)]
        if actuators != names:
            raise ModelError(f"the world's actuators {actuators} are not q's: {names}")
        self.places: Indices = np.array([_place(world, name) for name in names], dtype=np.intp)
        followers: list[int] = []
        ratios: list[Vector] = [np.zeros((0, team.nq))]
        offsets: list[Vector] = [np.zeros(0)]
        for robot, part in zip(team.robots, team.q_slices, strict=True):
            if robot.map is None:
                continue
            rows = following(robot)
            joints = [robot.pinocchio.names[1 + row] for row in rows]
            followers += [_place(world, joint_name(robot, joint)) for joint in joints]
            matrix = np.zeros((len(rows), team.nq))
            matrix[:, part] = robot.map.matrix[rows]
            ratios.append(matrix)
            offsets.append(robot.map.offset[rows])
        self.followers: Indices = np.array(followers, dtype=np.intp)
        self.ratios: Matrix = np.concatenate(ratios)
        self.offsets: Vector = np.concatenate(offsets)
        if world.njnt != len(self.places) + len(self.followers):
            raise ModelError(f"the world has {world.njnt} joints, not those of its robots alone")
        self.direct = self.places.tolist() == list(range(world.nq))

    def put(self, data: mujoco.MjData, q: Vector) -> None:
        """Write q, shape (nq,), into qpos, mimicking joints included."""
        data.qpos[self.places] = q
        data.qpos[self.followers] = self.ratios @ q + self.offsets

    def read(self, data: mujoco.MjData, q: Vector, v: Vector) -> None:
        """Write the positions and velocities of the joints of q into q and v, shape (nq,)."""
        np.take(data.qpos, self.places, out=q)
        np.take(data.qvel, self.places, out=v)

    def couple(self, data: mujoco.MjData, q: Vector, v: Vector) -> None:
        """Put the mimicking joints exactly where q and v = q', shape (nq,), have them."""
        data.qpos[self.followers] = self.ratios @ q + self.offsets
        data.qvel[self.followers] = self.ratios @ v

    @property
    def matrix(self) -> Matrix:
        """E of qvel = E q', shape (nv, nq)."""
        result = np.zeros((len(self.places) + len(self.followers), len(self.places)))
        result[self.places, np.arange(len(self.places))] = 1.0
        result[self.followers] = self.ratios
        return result


def following(robot: RobotModel) -> list[int]:
    """Return the places, in the model's configuration, of the joints that mimic others."""
    names = robot.pinocchio.names[1:]
    return [i for i, name in enumerate(names) if name not in robot.coordinates]


def joint_name(robot: RobotModel, joint: str) -> str:
    """Return a joint's name in the world; actuators bear their joint's name."""
    return f"{robot.name}/{joint}"


def _place(world: mujoco.MjModel, name: str) -> int:
    """Return a joint's place in qpos."""
    return int(world.joint(name).qposadr[0])
