"""Kinematics at all stages of the horizon at once: one call of compiled code per iterate."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lexstack.robots import RobotModel
from lexstack.robots.assembly import TOOL
from lexstack.types import Matrix, Vector

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class FrameStates:
    """One frame of the robot at each stage, world frame.

    Attributes:
        position: of its origin, shape (N, 3), m.
        rotation: shape (N, 3, 3).
        jacobian: by q, shape (N, 6, n_q), linear then angular, LOCAL_WORLD_ALIGNED.
    """

    position: Matrix
    rotation: Array
    jacobian: Array


class StageKinematics(ABC):
    """Where frames and spheres are at each stage, world frame.

    Attributes:
        q: the configurations, shape (N, n_q).
        centers: of the spheres, shape (N, s, 3), m.
        found: what tasks and distances have found here, each by itself, so that none looks twice.
    """

    def __init__(self, q: Matrix, centers: Array) -> None:
        """Take configurations, and where the spheres are there."""
        self.q = q
        self.centers = centers
        self.found: dict[object, Any] = {}

    @property
    @abstractmethod
    def frames(self) -> dict[str, FrameStates]:
        """Those that the model was made for, by name."""

    @property
    @abstractmethod
    def slopes(self) -> Array:
        """Jacobians of the spheres' centres by q, shape (N, 3 s, n_q)."""

    @property
    def tool(self) -> FrameStates:
        """The frame ``tool``."""
        return self.frames[TOOL]


class GeneratedStages(StageKinematics):
    """As generated code has computed them, all at once."""

    def __init__(
        self, q: Matrix, centers: Array, frames: dict[str, FrameStates], slopes: Array
    ) -> None:
        """Take what was computed."""
        super().__init__(q, centers)
        self._frames, self._slopes = frames, slopes

    @property
    def frames(self) -> dict[str, FrameStates]:
        """Those that the model was made for, by name."""
        return self._frames

    @property
    def slopes(self) -> Array:
        """Jacobians of the spheres' centres by q, shape (N, 3 s, n_q)."""
        return self._slopes


class StageModel:
    """The generated kinematics of one robot over a horizon, with its buffers.

    Attributes:
        stages: how many configurations a call takes.
        n: coordinates of the robot, the length of its q.
        frames: names of those that a call returns.
        spheres: places in the robot's list of those that are kept apart from things.
        radii: of these, shape (s,), m.
        lifted: whether the arm moves them, so that they can keep off the floor, shape (s,).
    """

    def __init__(
        self,
        robot: RobotModel,
        stages: int,
        spheres: tuple[int, ...] = (),
        frames: tuple[str, ...] = (TOOL,),
    ) -> None:
        """Generate the code; raises ModelError where the robot does not allow it."""
        self.stages = stages
        self.n = robot.nq
        self.frames = frames
        self.spheres = spheres
        self._generate(robot)
        chosen = [robot.config.spheres[place] for place in spheres]
        self.radii: Vector = np.array([config.radius for config in chosen])
        on_arm: Matrix = robot.spheres.moved_by[:, robot.arm]
        base = robot.config.base
        inside = base is not None and base.chassis_mass == 0.0  # the URDF has the chassis
        self.lifted = np.array(
            [
                config.link != "base" and not (inside and not on_arm[place].any())
                for place, config in zip(spheres, chosen, strict=True)
            ],
            dtype=bool,
        )

    def _generate(self, robot: RobotModel) -> None:
        """Generate the code, and its buffers."""
        from lexstack.mpc.symbolic import stage_function  # noqa: PLC0415 - CasADi, 0.1 s

        function = stage_function(robot, self.spheres, self.frames).map(self.stages)
        count = len(self.spheres)
        self._q = np.zeros((self.stages, self.n))
        one = ((3,), (3, 3), (6, self.n))
        shapes = (*one * len(self.frames), (count, 3), (3 * count, self.n))
        self._results = tuple(np.zeros((self.stages, *shape)) for shape in shapes)
        # The buffer object must live as long as the call that writes through it.
        buffer: tuple[Any, Any] = function.buffer()
        self._buffer, self._call = buffer
        self._buffer.set_arg(0, self._q.data)
        for i, result in enumerate(self._results):
            if result.size:
                self._buffer.set_res(i, result.data)

    def at(self, q: Matrix) -> StageKinematics:
        """Return the kinematics at configurations of shape (N, n_q); they are copied."""
        self._q[:] = q
        self._call()
        *parts, centers, slopes = (result.copy() for result in self._results)
        places = {
            name: FrameStates(*parts[3 * i : 3 * i + 3]) for i, name in enumerate(self.frames)
        }
        return GeneratedStages(self._q.copy(), centers, places, slopes)
