"""The chains from the world to the tools, as tables for ``kernel/chain``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from lexstack.robots.kinematics import Pose
from lexstack.robots.robot import RobotModel
from lexstack.types import Matrix, Vector

_AXES = "XYZ"


class Chains:
    """The chains of robots; made where the kernel takes all of their joints, see ``of``."""

    def __init__(self, rows: Sequence[tuple[int, ...]], places: list[Vector], ends: Matrix) -> None:
        """Keep the tables; ``ends`` are of the chains in ``rows``, and their Jacobians' columns."""
        self._tables = (
            np.array(rows, dtype=np.int64).reshape(-1, 4),
            np.array(places),
            np.ascontiguousarray(ends[:, :2]),
        )
        self._columns: list[int] = ends[:, 2].tolist()
        self._same = len(set(self._columns)) == 1

    @classmethod
    def of(cls, robots: Sequence[RobotModel]) -> Chains | None:
        """Return the chains of robots whose q is that of the chains' joints, else None."""
        rows: list[tuple[int, ...]] = []
        places: list[pin.SE3] = []
        ends, start = [], 0
        for robot in robots:
            model = robot.pinocchio
            if robot.map is not None or robot.differential:
                return None
            first = len(rows)
            tool = model.frames[robot.frame("tool")]
            for joint in list(model.supports[tool.parentJoint])[1:]:
                name = model.joints[joint].shortname().removeprefix("JointModel")
                if len(name) != 2 or name[0] not in "RP" or name[1] not in _AXES:
                    return None
                column = model.joints[joint].idx_v
                rows.append((int(name[0] == "P"), _AXES.index(name[1]), start + column, column))
                places.append(model.jointPlacements[joint])
            if len(rows) == first:
                return None
            ends.append((first, len(rows), robot.n))
            start += robot.nq
        places += [robot.pinocchio.frames[robot.frame("tool")].placement for robot in robots]
        numbers = [np.concatenate((place.rotation.ravel(), place.translation)) for place in places]
        return cls(rows, numbers, np.array(ends))

    def tools(self, q: Vector, kernel: Any) -> tuple[tuple[Pose, ...], tuple[Matrix, ...]]:
        """Return the tools' poses and Jacobians, as ``RobotModel.tool`` has them.

        Args:
            q: of all robots.
            kernel: the module ``kernel.chain``.
        """
        count, most = len(self._columns), max(self._columns)
        positions, rotations = np.empty((count, 3)), np.empty((count, 3, 3))
        columns: NDArray[np.float64] = np.zeros((count, most, 6))
        kernel.tools(q, *self._tables, positions, rotations, columns)
        jacobians = tuple(columns.transpose(0, 2, 1))
        if not self._same:
            jacobians = tuple(
                [whole[:, :n] for whole, n in zip(jacobians, self._columns, strict=True)]
            )
        return tuple(map(Pose, positions, rotations)), jacobians
