"""What a task moves, and how its error is measured: e of H(6) and its exact Jacobian by q."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from lexstack.errors import InputError, ModelError
from lexstack.mpc.stage_kinematics import StageKinematics
from lexstack.options import shown
from lexstack.robots import RobotModel
from lexstack.robots.spatial import from_quaternions, log3_all, log_slopes
from lexstack.types import Matrix

Array = NDArray[np.float64]
Kind = Literal[
    "ee_position", "ee_pose", "ee_orientation", "base_position", "base_pose", "joint_positions"
]
"""What a task moves, and in which coordinates; see ``COLUMNS`` and ``Objective``."""

COLUMNS: dict[Kind, int | None] = {
    "ee_position": 3,
    "ee_pose": 7,
    "ee_orientation": 4,
    "base_position": 2,
    "base_pose": 3,
    "joint_positions": None,
}
"""How many coordinates a point of a kind has; None: one per joint."""


class Subject(Protocol):
    """What of a robot is to be somewhere: a task of a sequence, or an objective."""

    @property
    def name(self) -> str:
        """For people."""

    @property
    def kind(self) -> Kind:
        """In which coordinates."""

    @property
    def frame(self) -> str:
        """The frame that an end-effector kind moves."""

    @property
    def joints(self) -> tuple[str, ...]:
        """The joints of ``joint_positions``; empty: all but the base's."""


@dataclass(frozen=True, slots=True, eq=False)
class Measure:
    """How an error is measured: e of shape (N, s), and J = de/dq, (N, s, n_q) or (s, n_q) constant.

    Attributes:
        lengths: 1 for each row that is a length [m], 0 for an angle [rad], shape (s,).
        columns: r, of the reference.
        frame: which the kinematics must have; empty: none.
        kind: of what is measured.
        places: of a base or joints: the coordinates in q that the rows are of.
    """

    lengths: NDArray[np.bool_]
    columns: int
    frame: str
    error: Callable[[StageKinematics, Matrix], Matrix]
    jacobian: Callable[[StageKinematics, Matrix], Array]
    kind: Kind
    places: tuple[int, ...] = ()

    @property
    def rows(self) -> int:
        """The length s of an error."""
        return len(self.lengths)


def measure_of(subject: Subject, robot: RobotModel) -> Measure:
    """Return how the error of a task is measured on a robot.

    Raises:
        InputError: the kind is unknown, or the robot has no such frame, joint or base.
    """
    where = f"task {subject.name}"
    if subject.kind not in COLUMNS:
        raise InputError(f"{where}: kind {subject.kind!r}; known: {', '.join(COLUMNS)}")
    if subject.kind == "joint_positions":
        return _joints(joint_indices(subject, robot), robot)
    if subject.kind.startswith("base"):
        if not robot.has_base:
            raise InputError(f"{where}: kind: {subject.kind}: robot {robot.name} has no base")
        return _BASES[subject.kind](robot.nq)
    try:
        robot.frame(subject.frame)
    except ModelError as error:
        raise InputError(f"{where}: frame: {error}") from error
    return _FRAMES[subject.kind](subject.frame)


def joint_indices(subject: Subject, robot: RobotModel) -> list[int]:
    """Return the places in q of the joints that a task moves, in its order.

    Raises:
        InputError: the robot has no such joint, or it is one of a base, or stands twice.
    """
    names = robot.config.arm.joints
    for i, joint in enumerate(subject.joints):
        if joint not in names:
            known = ", ".join(names)
            raise InputError(
                f"task {subject.name}: joints[{i}]: robot {robot.name} has no joint "
                f"{shown(joint)}; known: {known}"
            )
        if joint in subject.joints[:i]:
            raise InputError(f"task {subject.name}: joints[{i}]: {joint!r} stands twice")
    return [robot.arm_q.start + names.index(joint) for joint in subject.joints or names]


def _position(frame: str) -> Measure:
    """Return p - r, shape (N, 3)."""
    return Measure(
        np.ones(3, dtype=bool),
        3,
        frame,
        lambda at, reference: at.frames[frame].position - reference,
        lambda at, _reference: at.frames[frame].jacobian[:, :3],
        "ee_position",
    )


def _turned(frame: str, at: StageKinematics, quaternions: Matrix) -> Matrix:
    """Return log(R R_d^T), the rotation from the reference to the frame, world axes, (N, 3)."""
    desired = from_quaternions(quaternions)
    return log3_all(at.frames[frame].rotation @ desired.transpose(0, 2, 1))


def _pose(frame: str) -> Measure:
    """Return p - r and the rotation vector from the reference to the frame, shape (N, 6)."""

    def error(at: StageKinematics, reference: Matrix) -> Matrix:
        apart = at.frames[frame].position - reference[:, :3]
        return np.concatenate((apart, _turned(frame, at, reference[:, 3:])), axis=1)

    def jacobian(at: StageKinematics, reference: Matrix) -> Array:
        both = at.frames[frame].jacobian.copy()
        both[:, 3:] = log_slopes(_turned(frame, at, reference[:, 3:])) @ both[:, 3:]
        return both

    return Measure(np.arange(6) < 3, 7, frame, error, jacobian, "ee_pose")


def _orientation(frame: str) -> Measure:
    """Return the rotation vector from the reference to the frame, world axes, shape (N, 3)."""

    def jacobian(at: StageKinematics, reference: Matrix) -> Array:
        turned = _turned(frame, at, reference)
        return np.asarray(log_slopes(turned) @ at.frames[frame].jacobian[:, 3:])

    return Measure(
        np.zeros(3, dtype=bool),
        4,
        frame,
        lambda at, reference: _turned(frame, at, reference),
        jacobian,
        "ee_orientation",
    )


def _base_position(coordinates: int) -> Measure:
    """Return x and y off the reference, shape (N, 2)."""
    jacobian = np.eye(2, coordinates)
    return Measure(
        np.ones(2, dtype=bool),
        2,
        "",
        lambda at, reference: at.q[:, :2] - reference,
        lambda _at, _reference: jacobian,
        "base_position",
        (0, 1),
    )


def _base_pose(coordinates: int) -> Measure:
    """Return x, y and yaw off the reference, yaw in (-pi, pi], shape (N, 3)."""
    jacobian = np.eye(3, coordinates)

    def error(at: StageKinematics, reference: Matrix) -> Matrix:
        off = at.q[:, :3] - reference
        off[:, 2] = np.pi - np.remainder(np.pi - off[:, 2], 2.0 * np.pi)
        return off

    constant = lambda _at, _reference: jacobian  # noqa: E731
    return Measure(np.arange(3) < 2, 3, "", error, constant, "base_pose", (0, 1, 2))


def _joints(places: list[int], robot: RobotModel) -> Measure:
    """Return q - r of some joints; a joint without limits has an unwrapped angle, shape (N, s)."""
    slides = np.array(robot.sliding)[places]
    jacobian = np.eye(robot.nq)[places]
    return Measure(
        slides,
        len(places),
        "",
        lambda at, reference: at.q[:, places] - reference,
        lambda _at, _reference: jacobian,
        "joint_positions",
        tuple(places),
    )


_FRAMES = {"ee_position": _position, "ee_pose": _pose, "ee_orientation": _orientation}
_BASES = {"base_position": _base_position, "base_pose": _base_pose}
