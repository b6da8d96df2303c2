"""Scenarios and plants for tests of the simulation."""

from __future__ import annotations

import dataclasses
import functools
from pathlib import Path

import numpy as np

from lexstack_core.config.resolved import ResolvedScenario, load_scenario
from lexstack_core.linear import Vector
from lexstack_core.model import Team
from lexstack_sim.plant import Plant

ROOT = Path(__file__).resolve().parents[2]

# Amplitudes of a lively motion of one robot: m/s, m/s, rad/s, and 7 x rad/s.
LIVELY = np.array([0.3, 0.2, 0.3, 0.5, 0.4, 0.5, 0.5, 0.8, 0.8, 0.8])


@functools.cache
def the_scenario() -> ResolvedScenario:
    """Return the paper's scenario: two robots, 100 Hz."""
    return load_scenario(ROOT / "config/scenarios/transition-sequence.yaml")


@functools.cache
def the_team() -> Team:
    """Return its team."""
    return Team.from_scenario(the_scenario())


Bases = list[tuple[float, float, float]]  # x [m], y [m], yaw [rad] of each robot


def scenario_with(bases: Bases | None = None, **changes: object) -> ResolvedScenario:
    """Return the scenario with fields of ScenarioConfig changed, and other start poses."""
    resolved = the_scenario()
    if bases is not None:
        names = list(resolved.scenario.robots)
        changes["robots"] = {
            name: dataclasses.replace(resolved.scenario.robots[name], base=base)
            for name, base in zip(names, bases, strict=True)
        }
    scenario = dataclasses.replace(resolved.scenario, **changes)
    return dataclasses.replace(resolved, scenario=scenario)


def make_plant(bases: Bases | None = None, **changes: object) -> Plant:
    """Return a plant of such a scenario."""
    return Plant(scenario_with(bases, **changes), the_team())


def sine(plant: Plant, tick: int) -> Vector:
    """Return a chi in which all joints of all robots swing, started gently, shape (n,)."""
    swing = np.sin(2.0 * np.pi * 0.3 * tick * plant.period) * min(1.0, tick * plant.period)
    return np.tile(LIVELY, plant.team.n // LIVELY.size) * swing
