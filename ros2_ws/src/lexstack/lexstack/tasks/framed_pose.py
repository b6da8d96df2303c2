"""Pose of any frame of a robot, T(16) to T(20), whole or some of its axes.

The rows, axes and gains are those of ``frame_task``. With the tool, all axes, the world's axes and
one gain it is ``ee_pose``. pink and mink: ``FrameTask``, with costs in place of a mask; placo:
``FrameTask``.
"""

from __future__ import annotations

from dataclasses import dataclass

from lexstack.options import Positive
from lexstack.references import TOOL
from lexstack.tasks.frame_task import (
    WORLD,
    FrameChoice,
    FrameTask,
    Gain,
    check_gain,
    check_mask,
    gain_of,
    kept_rows,
)


@dataclass(frozen=True, slots=True)
class FramePoseParameters:
    """Parameters of the task ``frame_pose``."""

    frame: str = TOOL  # of the robot: a link or joint of its description
    axes: str = WORLD  # of error, mask and gain: world, local, or another frame of the robot
    mask: tuple[bool, bool, bool, bool, bool, bool] = (
        True,
        True,
        True,
        True,
        True,
        True,
    )  # x, y, z, then about x, y, z
    gain: Gain = 3.0  # K_p [1/s]: a number, the diagonal, or the rows of the matrix
    max_linear: Positive = 0.5  # m/s, saturation of |K_p e| of the position
    max_angular: Positive = 1.0  # rad/s, saturation of |K_p e| of the orientation

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for a value out of range."""
        check_mask(where, self.mask)
        check_gain(where, self.gain, 6)

    @property
    def choice(self) -> FrameChoice:
        """Which rows of which frame."""
        rows, gain = kept_rows(self.mask, 0), gain_of(self.gain, self.mask)
        return FrameChoice(self.frame, self.axes, rows, gain, (self.max_linear, self.max_angular))


class FramePose(FrameTask):
    """A J chi -> A x_dot^d + sat(K_p A e), with the measured pose of the frame."""

    kind = "frame_pose"
    parameters = FramePoseParameters
