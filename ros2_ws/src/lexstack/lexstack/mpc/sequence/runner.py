"""One robot's sequence under way: measured states in, plans out; what a node calls at its rate."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Literal

import numpy as np

from lexstack.errors import InputError
from lexstack.mpc.collision_cost import CollisionScene
from lexstack.mpc.htmpc import Htmpc, Start
from lexstack.mpc.options import HtmpcConfig
from lexstack.mpc.other_robots import OtherRobot
from lexstack.mpc.plan import Plan
from lexstack.mpc.sequence.options import SequenceConfig
from lexstack.mpc.sequence.robot_pose import RobotPose
from lexstack.mpc.sequence.sequence import HT_ARCH, ST_ARCH, Architecture, Sequence
from lexstack.mpc.sequence.task import Point, SequenceTask
from lexstack.robots import Team
from lexstack.types import RobotState, Vector

_ROUNDING = 1e-9  # s
_NO_PLANS: Mapping[int, Plan] = MappingProxyType({})

ARCHITECTURES: dict[str, Architecture] = {"ht": HT_ARCH, "st": ST_ARCH}
"""By the names that goals and files use."""


@dataclass(frozen=True, slots=True)
class Change:
    """A change of a sequence under way.

    Attributes:
        kind: what is done.
        name: of the task that it is about.
        points: for retarget: where that leads now.
        task: for insert: the task itself.
        before: for insert: name of the task that it comes before; empty: at the end.
    """

    kind: Literal["release", "retarget", "insert", "cancel"]
    name: str
    points: tuple[Point, ...] = ()
    task: SequenceTask | None = None
    before: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Progress:
    """Where a sequence stands after a solve.

    Attributes:
        sequence: after this state.
        plan: from this state on.
        errors: distance [m] and angle [rad] from the goal of the first task that is not done.
        tracking: distance of each task in the window from its reference now [m].
    """

    sequence: Sequence
    plan: Plan
    errors: tuple[float, float]
    tracking: tuple[float, ...]


class SequenceRunner:
    """Executes sequences on one robot of a team, one at a time.

    Attributes:
        robot: its place in the team.
        sequence: under way, or None.
        plan: the newest one, if it was solved: what other robots must keep off, and the first
            guess of the next one.
    """

    def __init__(self, team: Team, robot: int, config: HtmpcConfig, blend: float = 0.0) -> None:
        """Generate the optimiser's code, which takes a moment; raises ModelError.

        Args:
            team: the robots.
            robot: its place.
            config: parameters of the MPC.
            blend: from a sequence's begin, how long the controller takes until it follows exactly
                [s].
        """
        self.robot = robot
        self.sequence: Sequence | None = None
        self._team = team
        self._model = team.robots[robot]
        self._columns, self._place = team.slices[robot], team.q_slices[robot]
        self._others = [i for i in range(len(team.robots)) if i != robot]
        self._optimiser = Htmpc(self._model, config)
        self.plan: Plan | None = None
        self._blend = blend
        self._follows = 0.0  # s, the time from which on the controller follows exactly

    def pose(self, state: RobotState) -> RobotPose:
        """Return where the robot is."""
        return RobotPose.of(self._model, state.stamp, state.q[self._place])

    def begin(
        self, tasks: tuple[SequenceTask, ...], architecture: Architecture, state: RobotState
    ) -> None:
        """Begin a sequence at a state, in place of another one; raises InputError."""
        for task in tasks:
            task.check(self._model)
        sequence = Sequence.begin(tasks, architecture, self.pose(state))
        self._optimiser.prepare(sequence.windows)
        self.sequence = sequence
        self._follows = state.stamp + self._blend

    def task(self, name: str) -> SequenceTask:
        """Return a task of the sequence; raises InputError for an unknown one."""
        known = () if self.sequence is None else self.sequence.tasks
        for task in known:
            if task.name == name:
                return task
        names = ", ".join(task.name for task in known) or "none"
        raise InputError(f"sequence: unknown task {name!r}; known: {names}")

    def task_after(self, change: Change) -> SequenceTask | None:
        """Return the task with a new goal after a change, or None where no goal is new.

        Raises:
            InputError: the task is unknown, or cannot be as it would be.
        """
        if change.kind == "retarget":
            return replace(self.task(change.name), points=change.points)
        return change.task if change.kind == "insert" else None

    def change(self, change: Change, state: RobotState) -> None:
        """Change the sequence at a state; raises InputError, and then nothing has changed."""
        sequence, pose = self.sequence, self.pose(state)
        if sequence is None:
            raise InputError("sequence: none is under way")
        task = self.task_after(change)
        if task is not None:
            task.check(self._model)
        if change.kind == "release":
            self.sequence = sequence.release(change.name)
        elif change.kind == "cancel":
            self.sequence = sequence.cancel(change.name, pose)
        elif change.kind == "retarget":
            self.sequence = sequence.retarget(change.name, change.points, pose)
        elif change.task is not None:
            grown = sequence.insert(_place(sequence, change.before), change.task, pose)
            self._optimiser.prepare(grown.windows)
            self.sequence = grown

    def end(self) -> None:
        """Forget sequence and plan."""
        self.sequence = None
        self.plan = None

    def step(self, state: RobotState, plans: Mapping[int, Plan] = _NO_PLANS) -> Progress:
        """Return plan and progress at a state.

        Args:
            state: measured.
            plans: that robots follow, by their places; one's own does not count. With
                ``predict_others`` they are avoided along these plans, and robots without one as if
                they braked now; otherwise where they stand.

        Poses are the measured ones. The velocity is the command in force, which the controller
        changes within its limits from tick to tick: the plan goes on from there. While the
        controller still blends into the plan, its command is off it by a gap that fades; a plan
        that began there would add the gap once more each time. So until then the plan before goes
        on.

        Raises:
            InputError: no sequence is under way.
        """
        if self.sequence is None:
            raise InputError("sequence: none is under way")
        pose = self.pose(state)
        sequence = self.sequence = self.sequence.advanced(pose)
        times = state.stamp + self._optimiser.horizon.times[1:]
        start = Start(state.stamp, state.q[self._place], self._velocity(state))
        plan = self._optimiser.solve(
            start,
            sequence.objectives(times),
            self.plan,
            self._collision_scene(state, times),
            self._predicted(state, plans),
        )
        self.plan = plan if plan.solved else None
        now = np.array([state.stamp])
        tracking = tuple(
            pose.errors(task, trajectory.at(now)[0])[0]
            for task, trajectory in zip(sequence.window, sequence.trajectories, strict=True)
        )
        return Progress(sequence, plan, sequence.errors(pose), tracking)

    def _velocity(self, state: RobotState) -> Vector:
        """Return the velocity that a plan begins with, shape (n of the robot,)."""
        before = self.plan
        if before is None or not state.stamp < min(self._follows - _ROUNDING, before.end):
            return state.command[self._columns]
        return before.sample(state.stamp)[1]

    def _collision_scene(self, state: RobotState, times: Vector) -> CollisionScene | None:
        """Return obstacles where they will be, and other robots where they stand.

        The latter only where they are not predicted.
        """
        obstacles = self._team.obstacles
        frozen = bool(self._others) and not self._optimiser.config.predict_others
        spheres = self._team.spheres(state.q) if frozen else None
        theirs = np.zeros(0, dtype=bool) if spheres is None else spheres.owners != self.robot
        if not len(obstacles) and not theirs.any():
            return None
        centers = np.array([obstacles.at(float(time)) for time in times])
        found = CollisionScene(centers.reshape(len(times), -1, 3), obstacles.radii)
        if spheres is None or not theirs.any():
            return found
        still = np.broadcast_to(spheres.centers[theirs], (len(times), int(theirs.sum()), 3))
        return found.joined(CollisionScene(still, spheres.radii[theirs]))

    def _predicted(self, state: RobotState, plans: Mapping[int, Plan]) -> list[OtherRobot]:
        """Return the other robots that are avoided where they will be."""
        if not self._optimiser.config.predict_others:
            return []
        team = self._team
        return [
            OtherRobot(
                team.robots[i],
                state.q[team.q_slices[i]],
                state.command[team.slices[i]],
                plans.get(i),
            )
            for i in self._others
        ]


def plans_of(runners: Mapping[int, SequenceRunner]) -> dict[int, Plan]:
    """Return the plans that robots follow now, by their places in the team."""
    return {robot: one.plan for robot, one in runners.items() if one.plan is not None}


def tasks_of(config: SequenceConfig) -> tuple[SequenceTask, ...]:
    """Return a configured sequence's tasks, all rounds; raises InputError for a wrong one."""
    once = tuple(
        SequenceTask(
            task.name,
            task.kind,
            task.points,
            task.speed or None,
            task.turn or None,
            task.tolerance,
            task.tolerance_angle,
            task.dwell,
            task.held,
            task.frame,
            task.joints,
        )
        for task in config.tasks
    )
    again = (
        replace(task, name=f"{task.name}#{round_}")
        for round_ in range(2, config.rounds + 1)
        for task in once
    )
    return (*once, *again)


def _place(sequence: Sequence, before: str) -> int:
    """Return where to insert; raises InputError for an unknown name."""
    if not before:
        return len(sequence.tasks)
    names = [task.name for task in sequence.tasks]
    if before not in names:
        raise InputError(f"sequence: unknown task {before!r}; known: {', '.join(names)}")
    return names.index(before)
