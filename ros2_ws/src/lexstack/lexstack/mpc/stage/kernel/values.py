"""What the compiled functions take: a robot, its limits, what is around it, and its tasks."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lexstack.types import Matrix, Vector

Array = NDArray[np.float64]
Places = NDArray[np.int64]

# Types of arrays that are read, for signatures.
V = "Array(float64, 1, 'C', readonly=True)"
M = "Array(float64, 2, 'C', readonly=True)"
A3 = "Array(float64, 3, 'C', readonly=True)"
A4 = "Array(float64, 4, 'C', readonly=True)"
I1 = "Array(int64, 1, 'C', readonly=True)"
I2 = "Array(int64, 2, 'C', readonly=True)"

# The kinds of a task's error: first entry of its layout.
POSITION, POSE, ORIENTATION, COORDINATES, BASE_POSE = range(5)
KIND, POINT, ROWS, ROW, REFERENCE = range(5)
"""Columns of a layout: the kind; the place of its frame among the points; how many rows it has;
where its rows begin, and where the columns of its reference begin, per stage."""


class Chain(NamedTuple):
    """The joints that carry a point, each after its parent, and the points.

    Attributes:
        joints: parent (-1: the world), whether it turns, and its coordinate in q, shape (J, 3).
        turning: A, B, C of its rotation A + cos B + sin C in its parent, shape (J, 3, 3, 3); one
            that slides has A alone.
        fixed: origin in its parent (3), axis in its own frame (3), factor and offset of its
            position by its coordinate, shape (J, 8).
        bodies: the joint of each point (-1: the world), frames first, shape (P,).
        offsets: of each point in its joint's frame, shape (P, 3), m.
        attitudes: of each frame in its joint's frame, shape (F, 3, 3).
    """

    joints: Places
    turning: Array
    fixed: Matrix
    bodies: Places
    offsets: Matrix
    attitudes: Array


class Limits(NamedTuple):
    """Barriers before the limits of the joints, and weights of the effort.

    Attributes:
        bounded: joints with limits of position, shape (b,).
        lower: of these positions, all velocities, all inputs, shape (b + 2 n,).
        upper: likewise.
        effort: weights of velocity, input, change of input, shape (3, n).
        settings: mu and zeta of the limits, then of distances, then the reach of a distance [m].
    """

    bounded: Places
    lower: Vector
    upper: Vector
    effort: Matrix
    settings: Vector


class Scene(NamedTuple):
    """What the spheres keep off.

    Attributes:
        centers: of things, shape (N, o, 3), m.
        reach: distances at which a barrier ends, shape (s, o), m; without rows: no spheres.
        lifted: the spheres that keep off the floor.
        heights: at which their barrier ends, of each of these, m.
    """

    centers: Array
    reach: Matrix
    lifted: Places
    heights: Vector


class Tasks(NamedTuple):
    """All tasks, one after the other.

    Attributes:
        layout: one row per task, shape (T, 5).
        places: the coordinate of each row of a task of coordinates, by row of all tasks.
        references: (N, r) of each task, flat.
        weights: (N, s) of each task, flat.
    """

    layout: Places
    places: Places
    references: Vector
    weights: Vector


class Stages(NamedTuple):
    """Where the joints and the points are.

    Attributes:
        rotations: of the joints, shape (N, J, 3, 3).
        origins: of the joints, shape (N, J, 3), m.
        points: shape (N, P, 3), m.
        frames: rotations of the frames, shape (N, F, 3, 3).
    """

    rotations: Array
    origins: Array
    points: Array
    frames: Array
