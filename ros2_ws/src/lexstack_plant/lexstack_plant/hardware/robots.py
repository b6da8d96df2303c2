"""All robots of a plant file at once: what is measured of them, in the order of chi."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from lexstack.errors import InputError
from lexstack.robots import RobotModel, Team
from lexstack.types import Vector
from lexstack_config.plant_file import PlantFile
from lexstack_plant.hardware.memory import HardwareMemory
from lexstack_plant.hardware.robot import HardwareRobot


class HardwareRobots:
    """The robots of a team behind their topics.

    Attributes:
        team: their models.
        named: by name, with their intakes.
    """

    def __init__(self, team: Team, plant: PlantFile, hold: int) -> None:
        """Make the robots; ``hold`` [ticks] is how long a trajectory goes on alone."""
        self.team = team
        self.named = {
            model.name: HardwareRobot(
                model,
                plant.robots[model.name],
                plant.safety,
                team.dt,
                hold,
                shared=plant.use_sim_time,
            )
            for model in team.robots
        }

    def find(self, name: str) -> HardwareRobot:
        """Return a robot; raises InputError if it is unknown."""
        if name not in self.named:
            raise InputError(f"unknown robot {name!r}; known: {', '.join(self.named)}")
        return self.named[name]

    def parts(self) -> Iterator[tuple[RobotModel, slice, slice, HardwareRobot]]:
        """Yield every robot's model, its parts of q and of chi, and its topics."""
        team = self.team
        return zip(team.robots, team.q_slices, team.slices, self.named.values(), strict=True)

    def part(self, name: str) -> tuple[slice, slice]:
        """Return a robot's parts of q and of chi."""
        place = self.team.index(name)
        return self.team.q_slices[place], self.team.slices[place]

    def push(self, chi: Vector) -> None:
        """Take the command of a tick that is not sent, shape (n,)."""
        for _, _, part, robot in self.parts():
            robot.push(chi[part])

    def wrong(self, now: float) -> str:
        """Return why a robot may not move, as far as one looks at it alone, or ''."""
        return next((wrong for r in self.named.values() if (wrong := r.wrong(now))), "")

    def measure(self, m: HardwareMemory, now: float) -> None:
        """Read the measured state of all robots; where nothing is known the last one stays."""
        for model, at, part, robot in self.parts():
            q, v = robot.measured(now)
            known = np.isfinite(q)
            m.q[at] = np.where(known, q, m.q[at])
            # Of a platform all is known or nothing: of q its end says as much as its beginning.
            m.v[part] = np.where(known[model.nq - model.n :], v, 0.0)

    def look_ahead(self, m: HardwareMemory, now: float, *, trusted: bool) -> None:
        """Work out what is on its way; ``trusted``: the measured state counts."""
        for model, at, part, robot in self.parts():
            m.in_flight[part] = robot.in_flight(m.command[part])
            if trusted and not robot.wrong(now):
                # Wheels slip: where a platform was led is where it is.
                base = model.base_q
                m.q_star[at][base] = model.integrate(m.q[at], m.in_flight[part], 1.0)[base]

    def away(self, m: HardwareMemory) -> Vector:
        """Return how far each joint is from where it is led, shape (n,).

        An arm may be led to positions. A platform is led by velocities, and its pose may be
        corrected by whoever measures it: there the way that it did not make lately counts.
        """
        away = m.slip.copy()
        for model, at, part, robot in self.parts():
            led = robot.output.led
            if led is not None:
                away[part][model.arm] = led - m.q[at][model.arm_q]
        return away

    def coming(self, m: HardwareMemory) -> Vector:
        """Return where all robots are once what is on its way has moved them, shape (nq,)."""
        return self.team.integrate(m.q, m.in_flight, 1.0)
