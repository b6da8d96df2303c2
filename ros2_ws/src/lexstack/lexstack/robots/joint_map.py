"""From the independent joints of a robot to all that move: mimicking joints, and their order."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from lexstack.robots.mimics import Mimic, followed
from lexstack.types import Matrix, Vector


@dataclass(frozen=True, slots=True, eq=False)
class JointMap:
    """q_all = E q + e: positions of all joints of a model, by those of the controlled ones.

    The relation is affine, so E is also that of the velocities: a Jacobian J of the model becomes
    J E, its mass matrix M becomes E^T M E.

    Attributes:
        matrix: E, shape (n_all, n).
        offset: e, shape (n_all,), rad or m.
    """

    matrix: Matrix
    offset: Vector

    def positions(self, q: Vector) -> Vector:
        """Return E q + e, shape (n_all,)."""
        return np.asarray(self.matrix @ q + self.offset)


def joint_map(
    names: Sequence[str], joints: Sequence[str], mimics: Mapping[str, Mimic]
) -> JointMap | None:
    """Return how the joints of a model follow the controlled ones; None: they are the same.

    Args:
        names: of all joints of the model, in its order.
        joints: the controlled ones, in the order of chi.
        mimics: of the others, which all follow a controlled one in the end.
    """
    if tuple(names) == tuple(joints):
        return None
    matrix, offset = np.zeros((len(names), len(joints))), np.zeros(len(names))
    for i, name in enumerate(names):
        primary = Mimic(name, 1.0, 0.0) if name in joints else followed(name, mimics)
        matrix[i, joints.index(primary.joint)] = primary.multiplier
        offset[i] = primary.offset
    matrix.setflags(write=False)
    offset.setflags(write=False)
    return JointMap(matrix, offset)
