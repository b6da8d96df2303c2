"""What happens in the experiment sudden-limits, and the laws by which limits are kept."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from lexstack.limits import BoundsProvider, LimitOptions, LimitsInForce
from lexstack.tasks import JointLimitConfig
from lexstack_config.parts import Parts
from lexstack_config.resolved import ResolvedScenario
from lexstack_config.scenario import EventConfig
from lexstack_experiments.baselines.printed_law import PrintedLaw, Reading, Repair
from lexstack_experiments.runs import changed, scenario_of, with_method

NAME = "sudden-limits"
STACK = "confined"
_END = 5.0  # s, of the cases in the ideal plant
_SLOWER = 0.3  # times the arms' velocity and acceleration limits, with the new limits
_SOFT = 20.0  # rad/s^3 per rad/s^2 of acceleration: the whole of it after 50 ms
_SLOW = 1.0  # s


@dataclass(frozen=True, slots=True)
class Case:
    """One closed loop.

    Attributes:
        name: what happens, in few words.
        resolved: the scenario.
        start: s, the switch to ``STACK`` that is looked at.
        end: s, until then.
        mujoco: in the MuJoCo plant; else in the ideal one.
        jerk: whether the new limits have jerk limits that are to be kept.
    """

    name: str
    resolved: ResolvedScenario
    start: float
    end: float
    mujoco: bool = False
    jerk: bool = False


@dataclass(frozen=True, slots=True)
class Law:
    """One way to keep limits, named; ``make`` takes the parts and the duration of a blend [s]."""

    name: str
    make: Callable[[Parts, float], BoundsProvider]


def cases(config: Path, seed: int) -> list[Case]:
    """Return all cases."""
    whole = changed(scenario_of(config, NAME), seed=seed)
    goes, trigger, leaves = whole.scenario.events
    moving = changed(whole, events=(goes, trigger), duration=_END)
    back = EventConfig(at=trigger.at + 0.12, switch="track")
    again = EventConfig(at=trigger.at + 0.3, switch=STACK)
    pre_empted = changed(moving, events=(goes, trigger, back, again))
    slower = _with_limits(moving, velocity=_SLOWER, acceleration=_SLOWER)
    soft = with_method(_with_jerk(moving), "bridge_jerk")
    span = (trigger.at, _END)
    return [
        Case("in motion", moving, *span),
        Case("at rest", changed(moving, events=(trigger,)), *span),
        Case("slower joints too", slower, *span),
        Case("pre-empted", pre_empted, again.at, _END),
        Case("jerk limits", soft, *span, jerk=True),
        Case("MuJoCo, in motion", whole, trigger.at, leaves.at, mujoco=True),
    ]


def laws(case: Case) -> list[Law]:
    """Return the laws that are compared in a case, ours first."""
    ours = [_ours("ours")]
    if case.jerk:
        return ours
    if case.mujoco:
        return [*ours, _printed("T(31)", "brake"), _printed("T(31)", "give way")]
    readings: tuple[Reading, ...] = ("T(31)", "T(34) old limits", "T(34) last box")
    repairs: tuple[Repair, ...] = ("brake", "give way")
    ours.append(_ours(f"ours, within {_SLOW:g} s", duration=_SLOW))
    return ours + [_printed(reading, repair) for reading in readings for repair in repairs]


def _ours(name: str, **options: Any) -> Law:
    """Return ``LimitsInForce`` with these options."""

    def make(parts: Parts, _duration: float) -> LimitsInForce:
        return LimitsInForce(parts.team.limits, LimitOptions(parts.dt, **options))

    return Law(name, make)


def _printed(reading: Reading, repair: Repair) -> Law:
    """Return T(31) or T(34)."""

    def make(parts: Parts, duration: float) -> PrintedLaw:
        return PrintedLaw(parts.team.limits, parts.dt, duration, reading, repair)

    return Law(f"{reading}, {repair}", make)


def _with_limits(resolved: ResolvedScenario, **factors: float) -> ResolvedScenario:
    """Return the scenario with these limits of every arm joint a part of the robot's own."""
    arms = {name: resolved.robots[place.model].arm for name, place in _places(resolved)}

    def tighter(joint: JointLimitConfig, robot: str, k: int) -> JointLimitConfig:
        own = {name: getattr(arms[robot], name)[k] for name in factors}
        return replace(joint, **{name: factor * own[name] for name, factor in factors.items()})

    return _every_joint(resolved, tighter)


def _with_jerk(resolved: ResolvedScenario) -> ResolvedScenario:
    """Return the scenario with jerk limits of every arm joint that take time to act."""
    arms = {name: resolved.robots[place.model].arm for name, place in _places(resolved)}

    def soft(joint: JointLimitConfig, robot: str, k: int) -> JointLimitConfig:
        return replace(joint, jerk=_SOFT * arms[robot].acceleration[k])

    return _every_joint(resolved, soft)


def _every_joint(
    resolved: ResolvedScenario, change: Callable[[JointLimitConfig, str, int], JointLimitConfig]
) -> ResolvedScenario:
    """Return the scenario with the stack's limits of every arm joint changed."""
    stack = resolved.stacks[STACK]
    limits = {
        name: {
            joint: change(stack.limits[name].get(joint, JointLimitConfig()), name, k)
            for k, joint in enumerate(resolved.robots[place.model].arm.joints)
        }
        for name, place in _places(resolved)
    }
    return replace(resolved, stacks={**resolved.stacks, STACK: replace(stack, limits=limits)})


def _places(resolved: ResolvedScenario) -> Any:
    """Return the robots' names with their places."""
    return resolved.scenario.robots.items()
