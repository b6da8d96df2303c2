"""A picture of the run from the newest messages: what anybody may hear."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from typing import TypeVar

import numpy as np
from trajectory_msgs.msg import JointTrajectory

from lexstack.errors import InputError
from lexstack.references import Frame, References
from lexstack.robots import Pose, Team
from lexstack.transition import Phase
from lexstack.types import Matrix, PlantStatus, Vector
from lexstack_interfaces.msg import Chi, PlantState, SequenceStatus, TransitionStatus
from lexstack_ros.messages.conversions import to_seconds, to_vector
from lexstack_ros.messages.plans import PLAN, robot_of
from lexstack_ros.view.picture import Picture

COMMANDER, SOURCE = "robot_a", "robot_b"  # the controllers, whatever the robots are called
_OLD = 10  # ticks
E = TypeVar("E", bound=IntEnum)
_MOST_STAGES = 1000


@dataclass(frozen=True, slots=True)
class Heard:
    """The newest messages.

    Attributes:
        state: of the plant.
        statuses: of the transitions at one tick; they are about different robots.
        chi: of each controller that has sent one, the controller first: the command.
        horizons: as in ``Picture``.
        progress: of the sequences under way.
        frames: further ones that tasks of the stacks in effect move.
    """

    state: PlantState
    statuses: Sequence[TransitionStatus] = ()
    chi: Mapping[str, Chi] = field(default_factory=dict)
    horizons: Mapping[int, Matrix] = field(default_factory=dict)
    progress: Sequence[SequenceStatus] = ()
    frames: Collection[Frame] = ()


def picture_of(team: Team, heard: Heard, references: References, goals: References) -> Picture:
    """Return what the page shows of messages, references in effect, and where these lead.

    Raises:
        InputError: a message is not one about this team, or says what no message can say.
    """
    state, statuses, chi = heard.state, heard.statuses, heard.chi
    time = to_seconds(state.header.stamp)
    command = chi.get(COMMANDER)
    busy = [status for status in statuses if status.phase != TransitionStatus.IDLE]
    status = (busy or [*statuses, TransitionStatus()])[0]
    q = to_vector(state.q, team.nq, "/plant/state: q")
    return Picture(
        time,
        int(state.tick),
        q,
        _word(PlantStatus, state.status, "/plant/state: status"),
        "; ".join(_stack(team, status) for status in statuses),
        _word(Phase, status.phase, "/robot_a/transition: phase").name.lower(),
        _finite(status.alpha),
        status.source,
        status.reason,
        () if command is None else tuple(_finite(slack) for slack in command.slacks),
        {name: _solve_time(one, state) for name, one in chi.items()},
        references,
        goals,
        team.obstacles.at(time),
        heard.horizons,
        {frame: _goal_of(team, q, frame, goals) for frame in heard.frames},
        tuple(map(_work, heard.progress)),
    )


def horizon_of(message: JointTrajectory, team: Team) -> tuple[int, Matrix]:
    """Return whose plan a message is, and where the tool goes by it, shape (m, 3), m, world.

    Raises:
        InputError: it is none of this team.
    """
    robot = robot_of(message.joint_names, team)
    model = team.robots[robot]
    points = [
        model.tool(to_vector(point.positions, model.nq, f"{PLAN}: points[{k}].positions"))[0]
        for k, point in enumerate(message.points[:_MOST_STAGES])
    ]
    return robot, np.array([pose.position for pose in points]).reshape(-1, 3)


def _goal_of(team: Team, q: Vector, frame: Frame, goals: References) -> Pose:
    """Return where the reference of a frame leads, or where the frame is if it has none."""
    robot, name = frame
    goal = goals.pose(robot, name)
    if goal is not None:
        return goal
    model = team.robots[robot]
    return model.at(q[team.q_slices[robot]], model.frame(name))[0]


def _stack(team: Team, status: TransitionStatus) -> str:
    """Return which stack is in effect, which one comes, and of whom if not of all."""
    names = list(status.robots)
    whose = f" ({', '.join(names)})" if set(names) not in (set(), set(team.names)) else ""
    if status.phase == TransitionStatus.BLENDING:
        return f"{status.from_stack} → {status.to_stack}{whose}"
    if status.phase in (TransitionStatus.REQUESTED, TransitionStatus.PREPARING):
        return f"{status.from_stack}, then {status.to_stack}{whose}"
    return f"{status.to_stack}{whose}"


def _work(message: SequenceStatus) -> str:
    """Return what the MPC works on for one robot."""
    if message.index >= message.count:
        return f"{message.robot}: all {message.count} tasks are done"
    return (
        f"{message.robot}: task {message.index + 1} of {message.count}: {message.task}, "
        f"{1e3 * _finite(message.error):.0f} mm away, {1e3 * _finite(message.solve_time):.0f} ms"
    )


def _solve_time(chi: Chi, state: PlantState) -> float:
    """Return a solve time [ms]; nan where the solution is old: nothing was solved since."""
    return 1e3 * _finite(chi.solve_time) if chi.tick + _OLD >= state.tick else math.nan


def _word(kind: type[E], value: int, where: str) -> E:
    """Return a number as what it stands for; raises InputError."""
    try:
        return kind(value)
    except ValueError as error:
        raise InputError(f"{where}: {error}") from error


def _finite(value: float) -> float:
    """Return a number that a plot can hold."""
    return float(value) if math.isfinite(value) else 0.0
