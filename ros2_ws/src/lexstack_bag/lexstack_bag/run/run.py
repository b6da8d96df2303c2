"""A recorded run as one value: what analysis and replay work on.

T is the number of recorded ticks of a stream, n the length of chi, N the number of robots.
Vectors stack the robots in the configured order; per robot base x [m], y [m], yaw [rad] in the
world frame, then the arm joints [rad]. Times are simulated seconds. All arrays are read-only.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import IntEnum
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from lexstack.mpc import SequenceTask
from lexstack.references import Setting
from lexstack.robots import Team
from lexstack.transition import Phase as TransitionPhase
from lexstack.types import Matrix, PlantStatus, Vector
from lexstack_config.parts import build_team
from lexstack_config.resolved import ResolvedScenario

__all__ = [
    "ChiStream", "Integers", "Names", "PlanStream", "PlanTopics", "PlantStatus", "PlantStream",
    "ProgressStream", "Ragged", "Run", "RunPart", "SequenceEvent", "Single", "SolveStatus",
    "StackRequested", "Strings", "Target", "TransitionPhase", "TransitionStream", "read_only",
]  # fmt: skip

Integers = NDArray[np.int64]
Strings = NDArray[Any]  # of str, equal texts are one object
Names = NDArray[Any]  # of str: several names, with a space between them
Single = NDArray[np.float32]  # to look at: nothing is computed anew from it
Ragged = NDArray[np.float64]  # rows of different lengths: nan at their ends


POSITIONS = ("q", "q_star")
"""The fields of ``PlantStream`` that are positions, of length nq; the others are as chi."""


class SolveStatus(IntEnum):
    """``status`` of ``Chi``."""

    SOLVED = 0
    FALLBACK = 1
    FAILED = 2


@dataclass(frozen=True, slots=True)
class PlantStream:
    """``/plant/state``, one row per tick, ticks ascending."""

    tick: Integers  # (T,)
    stamp: Vector  # (T,) s
    q: Matrix  # (T, nq) measured
    v: Matrix  # (T, n) measured
    q_star: Matrix  # (T, nq) integral of the commands
    command: Matrix  # (T, n) the chi that was accepted last
    status: Integers  # (T,) of PlantStatus
    late_ticks: Integers  # (T,) so far
    missing_ticks: Integers  # (T,) so far


@dataclass(frozen=True, slots=True)
class ChiStream:
    """``/robot_a/chi`` or ``/robot_b/chi``, one row per tick, ticks ascending.

    Rows of numbers that were empty are nan, and so are the joints of robots that a message is not
    about.
    """

    tick: Integers  # (T,)
    stamp: Vector  # (T,) s
    stack: Strings  # (T,) the stack that was solved
    transition_id: Integers  # (T,)
    chi: Matrix  # (T, n) m/s, rad/s
    lower: Single  # (T, n) bounds on chi
    upper: Single  # (T, n)
    slacks: Ragged  # (T, L) residual of each level, L the most levels that were solved
    status: Integers  # (T,) of SolveStatus
    empty_bounds: Integers  # (T,) joints with an empty box at the tick
    solve_time: Vector  # (T,) s, wall clock
    reason: Strings  # (T,)
    # ns since 1970, by the sender's clock; empty: not known
    sent: Integers = field(default_factory=lambda: read_only(np.zeros(0, np.int64)))  # (T,)
    # revision of the references that each row was solved for; 0: not known
    references: Integers = field(default_factory=lambda: read_only(np.zeros(0, np.int64)))  # (T,)
    # names of the robots that each row is about, with a space between
    robots: Names = field(default_factory=lambda: read_only(np.zeros(0, np.str_)))  # (T,)


@dataclass(frozen=True, slots=True)
class TransitionStream:
    """``/robot_a/transition``, one row per message in the order of their arrival."""

    tick: Integers  # (T,)
    stamp: Vector  # (T,) s
    id: Integers  # (T,)
    from_stack: Strings  # (T,)
    to_stack: Strings  # (T,)
    source: Strings  # (T,)
    method: Strings  # (T,)
    phase: Integers  # (T,) of TransitionPhase
    alpha: Vector  # (T,)
    duration: Vector  # (T,) s
    gap: Vector  # (T,) m/s and rad/s, nan without a source
    reason: Strings  # (T,)
    # names of the robots that each row is about, with a space between; empty: all
    robots: Names = field(default_factory=lambda: read_only(np.zeros(0, np.str_)))  # (T,)


@dataclass(frozen=True, slots=True)
class Target:
    """One reference pose that somebody published."""

    robot: str
    kind: Literal["ee", "base"]
    time: float  # s, simulated, from which it holds
    position: Vector  # (3,) m, world
    quaternion: Vector  # (4,) x, y, z, w
    arrived: int = 0  # ns since 1970, by the recorder's clock; 0: not known


@dataclass(frozen=True, slots=True)
class StackRequested:
    """One ``/robot_a/stack_request``: what the controller told its source that it shall solve."""

    after: int  # tick of the command that the controller had sent last; -1: none
    id: int  # of the transition
    stack: str
    start_tick: int
    active: bool  # False: no longer to be solved
    robots: tuple[str, ...] = ()  # names of those that shall go there; empty: all that it moves
    text: str = ""  # YAML of the stack, where a user sent it


@dataclass(frozen=True, slots=True)
class PlanStream:
    """``/htmpc/plan`` of one robot of n joints, one row per plan in the order of sending.

    A plan has m states; it is told by its velocities, as its accelerations follow from them.
    """

    tick: Integers  # (T,) of the state that it starts from
    stamp: Vector  # (T,) s
    times: Ragged  # (T, m) s after the stamp
    velocity: Matrix  # (T, m n) the states' velocities one after another, m/s and rad/s
    sent: Integers  # (T,) ns since 1970, by the sender's clock


@dataclass(frozen=True, slots=True)
class ProgressStream:
    """``/htmpc/status`` of one robot, one row per plan."""

    tick: Integers  # (T,)
    stamp: Vector  # (T,) s
    architecture: Strings  # (T,) ht or st
    index: Integers  # (T,) place of the first task that is not done
    count: Integers  # (T,) of all tasks
    task: Strings  # (T,) name of the first task that is not done
    error: Vector  # (T,) m, from its goal
    error_angle: Vector  # (T,) rad
    errors: Ragged  # (T, L) m, of each level from its reference
    solved: Integers  # (T,) whether no level failed
    solve_time: Vector  # (T,) s, wall clock


@dataclass(frozen=True, slots=True)
class SequenceEvent:
    """One ``/htmpc/sequence``: what became of a robot's sequence at a state of the plant."""

    sent: int  # ns since 1970, by the sender's clock
    tick: int  # of the state
    architecture: str  # ht or st
    event: str  # begin, replace, release, retarget, insert, cancel, end
    changed: str  # name of the task that a change is about
    tasks: tuple[SequenceTask, ...]  # after it; empty: there is none any more


@dataclass(frozen=True, slots=True)
class PlanTopics:
    """What the HTMPC did for one robot."""

    plans: PlanStream
    progress: ProgressStream
    events: tuple[SequenceEvent, ...]  # in the order of sending


@dataclass(frozen=True, slots=True)
class RunPart:
    """One part of a bag: a reset of the plant ends it and begins the next one."""

    states: int  # of the plant, in the bag
    start_s: float  # simulated, of its first state
    end_s: float  # simulated, of its last state


@dataclass(frozen=True, slots=True)
class Run:
    """Everything that analysis takes from a bag; of a bag with resets from one of its parts."""

    path: Path  # of the first .mcap file
    provenance: dict[str, str]  # the Metadata record `lexstack`: versions, mode, seed
    resolved: ResolvedScenario  # with the stacks that users sent meanwhile
    plant: PlantStream
    chi: dict[str, ChiStream]  # by robot
    transition: TransitionStream
    targets: tuple[Target, ...]  # in the order of their arrival
    messages: dict[str, int]  # count by topic
    lost: int  # messages that the recorder missed
    complete: bool  # False: the file ends before its end
    requested: tuple[StackRequested, ...] = ()  # in the order in which they were sent
    # as ``chi``, in the order of arrival: what another message of the same tick followed
    replaced: dict[str, ChiStream] = field(default_factory=dict)
    plan_topics: dict[str, PlanTopics] = field(
        default_factory=dict
    )  # by robot, of those with plans
    settings: tuple[
        Setting, ...
    ] = ()  # the controller's decisions on references; older bags have none
    part: int = 1  # which one of ``parts`` this is, from 1
    parts: tuple[RunPart, ...] = ()  # of the whole bag; none: there was no reset

    @property
    def period(self) -> float:
        """The length of a tick [s]."""
        return 1.0 / self.resolved.scenario.rate

    @property
    def robots(self) -> tuple[str, ...]:
        """The robots' names in the order of chi."""
        return tuple(self.resolved.scenario.robots)

    def team(self) -> Team:
        """Return the robots' models."""
        return build_team(self.resolved)


def read_only(array: NDArray[Any]) -> NDArray[Any]:
    """Return the array, made read-only."""
    array.setflags(write=False)
    return array
