"""Plants of the default scenario, and a motion for them."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from lexstack.types import Vector
from lexstack_sim.plant import Plant
from support.scenario import changed, resolved, team

Bases = list[tuple[float, float, float]]  # x [m], y [m], yaw [rad] of each robot

# Amplitudes of a lively motion of one robot: m/s, m/s, rad/s, and 7 x rad/s.
_LIVELY = np.array([0.3, 0.2, 0.3, 0.5, 0.4, 0.5, 0.5, 0.8, 0.8, 0.8])


def make_plant(bases: Bases | None = None, **values: Any) -> Plant:
    """Return a plant, with values of the scenario replaced and the robots placed elsewhere."""
    if bases is not None:
        robots = resolved().scenario.robots
        values["robots"] = {
            name: dataclasses.replace(place, base=base)
            for (name, place), base in zip(robots.items(), bases, strict=True)
        }
    return Plant(changed(**values), team())


def sine(plant: Plant, tick: int) -> Vector:
    """Return a chi in which all joints of all robots swing, started gently, shape (n,)."""
    swing = np.sin(2.0 * np.pi * 0.3 * tick * plant.period) * min(1.0, tick * plant.period)
    return np.tile(_LIVELY, plant.team.n // _LIVELY.size) * swing
