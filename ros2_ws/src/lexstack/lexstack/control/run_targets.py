"""How targets get from the tasks of a program to the references of its run."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from lexstack.references import ReferenceSchedule, Target
from lexstack.robots import Kinematics, Team
from lexstack.tasks.posture import Posture
from lexstack.tasks.specs.compiled import Aim
from lexstack.types import RobotState

Place = tuple[str, int, str]
"""What has one reference at a time: a kind, a robot, and for frames the name of the reference."""


class RunTargets:
    """The targets of the stacks of a run, told to its references when they change.

    A reference begins where its frame, base or posture is when its task comes into the run; the
    target follows one tick later, so that the way to it begins there.
    """

    def __init__(self, team: Team) -> None:
        """Know no stack yet."""
        self._team = team
        self._aims: dict[str, tuple[Aim, ...]] = {}
        self._coming: list[tuple[int, tuple[Aim, ...]]] = []
        # Of each reference: the aim that it follows, and the revision of its target that was given.
        self._given: dict[Place, tuple[Aim, int]] = {}

    def know(self, stack: str, aims: tuple[Aim, ...]) -> None:
        """Take the tasks of a stack."""
        self._aims[stack] = aims

    def also(self, stack: str, like: str) -> None:
        """Let a stack have the tasks of another one."""
        self._aims[stack] = self._aims[like]

    def use(self, stack: str, tick: int) -> None:
        """Follow the targets of a stack from a tick on."""
        self._coming.append((tick, self._aims[stack]))

    def give(
        self,
        references: ReferenceSchedule,
        state: RobotState,
        kinematics: Callable[[RobotState], Kinematics],
    ) -> None:
        """Give the references what is new at a state."""
        due = [aims for tick, aims in self._coming if tick <= state.tick]
        self._coming = [entry for entry in self._coming if entry[0] > state.tick]
        fresh: set[Place] = set()
        for aim in (aim for aims in due for aim in aims):
            place = _place(aim)
            before = self._given.get(place)
            if before is None or before[0].spec is not aim.spec:
                known = before is not None and (not aim.frame)
                self._begin(aim, place, known, references, state, kinematics)
                fresh.add(place)
            else:
                self._given[place] = aim, before[1]
        for place, (aim, revision) in self._given.items():
            if aim.spec.revision != revision and place not in fresh:
                references.add(_target(aim, aim.spec.goal, state.stamp))
                self._given[place] = aim, aim.spec.revision
                if isinstance(aim.task, Posture):
                    aim.task.led = True

    def _begin(
        self,
        aim: Aim,
        place: Place,
        known: bool,
        references: ReferenceSchedule,
        state: RobotState,
        kinematics: Callable[[RobotState], Kinematics],
    ) -> None:
        """Begin a reference where its frame, base or posture is; one that is there goes on."""
        self._given[place] = aim, 0
        if isinstance(aim.task, Posture):
            if aim.spec.revision and not known:
                references.add(_target(aim, aim.task.target, state.stamp))
            return
        if known and aim.spec.revision:
            return
        at: Any
        if aim.frame:
            at = kinematics(state).frame(aim.robot, aim.frame)[0]
        else:
            at = self._team.base_poses(state.q)[aim.robot]
        references.add(_target(aim, at, state.stamp))


def _place(aim: Aim) -> Place:
    """Return which reference a task follows."""
    kind = "frame" if aim.frame else "posture" if isinstance(aim.task, Posture) else "base"
    return kind, aim.robot, aim.reference


def _target(aim: Aim, goal: Any, stamp: float) -> Target:
    """Return a goal as a new reference from a time [s] on."""
    if aim.frame:
        return Target(stamp, aim.robot, ee=goal, frame=aim.reference)
    if isinstance(aim.task, Posture):
        return Target(stamp, aim.robot, posture=goal)
    return Target(stamp, aim.robot, base=goal)
