"""Obstacles in the world: spheres that go their way whatever pushes them, and that touch."""

from __future__ import annotations

import itertools

import mujoco
import numpy as np

from lexstack.robots import Obstacles, Team
from lexstack.types import Matrix, Vector
from lexstack_sim.contacts import OBSTACLE
from lexstack_sim.coordinates import Coordinates

_GROUP = 1  # of geoms that are visible
_COLOR = (0.85, 0.15, 0.12, 1.0)


def add_obstacles(spec: mujoco.MjSpec, obstacles: Obstacles) -> None:
    """Add each obstacle as a sphere where it is at first; they collide with robots alone."""
    for name, center, radius in zip(
        obstacles.names, obstacles.at(0.0), obstacles.radii, strict=True
    ):
        body = spec.worldbody.add_body(name=obstacle_name(name), mocap=True, pos=center)
        body.add_geom(
            name=obstacle_name(name),
            type=mujoco.mjtGeom.mjGEOM_SPHERE,
            size=(radius, 0.0, 0.0),
            rgba=_COLOR,
            contype=OBSTACLE,
            conaffinity=OBSTACLE - 1,
            group=_GROUP,
        )


def obstacle_name(obstacle: str) -> str:
    """Return the name of an obstacle's body and geom."""
    return f"obstacle/{obstacle}"


class Clearance:
    """Distances between what can touch: the robots' contact geometry, not their spheres."""

    def __init__(self, world: mujoco.MjModel, team: Team) -> None:
        """Measure in a world that was built with this team and its obstacles."""
        self._world = world
        self._data = mujoco.MjData(world)
        self._coordinates = Coordinates(world, team)
        self._obstacles = obstacles = team.obstacles
        names = [world.geom(i).name for i in range(world.ngeom)]
        self._geoms = [
            [i for i, name in enumerate(names) if name.startswith(f"{robot}/contact/")]
            for robot in team.names
        ]
        self._spheres = [[names.index(obstacle_name(name))] for name in obstacles.names]

    def at(self, q: Vector, stamp: float, most: float = 1.0) -> Matrix:
        """Return the distance of each robot to each obstacle, shape (robots, k), m.

        Args:
            q: configuration of all robots, shape (n,).
            stamp: simulated time [s].
            most: distances above this are given as this [m]; negative ones are depths.
        """
        self._data.mocap_pos[:] = self._obstacles.at(stamp)
        return self._distances(q, self._geoms, self._spheres, most)

    def between(self, q: Vector, most: float = 1.0) -> Matrix:
        """Return the distance of each robot to each, shape (robots, robots), m.

        Args:
            q: configuration of all robots, shape (n,).
            most: as above; also the distance of a robot to itself, which is not looked at.
        """
        return self._distances(q, self._geoms, self._geoms, most)

    def _distances(
        self, q: Vector, ones: list[list[int]], others: list[list[int]], most: float
    ) -> Matrix:
        """Return the least distance between the geoms of two sets, for all sets."""
        self._coordinates.put(self._data, q)
        mujoco.mj_kinematics(self._world, self._data)
        result: Matrix = np.full((len(ones), len(others)), most)
        for i, j in np.ndindex(*result.shape):
            if ones[i] is not others[j]:
                result[i, j] = min(
                    mujoco.mj_geomDistance(self._world, self._data, one, other, most, None)
                    for one, other in itertools.product(ones[i], others[j])
                )
        return result
