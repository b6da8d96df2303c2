"""The HTMPC of a source tree, on states and references that are sent to it."""

from __future__ import annotations

import dataclasses
import os
from pathlib import Path
from time import thread_time
from typing import Any

import numpy as np
from layouts import first_of
from serving import serve, uncollected

Htmpc = first_of("lexstack.mpc:Htmpc", "lexstack_core.htmpc:Htmpc")
Objective = first_of("lexstack.mpc:Objective", "lexstack_core.htmpc:Objective")
RobotModel = first_of("lexstack.robots:RobotModel", "lexstack_core.model:RobotModel")
Scene = first_of("lexstack.mpc:CollisionScene", "lexstack_core.htmpc:Surroundings")
Start = first_of("lexstack.mpc:Start", "lexstack_core.htmpc:Start")
load_htmpc = first_of(
    "lexstack_config.resolved:load_htmpc", "lexstack_core.config.htmpc:load_htmpc"
)
load_robot = first_of(
    "lexstack_config.resolved:load_robot", "lexstack_core.config.resolved:load_robot"
)


class Solves:
    """Rows of solves by name, each with an optimiser of its own."""

    def __init__(self) -> None:
        """Begin with none."""
        self._rows: dict[str, tuple[Any, list[tuple[Any, ...]]]] = {}

    def load(self, name: str, row: dict[str, Any], states: list[dict[str, Any]]) -> int:
        """Take a row.

        Args:
            name: of the row.
            row: ``robot``, ``horizon``, ``parameters`` and the places of the robot's ``spheres``.
            states: each with ``stamp``, ``q``, ``v``, ``references`` (kind and array of each
                level), and ``centers`` and ``radii`` of what is in the way, empty without.
        """
        folder = Path(os.environ["LEXSTACK_ROOT"]) / "config"
        robot = RobotModel("robot", load_robot(folder / "robots" / f"{row['robot']}.yaml"))
        config = load_htmpc(folder / "htmpc" / f"{row['parameters']}.yaml")
        config = dataclasses.replace(config, horizon=row["horizon"])
        optimiser = Htmpc(robot, config, tuple(row["spheres"]))
        self._rows[name] = optimiser, [_arguments(state) for state in states]
        return len(states)

    def turn(self, name: str) -> list[float]:
        """Return the thread's processor time of every solve of a row [us].

        Each solve begins from this tree's own plan of the state before.
        """
        return uncollected(lambda: self._timed(*self._rows[name]))

    def _timed(self, optimiser: Any, states: list[tuple[Any, ...]]) -> list[float]:
        """Return the times of a row."""
        plan, times = None, []
        for start, objectives, around in states:
            begun = thread_time()
            plan = optimiser.solve(start, objectives, plan, around)
            times.append(1e6 * (thread_time() - begun))
        return times[1:]  # the first one has no plan to begin from


def _arguments(state: dict[str, Any]) -> tuple[Any, ...]:
    """Return what a solve takes."""
    start = Start(state["stamp"], np.array(state["q"]), np.array(state["v"]))
    objectives = tuple(
        Objective(f"{k}/{kind}", kind, np.array(rows))
        for k, (kind, rows) in enumerate(state["references"])
    )
    centers = np.array(state["centers"], dtype=float)
    around = Scene(centers, np.array(state["radii"])) if centers.size else None
    return start, objectives, around


if __name__ == "__main__":
    solves = Solves()
    serve({"load": solves.load, "turn": solves.turn})
