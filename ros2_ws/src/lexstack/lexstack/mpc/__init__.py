"""Hierarchical-task MPC (H): values in, a plan out; no clock, no ROS."""

from lexstack.mpc.collision_cost import Surroundings
from lexstack.mpc.htmpc import Htmpc, Start
from lexstack.mpc.plan import Plan
from lexstack.mpc.sequence.robot_pose import Present
from lexstack.mpc.sequence.sequence import HT_ARCH, ST_ARCH, Architecture, Sequence
from lexstack.mpc.sequence.task import SequenceTask
from lexstack.mpc.sequence.trajectory import Trajectory, base_path, ee_path, hold, steps
from lexstack.mpc.status import LevelStatus, Outcome
from lexstack.mpc.tracking_objectives import Objective

__all__ = [
    "HT_ARCH",
    "ST_ARCH",
    "Architecture",
    "Htmpc",
    "LevelStatus",
    "Objective",
    "Outcome",
    "Plan",
    "Present",
    "Sequence",
    "SequenceTask",
    "Start",
    "Surroundings",
    "Trajectory",
    "base_path",
    "ee_path",
    "hold",
    "steps",
]
