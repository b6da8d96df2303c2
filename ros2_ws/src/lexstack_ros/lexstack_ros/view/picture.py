"""What the page shows of one instant, and of the time before it: values, whoever has found them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from lexstack.references import Frame, References
from lexstack.robots import Pose
from lexstack.types import Matrix, PlantStatus, Vector

WINDOW = 20.0  # s of simulated time that the plots cover


@dataclass(frozen=True, slots=True)
class Picture:
    """A run at one instant.

    Attributes:
        time: simulated [s].
        tick: of the plant.
        q: configuration of all robots, shape (nq,).
        plant: what the plant does.
        stack: which stack is in effect, and which one comes.
        phase: of the transition, in a word.
        alpha: how far the transition is, 0 to 1.
        source: what the transition moves to.
        reason: why it is where it is, or ''.
        levels: residual of each level of the command, level 1 first [m/s, rad/s].
        solve: time of the last solve of each controller [ms], nan: nothing was solved since.
        references: in effect.
        goals: where the references lead.
        frames: of further frames that tasks of the stacks in effect move: where their references
            lead, or where the frames are as long as they have none.
        obstacles: centers, shape (k, 3), m, world.
        horizons: of the plans of the MPC: positions of the tool over the horizon, shape (m, 3), m,
            by the robot's place in the team.
        sequences: what the MPC works on, in words, one line for each robot that it plans for.
    """

    time: float
    tick: int
    q: Vector
    plant: PlantStatus
    stack: str
    phase: str
    alpha: float
    source: str
    reason: str
    levels: tuple[float, ...]
    solve: Mapping[str, float]
    references: References
    goals: References
    obstacles: Matrix
    horizons: Mapping[int, Matrix] = field(default_factory=dict)
    frames: Mapping[Frame, Pose] = field(default_factory=dict)
    sequences: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Curves:
    """What is plotted over the last seconds, m samples.

    Attributes:
        time: simulated [s], shape (m,).
        levels: residuals [m/s, rad/s], shape (l, m), nan where there was no such level.
        solve: times of solves [ms] by controller, shape (m,) each, nan where nothing was solved.
        alpha: of the transition, shape (m,).
        plant: status of the plant, shape (m,).
    """

    time: Vector
    levels: Matrix
    solve: Mapping[str, Vector]
    alpha: Vector
    plant: Vector


def curves(pictures: Sequence[Picture]) -> Curves:
    """Return the plots of pictures, in the order of their times."""
    most = max((len(picture.levels) for picture in pictures), default=0)
    levels = np.full((most, len(pictures)), np.nan)
    for column, picture in enumerate(pictures):
        levels[: len(picture.levels), column] = picture.levels
    names = sorted({name for picture in pictures for name in picture.solve})
    return Curves(
        np.array([picture.time for picture in pictures]),
        levels,
        {
            name: np.array([picture.solve.get(name, np.nan) for picture in pictures])
            for name in names
        },
        np.array([picture.alpha for picture in pictures]),
        np.array([int(picture.plant) for picture in pictures]),
    )


class History:
    """The pictures of the last seconds; a time that goes back begins again."""

    def __init__(self) -> None:
        """Start empty."""
        self._pictures: list[Picture] = []

    def add(self, picture: Picture) -> None:
        """Take the next picture; one of the same time as the last adds nothing."""
        last = self._pictures[-1].time if self._pictures else -np.inf
        if picture.time < last:
            self._pictures = []
        if picture.time != last:
            self._pictures.append(picture)
        begin = picture.time - WINDOW
        first = next(i for i, one in enumerate(self._pictures) if one.time >= begin)
        del self._pictures[:first]

    def curves(self) -> Curves:
        """Return what is plotted of them."""
        return curves(self._pictures)
