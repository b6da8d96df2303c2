"""The compiled kinematics of a robot over a horizon: what ``StageModel`` has from CasADi."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from lexstack.mpc.stage.chain import chain_of
from lexstack.mpc.stage.kernel.values import Stages
from lexstack.mpc.stage_kinematics import FrameStates, StageKinematics, StageModel
from lexstack.robots import RobotModel
from lexstack.types import Matrix

Array = NDArray[np.float64]


class CompiledStages(StageKinematics):
    """As the compiled code has left them; derivatives are computed when they are asked for.

    Attributes:
        stages: of the joints and points, which the derivatives start from.
    """

    def __init__(self, model: CompiledStageModel, q: Matrix, stages: Stages) -> None:
        """Take coordinates of shape (N, n_q), and what was computed for them."""
        super().__init__(q, stages.points[:, len(model.frames) :])
        self.stages = stages
        self._model = model

    @cached_property
    def frames(self) -> dict[str, FrameStates]:
        """Those that the model was made for, by name."""
        return self._model.frame_states(self.stages)

    @cached_property
    def slopes(self) -> Array:
        """Jacobians of the spheres' centres by q, shape (N, 3 s, n_q)."""
        return self._model.sphere_slopes(self.stages)


class CompiledStageModel(StageModel):
    """The kinematics of one robot over a horizon; needs numba.

    Attributes:
        chain: its joints and points as arrays.
    """

    def _generate(self, robot: RobotModel) -> None:
        """Lay the joints out; the code is there."""
        from lexstack.mpc.stage.kernel import chain  # noqa: PLC0415 - loads numba

        self.chain = chain_of(robot, self.spheres, self.frames)
        self._place, self._derive = chain.place_all, chain.slopes_all

    def at(self, q: Matrix) -> CompiledStages:
        """Return the kinematics at configurations of shape (N, n_q); they are copied."""
        own = np.array(q, dtype=float, order="C")
        stages = self.empty()
        self._place(*self.chain, own, *stages)
        return CompiledStages(self, own, stages)

    def empty(self) -> Stages:
        """Return arrays to be written."""
        n, joints, points = self.stages, len(self.chain.joints), len(self.chain.bodies)
        return Stages(
            np.empty((n, joints, 3, 3)),
            np.empty((n, joints, 3)),
            np.empty((n, points, 3)),
            np.empty((n, len(self.frames), 3, 3)),
        )

    def frame_states(self, stages: Stages) -> dict[str, FrameStates]:
        """Return the frames with their Jacobians, by name."""
        count = len(self.frames)
        jacobians = np.empty((self.stages, count, 6, self.n))
        self._derive(*self.chain, *stages, 0, jacobians)
        return {
            name: FrameStates(stages.points[:, i], stages.frames[:, i], jacobians[:, i])
            for i, name in enumerate(self.frames)
        }

    def sphere_slopes(self, stages: Stages) -> Array:
        """Return the Jacobians of the spheres' centres, shape (N, 3 s, n_q)."""
        count = len(self.spheres)
        slopes = np.empty((self.stages, count, 3, self.n))
        self._derive(*self.chain, *stages, len(self.frames), slopes)
        return slopes.reshape(self.stages, 3 * count, self.n)
