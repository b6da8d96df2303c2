"""Relative pose of two frames: two tools hold one object, or two arms of one robot keep a pose.

The references of the two frames say where each of them shall be, and so how they shall stand to
each other; or the parameter ``pose`` says it:

    p_r = R_ad^T (p_bd - p_ad)        R_r = R_ad^T R_bd

With frame a where it is, frame b belongs at R_a p_r + p_a, turned by R_a R_r. Its error, in the
world frame, does not depend on where the object is:

    e_p = p_a + R_a p_r - p_b         e_R = R_b log3(R_b^T R_a R_r)

and shrinks by exp(-K_p t) where the frames move as a rigid object would, but for the way back:

    v_b - v_a - w_a x (R_a p_r) = K_p e_p          w_b - w_a = K_p e_R

References that move together, as the ends of one object, leave the task as it is: the object goes
where a task below takes it, e.g. ``ee_pose`` of one of the robots. Mask, axes and gains are those
of ``frame_task``; the axes ``local`` are those of frame a. pink and mink: ``RelativeFrameTask``;
placo: ``RelativeFrameTask``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from lexstack.errors import ConfigurationError
from lexstack.options import Finite, Finite3, Positive, build, shown
from lexstack.references import TOOL, References
from lexstack.robots import Kinematics, Pose, Team
from lexstack.robots.spatial import from_quaternion
from lexstack.tasks.frame_pose import pose_error
from lexstack.tasks.frame_task import (
    LOCAL,
    WORLD,
    FrameChoice,
    Gain,
    asked_of,
    axes_of,
    check_frame,
    check_gain,
    check_mask,
    gain_of,
    kept_rows,
)
from lexstack.types import Curve, FrameRows, LinearTask, Matrix, Vector

_LEAST = 1e-6  # norm of a quaternion


@dataclass(frozen=True, slots=True)
class RelativePlace:
    """Where the other frame shall be in the axes of the first one."""

    xyz: Finite3 = (0.0, 0.0, 0.0)  # m
    quaternion: tuple[Finite, Finite, Finite, Finite] = (0.0, 0.0, 0.0, 1.0)  # x, y, z, w

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for a quaternion that is no rotation."""
        if not float(np.linalg.norm(self.quaternion)) > _LEAST:
            raise ConfigurationError(f"{where}: quaternion: must not be zero")


@dataclass(frozen=True, slots=True)
class RelativePoseParameters:
    """Parameters of the task ``relative_pose``."""

    other: str = ""  # name of the robot of the other frame; empty: the same robot
    frame: str = TOOL  # a, of the robot: a link or joint of its description
    other_frame: str = TOOL  # b, of the other robot
    pose: RelativePlace | None = None  # of b in a; None: as their references are to each other
    axes: str = WORLD  # of error, mask and gain: world, local (those of a), or another frame
    mask: tuple[bool, bool, bool, bool, bool, bool] = (
        True,
        True,
        True,
        True,
        True,
        True,
    )  # x, y, z, then about x, y, z
    gain: Gain = 3.0  # K_p [1/s]: a number, the diagonal, or the rows of the matrix
    max_linear: Positive = 0.5  # m/s, saturation of |K_p e_p|
    max_angular: Positive = 1.0  # rad/s, saturation of |K_p e_R|

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for a value out of range."""
        check_mask(where, self.mask)
        check_gain(where, self.gain, 6)

    @property
    def choice(self) -> FrameChoice:
        """Which rows of the other frame's error."""
        rows, gain = kept_rows(self.mask), gain_of(self.gain, self.mask)
        limits = (self.max_linear, self.max_angular)
        return FrameChoice(self.other_frame, self.axes, rows, gain, limits)


class RelativePose:
    """A (J_b - G J_a) chi -> sat(K_p A e), with G the motion of the object's other end."""

    def __init__(
        self, team: Team, robot: int, parameters: RelativePoseParameters, where: str
    ) -> None:
        """Make the task of two frames; raises ConfigurationError where they are not two."""
        other = _other(team, robot, parameters, where)
        ends = parameters.frame, parameters.other_frame
        check_frame(team, robot, ends[0], f"{where}: frame")
        check_frame(team, other, ends[1], f"{where}: other_frame")
        if parameters.axes not in (WORLD, LOCAL):
            check_frame(team, robot, parameters.axes, f"{where}: axes")
        tools = ends == (TOOL, TOOL)
        self.name = f"{team.names[robot]}/relative_pose" + ("" if tools else f"({', '.join(ends)})")
        self.robots = tuple(dict.fromkeys((robot, other)))
        self._ends = (robot, ends[0]), (other, ends[1])
        self._columns = team.slices[robot], team.slices[other]
        self._n = team.n
        self._axes_frame = parameters.frame if parameters.axes == LOCAL else parameters.axes
        self._choice = choice = parameters.choice
        self._relative = None if parameters.pose is None else _placed(parameters.pose)
        self._plain = tools and choice.plain and len(choice.rows) == 6
        signs = (-1.0, 1.0)[-len(self.robots) :]
        columns = tuple(team.slices[each] for each in self.robots)
        sizes = () if self._plain else tuple(part.stop - part.start for part, _ in choice.parts)
        limits = tuple(limit for _, limit in choice.parts)
        self._curve = Curve(choice.largest, self.robots, columns, signs, limits, sizes=sizes)

    @classmethod
    def from_config(
        cls, team: Team, robot: int, parameters: dict[str, Any], where: str
    ) -> RelativePose:
        """Return the task that a stack file describes; raises ConfigurationError."""
        return cls(team, robot, build(RelativePoseParameters, parameters, where), where)

    def linearise(self, kinematics: Kinematics, references: References) -> LinearTask:
        """Return a row for each that is kept, m/s then rad/s, in the axes of the task.

        Frames without references, and without ``pose``, are asked to stay as they are to each
        other.
        """
        (one, held), (other, free) = (kinematics.frame(*end) for end in self._ends)
        goal, feed = self._goal(one, other, references)
        lever = goal.position - one.position
        error = pose_error(other, goal)
        matrix = np.zeros((len(self._choice.rows), self._n))
        if self._plain:
            matrix[:, self._columns[0]] = -held
            matrix[:3, self._columns[0]] += cross(lever) @ held[3:]
            matrix[:, self._columns[1]] = free
            target = asked_of(self._choice, error)
            return LinearTask.equality(self.name, matrix, target, self._curve, feed)
        turn = None if self._axes_frame == WORLD else self._turn(kinematics)
        axes = axes_of(self._choice.rows, turn)
        end = held.copy()
        end[:3] -= cross(lever) @ held[3:]
        matrix[:, self._columns[0]] -= axes @ end
        matrix[:, self._columns[1]] += axes @ free
        feed = None if feed is None else axes @ feed
        target = asked_of(self._choice, axes @ error)
        rows = FrameRows(axes, free, end)
        return LinearTask.equality(self.name, matrix, target, self._curve, feed, rows)

    def _turn(self, kinematics: Kinematics) -> Matrix:
        """Return the axes of the task in the world, shape (3, 3)."""
        return kinematics.frame(self._ends[0][0], self._axes_frame)[0].rotation

    def _goal(self, one: Pose, other: Pose, references: References) -> tuple[Pose, Vector | None]:
        """Return where frame b belongs, and its velocity on the object, (6,); None: it rests."""
        if self._relative is not None:
            place, turn = self._relative.position, self._relative.rotation
            return Pose(one.position + one.rotation @ place, one.rotation @ turn), None
        first, second = (references.pose(*end) for end in self._ends)
        if first is None or second is None:
            return other, None
        goal = other_end(one, first, second)
        return goal, self._feed(references, one.rotation @ first.rotation.T, (first, second))

    def _feed(
        self, references: References, turn: Matrix, goals: tuple[Pose, Pose]
    ) -> Vector | None:
        """Return the velocity of the other frame's goal on the object, (6,); None: it rests.

        The references' relative motion, turned with the object; moving together is none.
        """
        held, free = (references.twist(*end) for end in self._ends)
        if held is None and free is None:
            return None
        held = np.zeros(6) if held is None else held
        free = np.zeros(6) if free is None else free
        lever = goals[1].position - goals[0].position
        linear = free[:3] - held[:3] - np.cross(held[3:], lever)
        return np.concatenate((turn @ linear, turn @ (free[3:] - held[3:])))


def _other(team: Team, robot: int, parameters: RelativePoseParameters, where: str) -> int:
    """Return the place of the other frame's robot; raises where the two frames are one."""
    try:
        other = team.index(parameters.other) if parameters.other else robot
    except ConfigurationError as error:
        raise ConfigurationError(f"{where}: other: {error}") from error
    if other == robot and parameters.frame == parameters.other_frame:
        raise ConfigurationError(
            f"{where}: other: {shown(team.names[robot])} is the task's own robot: "
            "the task needs another one, or two frames of it"
        )
    return other


def _placed(place: RelativePlace) -> Pose:
    """Return a pose of b in a."""
    return Pose(np.array(place.xyz), from_quaternion(np.array(place.quaternion)))


def other_end(tool: Pose, reference: Pose, other_reference: Pose) -> Pose:
    """Return where the other tool belongs, given where the first one is, world frame.

    Args:
        tool: of the first robot, R_a and p_a.
        reference: of that tool.
        other_reference: of the other robot's tool.
    """
    turn = tool.rotation @ reference.rotation.T
    lever = turn @ (other_reference.position - reference.position)
    return Pose(tool.position + lever, turn @ other_reference.rotation)


def cross(vector: Vector) -> Matrix:
    """Return the matrix of ``vector x``, shape (3, 3)."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
