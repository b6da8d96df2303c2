"""Distances that the robot's spheres keep over the horizon, H(7c), as relaxed barriers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lexstack.errors import InputError
from lexstack.mpc.barriers import relaxed_within, slopes_within
from lexstack.mpc.options import CollisionConfig
from lexstack.mpc.stage_kinematics import StageKinematics, StageModel
from lexstack.types import Matrix, Vector

Array = NDArray[np.float64]
_CONCENTRIC = 1e-9  # m: below this there is no direction away


@dataclass(frozen=True, slots=True, eq=False)
class CollisionScene:
    """Spheres in the way over the horizon: obstacles, and those of the other robot.

    Attributes:
        centers: at the states 1 to N, shape (N, o, 3), m, world frame.
        radii: shape (o,), m.
    """

    centers: Array
    radii: Vector

    @classmethod
    def moving(
        cls, starts: Matrix, velocities: Matrix, radii: Vector, times: Vector
    ) -> CollisionScene:
        """Return spheres that go straight: shapes (o, 3) [m], (o, 3) [m/s], (o,), (N,) [s]."""
        return cls(starts + times[:, None, None] * velocities, radii)

    def joined(self, other: CollisionScene) -> CollisionScene:
        """Return both together."""
        return CollisionScene(
            np.concatenate((self.centers, other.centers), axis=1),
            np.concatenate((self.radii, other.radii)),
        )


class Collisions:
    """The barriers of all pairs of the robot's spheres with the scene and the floor.

    Attributes:
        around: the scene, None without one.
        reach: distances of centres at which the barrier of a pair ends, shape (s, o), m.
        lifted: the spheres that keep off the floor.
        height: of each of these, at which its barrier ends, m.
        active: whether there is anything to keep off.
    """

    def __init__(
        self, config: CollisionConfig, model: StageModel, around: CollisionScene | None
    ) -> None:
        """Take what is in the way; raises InputError for shapes that do not fit."""
        self._config = config
        self._range = config.influence - config.margin if config.influence else np.inf
        self.around = around if around is not None and len(around.radii) else None
        self.reach: Matrix = np.zeros((len(model.radii), 0))
        if self.around is not None:
            _check(self.around, model.stages)
            self.reach = model.radii[:, None] + self.around.radii + config.margin
        self.lifted = np.flatnonzero(model.lifted) if config.ground else np.zeros(0, dtype=np.intp)
        self.height = model.radii[self.lifted] + config.margin
        self.active = len(model.spheres) > 0 and (self.around is not None or self.lifted.size > 0)

    def value(self, at: StageKinematics) -> float:
        """Return the sum of all barriers."""
        total = 0.0
        if self.around is not None:
            total += relaxed_within(self._config, self._room(at)[0], self._range)
        if self.lifted.size:
            total += relaxed_within(
                self._config, at.centers[:, self.lifted, 2] - self.height, self._range
            )
        return total

    def distance(self, at: StageKinematics) -> float:
        """Return the least distance over all stages, without margin [m]; inf without pairs."""
        least = np.inf
        if self.around is not None:
            least = min(least, float(self._room(at)[0].min()))
        if self.lifted.size:
            heights = at.centers[:, self.lifted, 2] - self.height
            least = min(least, float(heights.min()))
        return least + self._config.margin

    def slopes(self, at: StageKinematics) -> tuple[Matrix, Array]:
        """Return gradient (N, n) and Gauss-Newton Hessian (N, n, n) in the q of each state.

        The curvature of the distances is left out: it would make the Hessian indefinite.
        """
        stages, count = at.centers.shape[:2]
        pushes = np.zeros((stages, count, 3))
        stiffness = np.zeros((stages, count, 3, 3))
        if self.around is not None:
            room, apart, distance = self._room(at)
            # In its centre there is no direction: with zero the pair pushes nowhere, but costs.
            away = apart / np.maximum(distance, _CONCENTRIC)[..., None]
            first, second = slopes_within(self._config, room, self._range)
            pushes += (first[:, :, None] @ away)[:, :, 0]
            stiffness += away.transpose(0, 1, 3, 2) @ (second[..., None] * away)
        if self.lifted.size:
            heights = at.centers[:, self.lifted, 2] - self.height
            first, second = slopes_within(self._config, heights, self._range)
            pushes[:, self.lifted, 2] += first
            stiffness[:, self.lifted, 2, 2] += second
        jacobian = at.slopes
        n = jacobian.shape[2]
        gradient = (pushes.reshape(stages, 1, 3 * count) @ jacobian)[:, 0]
        weighted = stiffness @ jacobian.reshape(stages, count, 3, n)
        hessian = jacobian.transpose(0, 2, 1) @ weighted.reshape(stages, 3 * count, n)
        return gradient, hessian

    def _room(self, at: StageKinematics) -> tuple[Array, Array, Array]:
        """Return what is left [m], the ways from things to spheres [m], and their lengths [m].

        Shapes (N, s, o), (N, s, o, 3) and (N, s, o).
        """
        assert self.around is not None
        if self not in at.found:
            apart = at.centers[:, :, None] - self.around.centers[:, None]
            distance = np.sqrt(np.einsum("ksoi,ksoi->kso", apart, apart))
            at.found[self] = distance - self.reach, apart, distance
        found: tuple[Array, Array, Array] = at.found[self]
        return found


def _check(around: CollisionScene, stages: int) -> None:
    """Raise InputError for shapes or values that cannot be."""
    expected = (stages, len(around.radii), 3)
    if around.centers.shape != expected:
        raise InputError(
            f"surroundings: centers of shape {around.centers.shape}, expected {expected}"
        )
    if not (np.isfinite(around.centers).all() and np.all(around.radii > 0.0)):
        raise InputError("surroundings: centers must be finite and radii > 0")
