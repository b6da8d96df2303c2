"""Whose chi robot A follows: robot B's while it is fresh, else A's own stand-in."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from lexstack_core.config.scenario import ScenarioConfig
from lexstack_core.linear import Vector
from lexstack_core.model import Kinematics
from lexstack_core.references import References
from lexstack_core.stack import Stack
from lexstack_core.transition.status import Source, SourceSample
from lexstack_core.transition.witness import Rows, Witness

_EVIDENCE = 10  # chi in a row that miss level 1, in realtime


class LocalSource(Protocol):
    """A's own stand-in for robot B."""

    def chi(self, stack: Stack, kinematics: Kinematics, references: References) -> Vector:
        """Return the optimum of a stack, shape (n,), or zeros where it cannot be solved."""
        ...

    def at_rest(self, stack: Stack) -> Stack:
        """Return level 1 of a stack with minimum velocity below it."""
        ...


@dataclass(frozen=True, slots=True)
class Moment:
    """One tick as a transition sees it.

    Attributes:
        kinematics: at the measured state.
        references: in effect at this tick.
        before: in effect at the tick before.
    """

    kinematics: Kinematics
    references: References
    before: References

    @property
    def tick(self) -> int:
        """The tick's number."""
        return self.kinematics.state.tick


class Sources:
    """Robot B as it is heard, and what stands in for it."""

    def __init__(self, local: LocalSource, scenario: ScenarioConfig) -> None:
        """Know the stand-in, and from the scenario when B counts as lost."""
        self._local = local
        self._lost = Source(scenario.transition.on_loss)
        self._heard: dict[int, SourceSample] = {}  # the newest of each transition
        # In lockstep the wait has happened, on the wall's clock, before a tick is served.
        lockstep, timeouts = scenario.mode == "lockstep", scenario.timeouts
        self._stale = 0 if lockstep else round(timeouts.source_stale * scenario.rate)
        self._patience = 0 if lockstep else round(timeouts.source_patience * scenario.rate)
        self._witness = Witness(self._stale, 1 if lockstep else _EVIDENCE)

    def hear(self, sample: SourceSample) -> None:
        """Take robot B's newest chi of a transition."""
        self._heard[sample.transition_id] = sample

    def keep(self, transition_ids: Collection[int]) -> None:
        """Forget all other transitions."""
        self._heard = {id_: heard for id_, heard in self._heard.items() if id_ in transition_ids}
        self._witness.keep(transition_ids)

    def fresh(self, transition_id: int, tick: int) -> Vector | None:
        """Return B's chi (n,) for a transition if it is new enough for this tick, else None."""
        heard = self._heard.get(transition_id)
        if heard is None or not heard.solved:
            return None
        return heard.chi if 0 <= tick - heard.tick <= self._stale else None

    def answered_since(self, transition_id: int, tick: int) -> bool:
        """Return whether B has solved for a transition at a later tick than this one."""
        heard = self._heard.get(transition_id)
        return heard is not None and heard.solved and heard.tick > tick

    def wrong_by(self, transition_id: int, tick: int, level: Rows, *, anew: bool = False) -> float:
        """Return by how much a source's chi misses what it says of level 1, 0 if it does not.

        ``level`` is level 1 at this tick; without it there is nothing to compare. ``anew``: with
        other references than at the tick before.
        """
        heard = self._heard.get(transition_id)
        return 0.0 if heard is None else self._witness.miss(heard, tick, level, anew=anew)

    def first(
        self,
        transition_id: int,
        asked_at: int,
        tick: int,
        level: Rows = (),
        asked: Source = Source.ROBOT_B,
    ) -> tuple[Source, str] | None:
        """Return whom to follow into a new stack and why, or None while the wait goes on.

        ``level`` is level 1 of the new stack at this tick, ``asked`` who is to solve it.
        """
        if self.fresh(transition_id, tick) is not None:
            miss = self.wrong_by(transition_id, tick, level)
            return (self._lost, _wrong(tick, miss, self._lost)) if miss else (asked, "")
        if tick - asked_at >= self._patience:
            instead = _instead(self._lost, asked)
            return self._lost, f"{asked.called} sent no chi by tick {tick}: {instead}"
        return None

    def present(
        self,
        source: Source,
        transition_id: int,
        moment: Moment,
        level: Rows,
        asked: Source = Source.ROBOT_B,
    ) -> tuple[Source, str]:
        """Return whom to follow now, and why where it is no longer ``source``, else ''.

        ``level`` is level 1 of the new stack at this tick, ``asked`` who is to solve it.
        """
        tick, changed = moment.tick, source is not asked
        if self.fresh(transition_id, tick) is not None:
            anew = moment.references is not moment.before
            miss = self.wrong_by(transition_id, tick, level, anew=anew)
            if not miss:
                return asked, f"{asked.called} is back at tick {tick}" if changed else ""
            return (source, "") if changed else (self._lost, _wrong(tick, miss, self._lost))
        if source is not asked:
            return source, ""
        heard = self._heard.get(transition_id)
        last = "nothing" if heard is None else f"tick {heard.tick}"
        instead = _instead(self._lost, asked)
        lost = f"{asked.called} lost at tick {tick}, last heard {last}: {instead}"
        return self._lost, lost

    def chi(self, source: Source, transition_id: int, stack: Stack, moment: Moment) -> Vector:
        """Return the chi of a source for this tick, shape (n,).

        From robot B or the MPC it must be fresh: ``first`` and ``present`` choose it only then.
        """
        if source in (Source.ROBOT_B, Source.HTMPC):
            fresh = self.fresh(transition_id, moment.tick)
            assert fresh is not None
            return fresh
        if source is Source.LOCAL:
            return self._local.chi(stack, moment.kinematics, moment.references)
        return np.zeros_like(moment.kinematics.state.command)

    def at_rest(self, stack: Stack) -> Stack:
        """Return the stack that A adopts when it has come to minimum velocity."""
        return self._local.at_rest(stack)


def _wrong(tick: int, miss: float, instead: Source) -> str:
    """Return what is said of a chi that is not what it claims to be."""
    return f"robot B's chi at tick {tick} misses level 1 by {miss:.2g}: {_instead(instead)}"


def _instead(source: Source, asked: Source = Source.ROBOT_B) -> str:
    """Return what A follows in place of the source that was asked, in words."""
    if asked is Source.HTMPC:
        return "the robots come to rest"
    if source is Source.LOCAL:
        return "robot A solves the new stack itself"
    return "robot A goes to minimum velocity"
