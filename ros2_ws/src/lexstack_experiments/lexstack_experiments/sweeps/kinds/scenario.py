"""A run of a scenario: library and MuJoCo in one process, with the figures of the report."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from lexstack_bag.figures.goals import goals_of
from lexstack_experiments.loop import Loop
from lexstack_experiments.runs import analysed, scenario_of
from lexstack_experiments.sweeps.kinds.kind import Row, column, with_values


def scenario_run(config: Path, of: str, values: Mapping[str, Any]) -> Row:
    """Run a scenario with values of its own; returns the largest figures of the whole run.

    Raises:
        ConfigurationError: there is no such scenario, or a value does not fit it.
    """
    loop = Loop(with_values(scenario_of(config, of), values))
    loop.run()
    goals = goals_of(analysed(loop).metrics)
    record = loop.record
    chi = np.array([command.chi for command in record.commands])
    limits = loop.parts.team.limits
    return {
        "ticks": len(record.commands),
        "velocity_ratio": float((np.abs(chi) / limits.velocity).max()),
        "acceleration_ratio": _ratio(chi, limits.acceleration * loop.parts.dt),
        "empty_boxes": int(sum(command.bounds.empty for command in record.commands)),
        "fallbacks": sum(bool(command.fallback) for command in record.commands),
        "goals_missed": sum(goal.reached is False for goal in goals),
        **{
            column(goal.quantity, goal.unit): goal.value for goal in goals if goal.value is not None
        },
    }


def _ratio(chi: np.ndarray, step: np.ndarray) -> float:
    """Return the largest change of a command, over the largest that is allowed."""
    return float((np.abs(np.diff(chi, axis=0)) / step).max()) if len(chi) > 1 else 0.0
