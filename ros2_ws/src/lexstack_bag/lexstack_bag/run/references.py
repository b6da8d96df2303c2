"""The references in effect at every tick, by the rule that the controllers follow."""

from __future__ import annotations

from collections import deque

import numpy as np

from lexstack.references import ROUNDING, References, ReferenceTimeline
from lexstack.references import Target as ScheduledTarget
from lexstack.robots import Pose, Team, from_quaternion
from lexstack_bag.run.run import Run, Target
from lexstack_config.parts import build_references

# What the controllers refuse, they refuse by these figures; see lexstack_ros.messages.conversions.
_FARTHEST = 1000.0  # m
_UNIT = 1e-2  # how far a quaternion's norm may be from 1
_UPRIGHT = 1e-3  # rad, how far a base target may be tilted


def is_usable(target: Target) -> bool:
    """Return whether the controllers take this target; what they refuse changes nothing."""
    if not np.isfinite([*target.position, *target.quaternion]).all():
        return False
    norm = float(np.linalg.norm(target.quaternion))
    if abs(norm - 1.0) > _UNIT or np.abs(target.position).max() > _FARTHEST:
        return False
    upright = min(max(float(from_quaternion(target.quaternion)[2, 2]), -1.0), 1.0)
    return target.kind == "ee" or float(np.arccos(upright)) <= _UPRIGHT


def references_in_effect(run: Run, team: Team) -> tuple[References, ...]:
    """Return the goals at every tick of the plant: the decisions, in older bags the targets.

    A set-point that is led in counts as its goal, and a trajectory that is led onto as itself. The
    controller may put a change off by the few
    ticks until the solver answers; that is not seen here.
    """
    if run.settings:
        return _goals(run)
    schedule = build_references(run.resolved, team)
    schedule.lead_in = 0.0  # the goals count
    for target in run.targets:
        if target.robot in team.names:
            schedule.add(scheduled(target, team))
    return tuple(schedule.at(float(stamp)) for stamp in run.plant.stamp)


def _goals(run: Run) -> tuple[References, ...]:
    """Return the goals of the decision in effect at every tick, one object while none moves."""
    timeline = ReferenceTimeline(run.period)
    coming = deque(run.settings)
    timeline.hear(coming.popleft().unled())
    found = []
    for stamp in run.plant.stamp.tolist():
        while coming and coming[0].at <= stamp + ROUNDING:
            timeline.hear(coming.popleft().unled())
        found.append(timeline.at(stamp))
    return tuple(found)


def scheduled(target: Target, team: Team) -> ScheduledTarget:
    """Return a recorded target as the library takes it."""
    rotation = from_quaternion(target.quaternion)
    robot = team.index(target.robot)
    if target.kind == "ee":
        return ScheduledTarget(target.time, robot, ee=Pose(target.position, rotation))
    yaw = np.arctan2(rotation[1, 0], rotation[0, 0])
    return ScheduledTarget(target.time, robot, base=np.array([*target.position[:2], yaw]))
