"""One goal of the action /htmpc/execute_sequence, from its acceptance to its result."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

import numpy as np
from rclpy.action.server import ServerGoalHandle

from lexstack.errors import InputError
from lexstack.mpc import ARCHITECTURES, SequenceTask, check_tasks
from lexstack.options import shown
from lexstack.robots import Team
from lexstack.transition import too_far
from lexstack.types import RobotState
from lexstack_interfaces.action import ExecuteSequence
from lexstack_interfaces.msg import SequenceStatus
from lexstack_ros.messages.plans import to_tasks

_ROUNDS = 2  # plans until a goal for now begins
_RESTS = 1e-3  # m/s, rad/s: a base that is slower stays where it is


class Stage(Enum):
    """How far a job is."""

    ASKED = 1  # the controller has been asked to follow the plan, its answer is awaited
    WAITING = 2  # for its first tick
    RUNNING = 3  # the MPC plans; the controller follows
    LEAVING = 4  # the controller has been asked to go back; plans go on until it does


@dataclass(frozen=True, slots=True)
class Wanted:
    """A goal that can be: what it asks for, checked.

    Attributes:
        robot: its place in the team.
        tasks: of the sequence.
        architecture: ht or st.
        at_tick: the tick at which the controller begins to follow.
        begin: the tick of the first plan.
    """

    robot: int
    tasks: tuple[SequenceTask, ...]
    architecture: str
    at_tick: int
    begin: int


class Job:
    """A goal under way.

    Attributes:
        robot: its place in the team.
        tasks: of the sequence.
        architecture: ht or st.
        at_tick: the tick at which the controller begins to follow.
        begin: the tick of the first plan.
        origin: the stack that the controller goes back to.
        stage: how far it is.
        followed: whether the controller has been seen following this job's plan.
        result: of the action, once the job has ended.
        on_end: called once, when the result is there.
    """

    def __init__(self, handle: ServerGoalHandle, goal: Wanted) -> None:
        """Keep a goal that was accepted."""
        self.robot, self.tasks, self.architecture = goal.robot, goal.tasks, goal.architecture
        self.at_tick, self.begin = goal.at_tick, goal.begin
        self.origin = ""
        self.stage = Stage.ASKED
        self.followed = False
        self.on_end: Callable[[ServerGoalHandle], None] = lambda _handle: None
        self._handle = handle
        self.result: ExecuteSequence.Result | None = None
        self._done = 0

    @property
    def cancelled(self) -> bool:
        """Whether the client has asked to cancel."""
        return bool(self._handle.is_cancel_requested)

    @property
    def ended(self) -> bool:
        """Whether the client has its result; the robot may still be on its way back."""
        return self.result is not None

    def tell(self, status: SequenceStatus) -> None:
        """Send feedback."""
        self._done = int(status.index)
        if not self.ended:
            self._handle.publish_feedback(ExecuteSequence.Feedback(status=status))

    def end(self, why: str = "") -> None:
        """Send the result: success, or why not; the second call does nothing."""
        if self.ended:
            return
        if not why:
            self._handle.succeed()
        elif self.cancelled:
            self._handle.canceled()
        else:
            self._handle.abort()
        self.result = ExecuteSequence.Result(success=not why, done=self._done, message=why)
        self.on_end(self._handle)


def wanted_of(
    goal: ExecuteSequence.Goal,
    team: Team,
    state: RobotState | None,
    every: int,
    horizon: int = 6000,
) -> Wanted:
    """Return what a goal asks for; raises InputError for one that cannot be.

    Args:
        goal: the message.
        team: the robots.
        state: the newest one.
        every: ticks from plan to plan.
        horizon: so many ticks ahead it may begin.
    """
    if state is None and not goal.at_tick:
        raise InputError("at_tick: must be given, as no state of the plant has come yet")
    if goal.robot not in team.names:
        known = ", ".join(team.names)
        raise InputError(f"robot: unknown {shown(goal.robot)}; known: {known}")
    robot = team.names.index(goal.robot)
    architecture = goal.architecture or "ht"
    if architecture not in ARCHITECTURES:
        known = ", ".join(ARCHITECTURES)
        raise InputError(f"architecture: unknown {shown(architecture)}; known: {known}")
    tasks = to_tasks(goal.tasks, "goal")
    check_tasks(tasks)
    now = -1 if state is None else state.tick
    at_tick = int(goal.at_tick) or (now // every + _ROUNDS) * every
    begin = at_tick - at_tick % every
    if begin <= now:
        raise InputError(f"at_tick: {at_tick} is too early; the present tick is {now}")
    if too_far(at_tick, now, horizon):
        raise InputError(too_far(at_tick, now, horizon))
    return Wanted(robot, tasks, architecture, at_tick, begin)


def base_at(state: RobotState | None, team: Team, robot: int) -> tuple[float, float, float] | None:
    """Return where a robot's base stands [m, m, rad]; None where it moves, or is not known.

    Args:
        state: the newest one.
        team: the robots.
        robot: its place; one without a base stands where it is mounted.
    """
    model, part = team.robots[robot], team.slices[robot]
    if state is None or np.abs(state.command[part][model.base]).max(initial=0.0) > _RESTS:
        return None
    x, y, yaw = map(float, model.base_pose(state.q[team.q_slices[robot]]))
    return x, y, yaw
