"""What a sequence is built from: the tasks that the HTMPC executes on one robot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from lexstack.options import Finite, NotEmpty, NotNegative, Positive, Range

_MOST_ROUNDS = 100


@dataclass(frozen=True, slots=True)
class SequenceTaskConfig:
    """One task: where it leads, how fast, and when it is done."""

    name: str  # by which it is released and changed
    # what of the robot it leads
    kind: Literal[
        "ee_position", "ee_pose", "ee_orientation", "base_position", "base_pose", "joint_positions"
    ]
    points: tuple[
        tuple[Finite, ...], ...
    ]  # m, rad, quaternion x y z w; world frame, the last: goal
    speed: NotNegative = 0.0  # m/s along straight lines; 0: the goal is the reference at once
    turn: NotNegative = 0.0  # rad/s at most; 0: no limit
    tolerance: Positive = 0.02  # m, done when its error is smaller
    tolerance_angle: Positive = 0.1  # rad
    dwell: NotNegative = 0.0  # s, for so long
    held: bool = False  # not done before it is released
    frame: str = "tool"  # that an end-effector kind moves: of the robot's tools, or of its URDF
    joints: tuple[
        str, ...
    ] = ()  # of joint_positions, in the order of points; none: all but the base


@dataclass(frozen=True, slots=True)
class SequenceConfig:
    """Tasks of one robot, in their order."""

    robot: str  # its name in the scenario
    # in the order in which they are done
    tasks: Annotated[tuple[SequenceTaskConfig, ...], NotEmpty("at least one is needed")]
    architecture: Literal["ht", "st"] = "ht"  # two tasks at a time, or arm and base apart
    # how often all tasks are done; from the second time on names end with #2, #3 ...
    rounds: Annotated[int, Range(1, _MOST_ROUNDS)] = 1
