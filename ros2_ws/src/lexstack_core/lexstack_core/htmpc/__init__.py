"""Hierarchical-task MPC (H): values in, a plan out; no clock, no ROS."""

from lexstack_core.htmpc.collisions import Surroundings
from lexstack_core.htmpc.objectives import Objective
from lexstack_core.htmpc.optimiser import Htmpc, Start
from lexstack_core.htmpc.plan import Plan
from lexstack_core.htmpc.present import Present
from lexstack_core.htmpc.sequence import HT_ARCH, ST_ARCH, Architecture, Sequence
from lexstack_core.htmpc.sequence_task import SequenceTask
from lexstack_core.htmpc.status import LevelStatus, Outcome
from lexstack_core.htmpc.trajectory import Trajectory, base_path, ee_path, hold, steps

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
