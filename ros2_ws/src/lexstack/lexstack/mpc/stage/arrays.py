"""Limits, scene and tasks of a solve as the arrays that the compiled code takes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, lru_cache

import numpy as np

from lexstack.mpc.barriers import LimitBarrier
from lexstack.mpc.collision_cost import Collisions
from lexstack.mpc.effort import Effort
from lexstack.mpc.measures import Kind, Measure
from lexstack.mpc.options import HtmpcConfig
from lexstack.mpc.stage.kernel.values import (
    BASE_POSE,
    COORDINATES,
    ORIENTATION,
    POSE,
    POSITION,
    REFERENCE,
    ROW,
    ROWS,
    Limits,
    Places,
    Scene,
    Tasks,
)
from lexstack.mpc.tracking_objectives import Task

_KINDS: dict[Kind, int] = {
    "ee_position": POSITION,
    "ee_pose": POSE,
    "ee_orientation": ORIENTATION,
    "base_position": COORDINATES,
    "base_pose": BASE_POSE,
    "joint_positions": COORDINATES,
}


@dataclass(frozen=True, slots=True, eq=False)
class Costs:
    """What does not change from solve to solve: barriers before limits, effort, and both as arrays.

    Attributes:
        barrier: of the limits.
        effort: of the inputs.
        limits: both, and the settings of the barriers.
    """

    barrier: LimitBarrier
    effort: Effort
    limits: Limits

    @classmethod
    def of(cls, config: HtmpcConfig, barrier: LimitBarrier, effort: Effort) -> Costs:
        """Return them as arrays, too."""
        bounded = barrier.bounded.astype(np.int64)
        limits, collision = config.limits, config.collision
        reach = collision.influence - collision.margin if collision.influence else np.inf
        settings = np.array([limits.mu, limits.zeta, collision.mu, collision.zeta, reach])
        weights = np.stack((effort.velocity, effort.input, effort.change))
        laid_out = Limits(bounded, barrier.lower, barrier.upper, weights, settings)
        return cls(barrier, effort, laid_out)


def scene_of(collisions: Collisions, stages: int) -> Scene:
    """Return what spheres keep off as arrays; none where nothing is to be kept off."""
    if not collisions.active:
        return _nothing_around(stages)
    around = collisions.around
    centers = np.zeros((stages, 0, 3)) if around is None else around.centers
    return Scene(
        np.ascontiguousarray(centers, dtype=float),
        collisions.reach,
        collisions.lifted.astype(np.int64),
        collisions.height,
    )


@cache
def _nothing_around(stages: int) -> Scene:
    """Return a scene in which no sphere keeps off anything."""
    return Scene(
        np.zeros((stages, 0, 3)), np.zeros((0, 0)), np.zeros(0, dtype=np.int64), np.zeros(0)
    )


@lru_cache(maxsize=256)
def layout_of(measure: Measure, frames: tuple[str, ...]) -> tuple[Places, Places]:
    """Return the layout of a task as if it were alone, shape (5,), and its coordinates, (s,)."""
    point = frames.index(measure.frame) if measure.frame else -1
    layout = np.array([_KINDS[measure.kind], point, measure.rows, 0, 0], dtype=np.int64)
    places = measure.places or (0,) * measure.rows
    return layout, np.array(places, dtype=np.int64)


@lru_cache(maxsize=256)
def layouts_of(measures: tuple[Measure, ...], frames: tuple[str, ...]) -> tuple[Places, Places]:
    """Return the layouts of tasks, shape (T, 5), and the coordinates of all their rows."""
    each = [layout_of(measure, frames) for measure in measures]
    layout = np.array([one for one, _ in each], dtype=np.int64).reshape(-1, 5)
    layout[1:, ROW] = np.cumsum(layout[:-1, ROWS])
    layout[1:, REFERENCE] = np.cumsum([measure.columns for measure in measures[:-1]])
    return layout, np.array([place for _, places in each for place in places], dtype=np.int64)


def tasks_of(tasks: Sequence[Task], frames: tuple[str, ...]) -> Tasks:
    """Return tasks as arrays."""
    layout, places = layouts_of(tuple(task.measure for task in tasks), frames)
    if not tasks:
        return Tasks(layout, places, np.zeros(0), np.zeros(0))
    return Tasks(
        layout,
        places,
        np.concatenate([task.reference.ravel() for task in tasks], dtype=float),
        np.concatenate([task.weights.ravel() for task in tasks]),
    )
