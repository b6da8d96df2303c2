"""Which goals a robot can get to at all: kinematics and joint limits, floor and resting obstacles.

A task whose goal is out of reach is never done, and the tasks behind it never begin. So a sequence
is checked before it is taken. What is refused here cannot be met; what passes may still fail, as
nothing here plans a way.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from lexstack.errors import InputError
from lexstack.mpc.measures import joint_indices
from lexstack.mpc.sequence.reach_search import FrameGoal, Place, ReachSearch
from lexstack.mpc.sequence.task import SequenceTask
from lexstack.robots import Obstacles, Pose, RobotModel
from lexstack.robots.assembly import TOOL
from lexstack.robots.spatial import from_quaternions
from lexstack.types import Vector

# A goal is refused only if the least error found exceeds the tolerance by this much: at the border
# of the reach the search converges slowly.
_SLACK = 1e-3  # m, rad
_PLACED, _BOTH, _TURNED = slice(0, 3), slice(0, 6), slice(3, 6)  # of position above rotation


class Reach:
    """The goals of tasks that one robot can meet."""

    def __init__(self, robot: RobotModel, obstacles: Obstacles) -> None:
        """Take a robot and what is in its way."""
        self._robot, self._platform = robot, robot.config.base
        still = obstacles.resting
        self._centers, self._radii = obstacles.at(0.0)[still], obstacles.radii[still]
        self._search = ReachSearch(robot)

    def check(
        self, tasks: Iterable[SequenceTask], architecture: str, base: Place | None = None
    ) -> None:
        """Raise InputError for the first task of a sequence whose goal cannot be met.

        A frame, joint or base that the robot has not is refused as well.

        Args:
            tasks: in their order.
            architecture: ``ht``: the whole robot serves every task; ``st``: the arm alone serves
                the tasks of the tool, from where the base tasks before have brought the base.
            base: where the base stands at the start; None: not known.
        """
        stands = base
        for task in tasks:
            apart = architecture == "st"
            task.check(self._robot)
            why = self._unmet(task, stands if apart else None)
            if why:
                raise InputError(f"task {task.name!r}: points[{len(task.points) - 1}]: {why}")
            if task.kind == "base_pose":
                x, y, yaw = task.points[-1]
                stands = (x, y, yaw)
            elif task.kind == "base_position" and stands is not None:
                x, y = task.points[-1]
                stands = (x, y, stands[2])  # the yaw is nobody's task: it stays

    def _unmet(self, task: SequenceTask, base: Place | None) -> str:
        """Return why the goal of a task cannot be met, or ''; ``base``: where it must stay."""
        goal = np.array(task.points[-1])
        if task.kind.startswith("base"):
            return self._occupied(goal[:2])
        if task.kind == "joint_positions":
            return self._outside(task, goal)
        if task.kind == "ee_orientation":
            return self._missed(task, np.concatenate((np.zeros(3), goal)), None, _TURNED)
        taken = self._taken(task, goal[:3])
        if taken or task.kind == "ee_position":
            return taken or self._missed(task, goal, base, _PLACED)
        # From one place of the base six equations stand against six or seven joints, and the
        # search may miss the way there. What it finds for the place of the frame alone, and for
        # the pose with a free base, is sure; both must be met.
        place = "" if base is None else self._missed(task, goal, base, _PLACED)
        return place or self._missed(task, goal, None, _BOTH)

    def _taken(self, task: SequenceTask, place: Vector) -> str:
        """Return what is where a frame is to be (3,) [m], or ''."""
        if place[2] < -task.tolerance and self._platform is not None:
            return f"it is {-place[2]:.2f} m below the floor"
        for center, radius in zip(self._centers, self._radii, strict=True):
            if np.linalg.norm(place - center) + task.tolerance < radius:
                return "it is inside an obstacle"
        return ""

    def _outside(self, task: SequenceTask, goal: Vector) -> str:
        """Return which joint's goal is beyond its limits by more than the tolerance, or ''."""
        places = joint_indices(task, self._robot)
        for place, value in zip(places, goal, strict=True):
            slides = self._robot.sliding[place]
            allowed = task.tolerance if slides else task.tolerance_angle
            lower, upper = self._search.lower[place], self._search.upper[place]
            if not lower - allowed < value < upper + allowed:
                name = self._robot.coordinates[place]
                return f"{name}: {value:g} is outside its limits [{lower:g}, {upper:g}]"
        return ""

    def _missed(self, task: SequenceTask, goal: Vector, base: Place | None, rows: slice) -> str:
        """Return by how much the frame misses a goal (3,) or (7,), its ``rows`` of six; or ''."""
        turned = from_quaternions(goal[None, 3:])[0] if rows.stop == 6 else np.eye(3)
        allowed = (task.tolerance + _SLACK, task.tolerance_angle + _SLACK)
        frame = self._robot.frame(task.frame)
        target = FrameGoal(frame, Pose(goal[:3], turned), rows)
        distance, angle = self._search.least(target, allowed, base)
        if distance < allowed[0] and angle < allowed[1]:
            return ""
        from_here = "" if base is None else f" with the base at ({base[0]:.2f}, {base[1]:.2f}) m"
        parts = [f"{distance:.3f} m"] * (rows.start == 0) + [f"{angle:.2f} rad"] * (rows.stop == 6)
        what = "the tool" if task.frame == TOOL else task.frame
        return f"out of reach: {what} comes to {' and '.join(parts)} of it at best{from_here}"

    def _occupied(self, place: Vector) -> str:
        """Return why a base cannot stand at x, y [m], shape (2,), whatever its yaw; or ''."""
        base = self._platform
        assert base is not None  # SequenceTask.check has refused tasks of a base that is not there
        inside = min(base.chassis_size[:2]) / 2.0  # a disc that the chassis covers at any yaw
        half = base.chassis_size[2] / 2.0
        for center, radius in zip(self._centers, self._radii, strict=True):
            above = max(abs(center[2] - base.chassis_height) - half, 0.0)
            if above >= radius:
                continue
            wide = np.sqrt(radius**2 - above**2)  # of the obstacle, at the chassis' height
            if np.linalg.norm(place - center[:2]) < wide + inside:
                return "an obstacle stands there"
        return ""
