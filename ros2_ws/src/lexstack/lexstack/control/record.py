"""What a run was, tick by tick, as arrays to plot."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lexstack.control.controller import Command
from lexstack.robots import Configuration, Team
from lexstack.types import Matrix, RobotState, Vector


@dataclass(frozen=True, eq=False)
class Record:
    """The ticks of a run, as arrays.

    Attributes:
        time: of each state, shape (k,), s.
        q: measured configurations, shape (k, n_q), m and rad.
        velocity: commands, shape (k, n_v), m/s and rad/s.
        lower: lower ends of the boxes that the commands were kept in, shape (k, n_v).
        upper: their upper ends, shape (k, n_v).
        residuals: of each level that the controller solved, shape (k, levels); NaN where a tick had
            fewer.
        alpha: share of a transition that is done, shape (k,); 1 between them.
        stacks: names of the stacks in effect.
        joints: names, in the order of ``velocity``.
    """

    time: Vector
    q: Matrix
    velocity: Matrix
    lower: Matrix
    upper: Matrix
    residuals: Matrix
    alpha: Vector
    stacks: tuple[str, ...]
    joints: tuple[str, ...]
    _team: Team

    @classmethod
    def of(cls, team: Team, states: Sequence[RobotState], commands: Sequence[Command]) -> Record:
        """Return the record of ticks that were served."""
        depth = max((len(command.slacks) for command in commands), default=0)
        residuals = np.full((len(commands), depth), np.nan)
        for row, command in zip(residuals, commands, strict=True):
            row[: len(command.slacks)] = command.slacks
        idle = [command.transition.to_stack == "" or not _moving(command) for command in commands]
        alpha = [
            1.0 if still else command.transition.alpha
            for still, command in zip(idle, commands, strict=True)
        ]
        return cls(
            np.array([state.stamp for state in states]),
            np.reshape([state.q for state in states], (-1, team.nq)),
            np.reshape([command.chi for command in commands], (-1, team.n)),
            np.reshape([command.bounds.lower for command in commands], (-1, team.n)),
            np.reshape([command.bounds.upper for command in commands], (-1, team.n)),
            residuals,
            np.array(alpha),
            tuple(command.stack for command in commands),
            tuple(joint for robot in team.robots for joint in robot.joints),
            team,
        )

    @property
    def acceleration(self) -> Matrix:
        """Changes of the command from tick to tick, per second, shape (k - 1, n_v)."""
        return np.asarray(np.diff(self.velocity, axis=0) / np.diff(self.time)[:, None])

    def path(self, frame: str = "tool", robot: str = "") -> Matrix:
        """Return where a frame was, shape (k, 3), m; raises ModelError for one that is not there.

        Args:
            frame: a link or joint, or ``tool``.
            robot: its name; it may be left out where there is one robot.
        """
        places = [Configuration.of(self._team, q).frame(frame, robot).pose.position for q in self.q]
        return np.reshape(places, (-1, 3))


def _moving(command: Command) -> bool:
    """Return whether a transition is under way."""
    return command.transition.phase.name in ("PREPARING", "BLENDING")
