"""Taking robots over: whether one may move now, and the state in which all begin."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from lexstack.errors import InputError
from lexstack.types import PlantStatus, Vector
from lexstack_plant.hardware.guard import Guard
from lexstack_plant.hardware.memory import HardwareMemory
from lexstack_plant.hardware.robots import HardwareRobots

_STILL = 0.02  # rad/s and m/s: slower joints are taken to be at rest when they are taken over


class Takeover:
    """Checks robots before they are commanded, and begins at what is measured of them."""

    def __init__(self, robots: HardwareRobots, guard: Guard, places: Mapping[str, Vector]) -> None:
        """Take the robots; ``places`` are x [m], y [m], yaw [rad] where the scenario puts each."""
        self._robots, self._guard, self._places = robots, guard, places

    def check(self, name: str, m: HardwareMemory, now: float) -> None:
        """Raise InputError if a robot may not move now."""
        robot, team = self._robots.named[name], self._robots.team
        wrong = robot.wrong(now)
        if wrong:
            raise InputError(wrong)
        if robot.base is not None:
            robot.base.place(self._places[name])
        q, v = m.q.copy(), np.zeros(team.n)
        at, part = self._robots.part(name)
        q[at], v[part] = robot.measured(now)
        places = np.clip(0.0, team.limits.position_lower, team.limits.position_upper)
        places[part] = team.joint_positions(q)[part]
        unready = self._guard.unready(places, v)
        if unready:
            raise InputError(unready)

    def begin(self, m: HardwareMemory, now: float) -> None:
        """Begin at the measured state: nothing of before is left."""
        self._robots.measure(m, now)
        limit = self._robots.team.limits.velocity
        # A user's own controller may move the robot: ours begins with its velocity. What a robot
        # at rest measures as velocity is noise.
        m.command[:] = np.where(np.abs(m.v) > _STILL, np.clip(m.v, -limit, limit), 0.0)
        m.q_star[:], m.change[:], m.slip[:] = m.q, 0.0, 0.0
        m.tick, m.silence, m.status, m.due = 0, 0, PlantStatus.FOLLOWING, now
        for _, at, part, robot in self._robots.parts():
            robot.begin(m.q[at], m.command[part])
            m.in_flight[part] = robot.in_flight(m.command[part])
        m.q_star[:] = self._robots.coming(m)
