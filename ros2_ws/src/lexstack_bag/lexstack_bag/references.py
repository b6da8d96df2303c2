"""The references in effect at every tick, by the rule that the controllers follow."""

from __future__ import annotations

import numpy as np

from lexstack_bag.run import Run, Target
from lexstack_core.model import Pose, Team
from lexstack_core.references import References, ReferenceSchedule
from lexstack_core.references import Target as ScheduledTarget
from lexstack_core.rotation import from_quaternion


def references_in_effect(run: Run, team: Team) -> tuple[References, ...]:
    """Return the references at every tick of the plant: the scenario's, then what was published.

    Robot A may put a change off by the few ticks until robot B answers; that is not seen here.
    """
    home = team.home(run.resolved)
    schedule = ReferenceSchedule.from_scenario(run.resolved.scenario, team, home)
    for target in run.targets:
        if target.robot in team.names:
            schedule.add(_scheduled(target, team))
    return tuple(schedule.at(float(stamp)) for stamp in run.plant.stamp)


def _scheduled(target: Target, team: Team) -> ScheduledTarget:
    """Return a recorded target as the core takes it."""
    rotation = from_quaternion(target.quaternion)
    robot = team.index(target.robot)
    if target.kind == "ee":
        return ScheduledTarget(target.time, robot, ee=Pose(target.position, rotation))
    yaw = np.arctan2(rotation[1, 0], rotation[0, 0])
    return ScheduledTarget(target.time, robot, base=np.array([*target.position[:2], yaw]))
