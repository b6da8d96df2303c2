"""What tasks on the pose of a frame share: which rows, in whose axes, with which gains.

With the twist Jacobian J of the frame (linear, then angular, axes of the world), its error
e = (p_d - p, R log3(R^T R_d)), the axes E that the task is told in, and S the rows that it keeps,

    A = S diag(E^T, E^T)        A J chi -> A x_dot^d + sat(K_p A e)

``gain`` is K_p: a number, the diagonal, or the whole matrix over the rows that the task may have.
Linear and angular rows of K_p A e are saturated by themselves. E is that of this tick: how it turns
is left out, which is exact where the error is zero. So is how a part of a rotation's error bends
(``hqp.curvature``), of which the whole has no such term.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol, Self

import numpy as np

from lexstack.errors import ConfigurationError, ModelError
from lexstack.options import build
from lexstack.references import TOOL, References
from lexstack.robots import Kinematics, Pose, Team
from lexstack.tasks.feed_forward import feed_forward
from lexstack.tasks.frame_pose import pose_error, saturated
from lexstack.types import Curve, FrameRows, LinearTask, Matrix, Vector

Gain = tuple[tuple[float, ...], ...] | tuple[float, ...] | float
"""K_p [1/s]: all rows of the matrix, its diagonal, or one number."""

WORLD, LOCAL = "world", "local"


@dataclass(frozen=True, slots=True)
class FrameChoice:
    """Which rows of which frame.

    Attributes:
        frame: its name.
        axes: ``world``, ``local`` (the frame's own), or the name of another frame of the robot.
        rows: numbers of the rows that are kept, of the six.
        gain: K_p of the rows that are kept, shape (m, m) or a number, 1/s.
        limits: of the linear and the angular part of K_p e, m/s and rad/s.
    """

    frame: str
    axes: str
    rows: tuple[int, ...]
    gain: Matrix | float
    limits: tuple[float, float]

    @property
    def plain(self) -> bool:
        """Whether its rows are those of the tool's Jacobian as it is."""
        whole = self.rows in ((0, 1, 2), (0, 1, 2, 3, 4, 5))
        return whole and self.frame == TOOL and self.axes == WORLD

    @property
    def largest(self) -> float:
        """The largest gain of a row [1/s], by which errors are told from what is asked for."""
        return float(np.diag(self.gain).max()) if isinstance(self.gain, np.ndarray) else self.gain

    @property
    def parts(self) -> tuple[tuple[slice, float], ...]:
        """The linear and the angular rows among those kept, each with its limit."""
        linear = sum(row < 3 for row in self.rows)
        parts = (slice(0, linear), slice(linear, len(self.rows)))
        return tuple((p, x) for p, x in zip(parts, self.limits, strict=True) if p.stop > p.start)


class FrameParameters(Protocol):
    """Parameters of a task on the pose of a frame."""

    @property
    def choice(self) -> FrameChoice:
        """Which rows of which frame."""
        ...


class FrameTask:
    """Base of the tasks on the pose of a frame.

    Attributes:
        kind: of a task of its own, as stack files name it.
        parameters: the class of its parameters.
        reference: the frame's name among the references.
    """

    kind = ""
    parameters: type[FrameParameters]

    def __init__(self, team: Team, robot: int, choice: FrameChoice, where: str) -> None:
        """Make the task of the robot at place ``robot``; raises for a frame that is not there."""
        self.name = task_name(team, robot, self.kind, choice.frame)
        self.robots = (robot,)
        self._robot = robot
        self._columns = team.slices[robot]
        self._n = team.n
        self._team = team
        self._choice = choice
        self.reference = choice.frame
        self._parts = choice.parts
        check_frame(team, robot, choice.frame, f"{where}: frame")
        if choice.axes not in (WORLD, LOCAL):
            check_frame(team, robot, choice.axes, f"{where}: axes")
        limits = tuple(limit for _, limit in choice.parts)
        sizes = () if choice.plain else tuple(p.stop - p.start for p, _ in choice.parts)
        self._curve = Curve(choice.largest, (robot,), (self._columns,), (1.0,), limits, sizes=sizes)

    @classmethod
    def from_config(cls, team: Team, robot: int, parameters: dict[str, Any], where: str) -> Self:
        """Return the task that a stack file describes; raises ConfigurationError."""
        return cls(team, robot, build(cls.parameters, parameters, where).choice, where)

    def linearise(self, kinematics: Kinematics, references: References) -> LinearTask:
        """Return a row for each that is kept, m/s then rad/s, in the axes of the task.

        Without a target of its frame the task asks for rest.
        """
        choice = self._choice
        pose, jacobian = kinematics.frame(self._robot, choice.frame)
        goal = references.pose(self._robot, self.reference)
        error = np.zeros(6) if goal is None else pose_error(pose, goal)
        feed = references.twist(self._robot, self.reference)
        if feed is not None:
            feed = feed_forward(feed, kinematics, self._team, self._robot, choice.frame)
        matrix = np.zeros((len(choice.rows), self._n))
        if choice.plain:
            m = len(choice.rows)
            matrix[:, self._columns] = jacobian[:m]
            target = asked_of(choice, error[:m])
            return LinearTask.equality(
                self.name, matrix, target, self._curve, None if feed is None else feed[:m]
            )
        axes = axes_of(choice.rows, self._turn(kinematics, pose))
        matrix[:, self._columns] = axes @ jacobian
        target = asked_of(choice, axes @ error)
        feed = None if feed is None else axes @ feed
        rows = FrameRows(axes, jacobian)
        return LinearTask.equality(self.name, matrix, target, self._curve, feed, rows)

    def _turn(self, kinematics: Kinematics, pose: Pose) -> Matrix | None:
        """Return the axes of the task in the world, shape (3, 3); None: they are the world's."""
        axes = self._choice.axes
        if axes == WORLD:
            return None
        return (pose if axes == LOCAL else kinematics.frame(self._robot, axes)[0]).rotation


def asked_of(choice: FrameChoice, error: Vector) -> Vector:
    """Return sat(K_p e) of the rows that are kept, shape (m,)."""
    gain = choice.gain
    asked = gain @ error if isinstance(gain, np.ndarray) else gain * error
    target = np.empty(len(error))
    for part, limit in choice.parts:
        target[part] = saturated(asked[part], limit)
    return target


def axes_of(rows: tuple[int, ...], turn: Matrix | None) -> Matrix:
    """Return A, shape (m, 6): some rows in the axes of a rotation (3, 3), or of the world."""
    if turn is None:
        return np.eye(6)[list(rows)]
    axes = np.zeros((6, 6))
    axes[:3, :3] = axes[3:, 3:] = turn.T
    return axes[list(rows)]


def task_name(team: Team, robot: int, kind: str, frame: str) -> str:
    """Return a task's name: robot, slash, kind, and the frame where it is not the tool."""
    return f"{team.names[robot]}/{kind}" + ("" if frame == TOOL else f"({frame})")


def check_frame(team: Team, robot: int, frame: str, where: str) -> None:
    """Raise ConfigurationError where a robot has no such frame."""
    if frame == TOOL:
        return
    try:
        team.robots[robot].frame(frame)
    except ModelError as error:
        raise ConfigurationError(f"{where}: {error}") from error


def kept_rows(mask: tuple[bool, ...], first: int = 0) -> tuple[int, ...]:
    """Return the numbers of the rows that a mask keeps, counted from ``first``."""
    return tuple(first + k for k, kept in enumerate(mask) if kept)


def check_mask(where: str, mask: tuple[bool, ...]) -> None:
    """Raise ConfigurationError for a mask that keeps nothing."""
    if not any(mask):
        raise ConfigurationError(f"{where}: mask: it leaves no axis")


def check_gain(where: str, gain: Gain, size: int) -> None:
    """Raise ConfigurationError for a gain that is not positive, or of another size."""
    matrix = np.array(gain, dtype=np.float64) if _even(gain) else np.full((1,), np.nan)
    shapes = ((), (size,), (size, size))
    if matrix.shape not in shapes:
        raise ConfigurationError(
            f"{where}: gain: expected a number, {size} numbers, or {size} rows of {size}"
        )
    values = np.linalg.eigvalsh(matrix + matrix.T) if matrix.ndim == 2 else np.atleast_1d(matrix)
    if not np.isfinite(matrix).all() or not (values > 0.0).all():
        shown = f", got {gain}" if matrix.ndim < 2 else ""
        what = "a positive definite matrix" if matrix.ndim == 2 else "finite and > 0"
        raise ConfigurationError(f"{where}: gain: must be {what}{shown}")


def _even(gain: Gain) -> bool:
    """Return whether a gain is a number, numbers, or rows of one length."""
    if not isinstance(gain, tuple) or not gain or not isinstance(gain[0], tuple):
        return True
    return len({len(row) for row in gain if isinstance(row, tuple)}) == 1


def gain_of(gain: Gain, mask: tuple[bool, ...]) -> Matrix | float:
    """Return K_p of the rows that a mask keeps: a matrix, or the number that it is."""
    if not isinstance(gain, tuple):
        return gain
    matrix = np.array(gain, dtype=np.float64)
    kept = np.array(mask)
    return np.asarray((np.diag(matrix) if matrix.ndim == 1 else matrix)[np.ix_(kept, kept)])
