"""The state of a transition, and what its source has to solve for it."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, IntEnum

from lexstack.types import Vector


class Phase(IntEnum):
    """``phase`` of ``TransitionStatus``, in their order; ABORTED may follow any of them."""

    IDLE = 0
    REQUESTED = 1
    PREPARING = 2
    BLENDING = 3
    ADOPTING = 4
    ABORTED = 5


class Source(Enum):
    """Whose chi the controller follows; the values stand in messages."""

    NONE = ""
    SOLVER = "robot_b"
    HTMPC = "htmpc"
    LOCAL = "local"  # the controller solves the new stack itself
    MINIMUM_VELOCITY = "minimum_velocity"

    @property
    def called(self) -> str:
        """What it is called in sentences."""
        names = {Source.SOLVER: "the solver", Source.HTMPC: "the MPC"}
        return names.get(self, self.value)


@dataclass(frozen=True, slots=True)
class TransitionState:
    """The state of a transition at one tick, as the controller reports it.

    Attributes:
        id: of the transition, 0 before the first.
        from_stack: the stack that the robots come from.
        to_stack: the stack to go to; when idle: the stack in effect.
        source: whose chi the controller follows.
        method: of the transition, empty when idle.
        phase: where it stands.
        alpha: 0 at the trigger, 1 at the end.
        duration: of the blend [s].
        gap: largest |chi - chi_source| over the joints, m/s or rad/s.
        reason: why it is so, where it is not as asked; stays until the next transition.
        robots: names of the robots that it is about.
    """

    id: int
    from_stack: str
    to_stack: str
    source: Source
    method: str
    phase: Phase
    alpha: float
    duration: float
    gap: float
    reason: str
    robots: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class SourceSample:
    """A source's optimum for one tick.

    Attributes:
        transition_id: the request that it answers.
        tick: the tick whose state it was solved for.
        chi: shape (n,), finite.
        solved: whether every level was solved.
        slack: the norm of level 1's residual at chi, as the source reports it; None: not reported.
        robots: places in the team of those that it was solved for, the others' joints are 0; None:
            all that the stack moves.
        stack: that was solved, where only some robots were.
        revision: of the references that it was solved with; None: not known.
    """

    transition_id: int
    tick: int
    chi: Vector
    solved: bool
    slack: float | None = None
    robots: tuple[int, ...] | None = None
    stack: str = ""
    revision: int | None = None


@dataclass(frozen=True, slots=True)
class Announcement:
    """A message to the source: solve this stack from a tick on, or no longer from a tick on.

    Attributes:
        id: of the transition.
        stack: to be solved.
        start_tick: the first tick to solve it for, or the first one for which no longer.
        active: which of the two.
        robots: places in the team of the robots that the stack moves; empty: of all.
    """

    id: int
    stack: str
    start_tick: int
    active: bool
    robots: tuple[int, ...] = ()


class SourceSchedule:
    """Used by the source: which announced stacks it solves at a tick."""

    def __init__(self) -> None:
        """Start with nothing to solve."""
        self._active: dict[int, Announcement] = {}
        self._ends: dict[int, int] = {}  # the tick from which on each is no longer wanted

    @property
    def is_busy(self) -> bool:
        """Whether any stack is to be solved, now or later."""
        return bool(self._active)

    def hear(self, announcement: Announcement) -> None:
        """Take an announcement; a later one with the same id replaces it."""
        if announcement.active:
            self._active[announcement.id] = announcement
            self._ends.pop(announcement.id, None)
        elif announcement.id in self._active:
            self._ends[announcement.id] = announcement.start_tick

    def current(self, tick: int) -> tuple[Announcement, ...]:
        """Return the stacks to solve for a tick, and forget those that newer ones replace.

        A newer one replaces those whose robots it moves: the controller follows it alone.
        """
        for id_ in [id_ for id_, end in self._ends.items() if end <= tick]:
            del self._ends[id_], self._active[id_]
        started = [entry for entry in self._active.values() if entry.start_tick <= tick]
        started.sort(key=lambda entry: (entry.start_tick, entry.id))
        for i, entry in enumerate(started):
            if any(_covers(later, entry) for later in started[i + 1 :]):
                del self._active[entry.id]
                self._ends.pop(entry.id, None)
        return tuple(entry for entry in started if entry.id in self._active)


def _covers(later: Announcement, earlier: Announcement) -> bool:
    """Return whether a stack moves all robots of another one."""
    if not later.robots:
        return True
    return bool(earlier.robots) and set(earlier.robots) <= set(later.robots)
