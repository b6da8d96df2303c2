"""HTIDKC: the tasks of the HTMPC at velocity level, on lexstack's strict HQP.

Each level asks for J chi = -kappa e. As in H, a level is regularised, so that it stays calm near
singularities: it minimises |J chi + kappa e|^2 + rho |chi|^2, and the levels below keep the J chi
that came out. Position, velocity and acceleration limits are the viable bounds of the HQP.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lexstack.errors import ConfigurationError
from lexstack.hqp import HqpProblem, Solution, make_solver
from lexstack.limits import viable_bounds
from lexstack.mpc import Kind, Objective, StageModel, measure_of
from lexstack.options import NotNegative, Positive
from lexstack.robots import RobotModel
from lexstack.types import LinearTask, Vector
from lexstack_config.reader import build, read_yaml


@dataclass(frozen=True, slots=True)
class HtidkcConfig:
    """One set of gains of the HTIDKC."""

    name: str  # of its file
    rate: Positive  # Hz
    ee_gain: Positive  # kappa [1/s]
    base_gain: Positive  # kappa [1/s]
    damping: NotNegative  # rho


def load_htidkc(path: Path) -> HtidkcConfig:
    """Return one file of ``config/htmpc/baselines``; raises ConfigurationError."""
    config = build(HtidkcConfig, read_yaml(path), str(path))
    if config.name != path.stem:
        raise ConfigurationError(f"{path}: name: expected {path.stem!r}, got {config.name!r}")
    return config


class Htidkc:
    """The controller of one robot; it remembers the last solution, as a first guess alone."""

    def __init__(self, robot: RobotModel, config: HtidkcConfig) -> None:
        """Make it; raises ModelError for a robot that the generated kinematics do not allow."""
        self.period = 1.0 / config.rate
        self._robot = robot
        self._config = config
        self._stage = StageModel(robot, 1)
        self._solver = make_solver()
        self._warm: Solution | None = None

    def solve(self, q: Vector, v: Vector, references: tuple[tuple[Kind, Vector], ...]) -> Solution:
        """Return chi (n,) for references of shape (r,), highest first, at the state q, v (n,)."""
        at = self._stage.at(q[None])
        bounds = viable_bounds(q, self._robot.limits, self.period, v)
        calm = LinearTask.equality(
            "calm",
            np.sqrt(self._config.damping) * np.eye(self._robot.n),
            np.zeros(self._robot.n),
        )
        kept: list[tuple[LinearTask, ...]] = []
        solution: Solution | None = None
        for i, (kind, reference) in enumerate(references):
            row = reference[None]
            measure = measure_of(Objective(kind, kind, row), self._robot)
            jacobian = measure.jacobian(at, row).reshape(-1, measure.rows, self._robot.n)[0]
            gain = self._config.ee_gain if kind.startswith("ee") else self._config.base_gain
            target = -gain * measure.error(at, row)[0]
            task = LinearTask.equality(f"{i}/{kind}", jacobian, target)
            problem = HqpProblem((*kept, (task, calm)), bounds)
            solution = self._solver.solve(problem, self._warm)
            if not solution.solved:
                return solution
            kept.append((LinearTask.equality(task.name, jacobian, jacobian @ solution.chi),))
        assert solution is not None, "at least one reference"
        self._warm = solution
        return solution
