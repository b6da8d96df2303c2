"""The default scenario, its team, and states to test with."""

from __future__ import annotations

import dataclasses
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from lexstack.robots import Team
from lexstack.types import RobotState
from lexstack_config.parts import build_team, home_of
from lexstack_config.resolved import ResolvedScenario, load_scenario

ROOT = Path(__file__).resolve().parents[2]
CONFIG = ROOT / "config"
SCENARIO = CONFIG / "scenarios" / "transition-sequence.yaml"


@cache
def resolved() -> ResolvedScenario:
    """Return the default scenario."""
    return load_scenario(SCENARIO)


@cache
def team() -> Team:
    """Return its two robots."""
    return build_team(resolved())


def changed(**values: Any) -> ResolvedScenario:
    """Return the default scenario with some of its values replaced."""
    return dataclasses.replace(
        resolved(), scenario=dataclasses.replace(resolved().scenario, **values)
    )


def home() -> np.ndarray:
    """Return where it starts."""
    return home_of(team(), resolved())


def state_at(q: np.ndarray, command: np.ndarray | None = None, tick: int = 0) -> RobotState:
    """Return a state at q, with the command that is in force."""
    chi = np.zeros_like(q) if command is None else command
    return RobotState(tick, 0.01 * tick, q, chi, q, chi)


def random_q(rng: np.random.Generator) -> np.ndarray:
    """Return a configuration within the arms' limits, bases within 3 m."""
    limits = team().limits
    lower = np.where(np.isfinite(limits.position_lower), limits.position_lower, -3.0)
    upper = np.where(np.isfinite(limits.position_upper), limits.position_upper, 3.0)
    return rng.uniform(lower, upper)
