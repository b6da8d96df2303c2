"""Options of transitions: what a user sets, and what a controller needs beside it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from lexstack.options import NotNegative, Positive


@dataclass(frozen=True, slots=True)
class TransitionConfig:
    """How the controller goes from one stack to another."""

    duration: Positive  # s, of the blend
    method: str = "bridge"  # a key of METHODS: how to join the old motion to the new one
    # How alpha rises; time_optimal: as fast as the joints allow, whatever the duration.
    profile: Literal["quintic", "cosine", "linear", "time_optimal"] = "quintic"
    on_loss: Literal["local", "minimum_velocity"] = "local"  # what to follow if the solver is lost
    at_end: Literal["adopt", "stay"] = "adopt"  # adopt the stack, or stay with the solver
    # s, how long position limits move that a stack changes; 0: least time
    limits_move: NotNegative = 0.0


@dataclass(frozen=True, slots=True)
class TransitionOptions:
    """What the transitions of one controller follow; a tick is one control period.

    Attributes:
        initial: name of the stack that is in effect at the start.
        switch: how to go from stack to stack, where a request does not say otherwise.
        lockstep: whether every tick waits for the sources' answers; else the newest ones count.
        limit_jerk: whether jerk is limited at every tick, not only by methods that do so.
        horizon: how many ticks ahead of the present one a switch may be asked for.
        patience: how many ticks the first chi of a source is waited for; in lockstep 0.
        stale: how many ticks a source's chi may be late; in lockstep 0.
        plan_every: ticks from plan to plan; in lockstep only the plan that is due counts.
        plan_stale: after how many ticks a plan is too old; without effect in lockstep.
    """

    initial: str
    switch: TransitionConfig
    lockstep: bool = True
    limit_jerk: bool = False
    horizon: int = 6000
    patience: int = 50
    stale: int = 5
    plan_every: int = 5
    plan_stale: int = 25
