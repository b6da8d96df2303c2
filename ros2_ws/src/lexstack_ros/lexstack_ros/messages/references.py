"""The controller's decisions on references as messages, and back."""

from __future__ import annotations

import numpy as np

from lexstack.errors import InputError
from lexstack.options import shown
from lexstack.references import WIDTHS, Moving, Setting, decode, encode, encode_moving
from lexstack.robots import Team
from lexstack_interfaces.msg import References, Trajectory
from lexstack_ros.messages.conversions import check_robots, stamped, to_array, to_seconds


def references_message(setting: Setting, team: Team, sender: str) -> References:
    """Return a decision as a message."""
    message = References(revision=setting.revision, sender=sender, robots=list(team.names))
    for name, vector in encode(setting).items():
        setattr(message, name, to_array(vector))
    message.trajectories = [
        Trajectory(
            robot=team.names[moving.robot],
            of=moving.of,
            frame=moving.frame,
            kind=moving.kind,
            values=to_array(moving.values),
            lead=to_array(moving.lead),
        )
        for moving in encode_moving(setting)
    ]
    return stamped(message, setting.at)


def to_setting(message: References, team: Team, where: str) -> Setting:
    """Return a decision; raises InputError. ``where``: its topic."""
    check_robots(message.robots, team, where)
    vectors = {name: getattr(message, name) for name in WIDTHS}
    at = to_seconds(message.header.stamp)
    moving = [_moving(entry, team, where) for entry in message.trajectories]
    arms = [len(robot.mid_range) for robot in team.robots]
    count = len(team.robots)
    return decode(at, message.revision, vectors, count, where, moving=moving, arms=arms)


def _moving(message: Trajectory, team: Team, where: str) -> Moving:
    """Return one reference in numbers."""
    if message.robot not in team.names:
        raise InputError(f"{where}: trajectories: no robot {shown(message.robot)}")
    values, lead = np.array(message.values), np.array(message.lead)
    robot = team.names.index(message.robot)
    return Moving(robot, message.of, message.kind, values, lead, message.frame)
