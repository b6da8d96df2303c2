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

    The reference of a task without a target is where its frame or base is when its stack comes into
    effect: the task holds it there. A target follows one tick later, so that the way to it begins
    there.
    """

    def __init__(self, team: Team) -> None:
        """Know no stack yet."""
        self._team = team
        self._aims: dict[str, tuple[Aim, ...]] = {}
        self._coming: list[tuple[int, tuple[Aim, ...]]] = []
        self._active: tuple[Aim, ...] = ()  # of the stack that came into effect last
        # Of each reference: the aim that it follows, and the revision of its target that was given.
        self._given: dict[Place, tuple[Aim, int]] = {}

    def know(self, stack: str, aims: tuple[Aim, ...]) -> None:
        """Take the tasks of a stack."""
        self._aims[stack] = aims

    def use(self, stack: str, tick: int) -> None:
        """Follow the targets of a stack from a tick on; one that is not known has none."""
        self._coming.append((tick, self._aims.get(stack, ())))

    def give(
        self,
        references: ReferenceSchedule,
        state: RobotState,
        kinematics: Callable[[RobotState], Kinematics],
    ) -> None:
        """Give the references what is new at a state."""
        due = [aims for tick, aims in self._coming if tick <= state.tick]
        self._coming = [entry for entry in self._coming if entry[0] > state.tick]
        for aims in due:
            before = {aim.spec for aim in self._active}
            fresh = [aim for aim in aims if aim.spec not in before]
            begun = [
                target for aim in fresh for target in self._begun(aim, state, kinematics(state))
            ]
            self._active = aims
            _at_once(references, begun, state.stamp)
        for place, (aim, revision) in self._given.items():
            if aim.spec.revision != revision:
                references.add(_target(aim, aim.spec.goal, state.stamp))
                self._given[place] = aim, aim.spec.revision
                if isinstance(aim.task, Posture):
                    aim.task.led = True

    def _begun(self, aim: Aim, state: RobotState, kinematics: Kinematics) -> list[Target]:
        """Return where a reference begins; nothing where it is on its way already."""
        place = _place(aim)
        known, given = self._given.get(place, (None, 0))
        mine = known is not None and known.spec is aim.spec
        self._given[place] = aim, given if mine else 0
        if aim.spec.revision and (mine or (known is not None and known.spec.revision)):
            return []
        if aim.frame:
            return [_target(aim, kinematics.frame(aim.robot, aim.frame)[0], state.stamp)]
        if isinstance(aim.task, Posture):
            return [_target(aim, aim.task.target, state.stamp)] if aim.spec.revision else []
        return [_target(aim, self._team.base_poses(state.q)[aim.robot], state.stamp)]


def _at_once(references: ReferenceSchedule, targets: list[Target], stamp: float) -> None:
    """Let references begin at targets, at this tick and without a way to them."""
    if not targets:
        return
    for target in targets:
        references.add(target)
    lead_in, references.lead_in = references.lead_in, 0.0
    references.decide(stamp)
    references.lead_in = lead_in


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
