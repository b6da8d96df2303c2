"""The stand-in without ROS: MuJoCo at 1 kHz behind messages, as values, with habits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import ceil, floor

import numpy as np

from lexstack.types import Vector
from lexstack_config.parts import build_team
from lexstack_config.plant_file import PlantFile
from lexstack_config.resolved import ResolvedScenario
from lexstack_plant.hardware.base_intake import BaseSample
from lexstack_plant.hardware.joint_intake import JointSample
from lexstack_plant.hardware.spline import Point
from lexstack_testing.stand_in.habits import Habits
from lexstack_testing.stand_in.led_plant import LedPlant, PathLoop
from lexstack_testing.stand_in.lines import Lines
from lexstack_testing.stand_in.robot import PERIOD, Command, StandInRobot

_MOST = 10  # steps at once: gravity changes little in them
_SAME = 1e-6  # of a step: no difference of times


@dataclass(frozen=True, slots=True)
class Sent:
    """A message of the stand-in: of a robot, about its joints or its platform.

    Attributes:
        robot: whose.
        sample: what it says.
        arrives: when it comes to whoever listens [s].
    """

    robot: str
    sample: JointSample | BaseSample
    arrives: float


class StandIn:
    """Robots in MuJoCo, with what lies between them and whoever commands them.

    Times are seconds of the clock of whoever calls, who advances it.

    Attributes:
        team: the robots' models.
        plant: the robots themselves, with steps of 1 ms.
        robots: by name, their controllers and drives.
        habits: of all of them.
    """

    def __init__(
        self,
        resolved: ResolvedScenario,
        plant: PlantFile,
        habits: Habits,
        now: float,
        seed: int = 0,
    ) -> None:
        """Put the robots of a scenario where it starts, at ``now`` [s]."""
        fast = replace(resolved, scenario=replace(resolved.scenario, rate=1.0 / PERIOD))
        self.team = build_team(fast)
        self.plant = LedPlant(fast, self.team, seed, loop=PathLoop)
        self.habits = habits
        home = self.plant.q.copy()
        self.robots = {
            model.name: StandInRobot(
                model, plant.robots[model.name], 1.0 / plant.rate, home[part], habits
            )
            for model, part in zip(self.team.robots, self.team.q_slices, strict=True)
        }
        self._random = np.random.default_rng(seed)
        self._coming: Lines[tuple[str, str, Sequence[Point] | Vector]] = Lines(habits, self._random)
        self._going: Lines[tuple[str, JointSample | BaseSample]] = Lines(habits, self._random)
        self._begin, self._steps, self._told = now, 0, 0

    def begin(self, now: float) -> None:
        """Let the robots' time be ``now`` [s]; raises RuntimeError once they have moved."""
        if self._steps:
            raise RuntimeError("the robots have moved already")
        self._begin = now

    @property
    def time(self) -> float:
        """Up to when the robots were moved [s]: when they measured last."""
        return self._begin + self._steps * PERIOD

    @property
    def next_states(self) -> float:
        """When the robots measure next [s]."""
        return self._begin + self._measures * PERIOD

    @property
    def _measures(self) -> int:
        """After which step the robots measure next; the first time after the first step."""
        due = ceil(self._told / (self.habits.rate * PERIOD) - _SAME)
        return max(self._steps + 1, due)

    def command_arm(self, robot: str, command: Sequence[Point] | Vector, now: float) -> None:
        """Send an arm a trajectory with absolute times, or an array, at ``now`` [s]."""
        self._coming.send((robot, "arm"), (robot, "arm", command), now)

    def command_base(self, robot: str, twist: Vector, now: float) -> None:
        """Send a platform a twist along its own axes, shape (3,), at ``now`` [s]."""
        self._coming.send((robot, "base"), (robot, "base", twist), now)

    def press(self, robot: str) -> None:
        """Press a robot's emergency stop: its drives stop and refuse everything."""
        part = self.team.q_slices[self.team.index(robot)]
        mine = self.robots[robot]
        mine.press(self.plant.q[part][mine.model.arm_q])

    def release(self, robot: str) -> None:
        """Let a robot's drives follow again, from where they are; commands of before are gone."""
        self.robots[robot].release()

    def stopped(self) -> dict[str, str]:
        """Return the robots whose drives have stopped, and why."""
        return {
            name: robot.drive.stopped for name, robot in self.robots.items() if robot.drive.stopped
        }

    def advance(self, now: float) -> list[Sent]:
        """Let time pass until ``now`` [s]; return the messages that arrive until then.

        The robots are moved up to when they measured last, many steps at once: what they do
        afterwards nobody knows yet, and commands that come meanwhile are still in time.
        """
        last = floor((now - self._begin) / PERIOD + _SAME)
        while (measures := self._measures) <= last:
            while self._steps < measures:
                steps = min(measures - self._steps, _MOST)
                self._move(steps)
                self._steps += steps
            self._told += 1
            self._measure()
        return [Sent(*message, arrives) for arrives, message in self._going.arrived(now)]

    def _move(self, steps: int) -> None:
        """Move the robots by some milliseconds, in which they take what has arrived."""
        start, team, q = self.time, self.team, self.plant.q
        commands: dict[str, list[Command]] = {name: [] for name in self.robots}
        for at, (name, what, value) in self._coming.arrived(start + (steps - 1 + _SAME) * PERIOD):
            commands[name].append(Command(at, what, value))
        q_star, chi = np.tile(q, (steps + 1, 1)), np.empty((steps, team.n))
        torques = None
        for robot, mine, places in zip(
            self.robots.values(), team.slices, team.q_slices, strict=True
        ):
            model = robot.model
            yaw = float(q[places][2]) if model.has_base else 0.0
            path = robot.path(start, steps, commands[model.name], yaw)
            q_star[:, places][:, model.arm_q] = path.arm
            chi[:, mine] = path.chi
            if path.torques is not None:
                torques = np.full((steps, team.nq), np.nan) if torques is None else torques
                torques[:, places][:, model.arm_q] = path.torques
        self.plant.lead(q_star, chi, torques)

    def _measure(self) -> None:
        """Send what the robots measure now."""
        state, now = self.plant.measure(), self.time
        for robot, mine, places in zip(
            self.robots.values(), self.team.slices, self.team.q_slices, strict=True
        ):
            q, v = state.q[places], state.v[mine]
            self._report(robot.model.name, robot.joints(q, v, now, self._random))
            platform = robot.platform(q, v, now)
            if platform is not None:
                self._report(robot.model.name, platform)

    def _report(self, name: str, sample: JointSample | BaseSample) -> None:
        """Send a message, perhaps twice."""
        line = (name, type(sample).__name__)
        self._going.send(line, (name, sample), self.time)
        if self._random.random() < self.habits.repeat:
            self._going.send(line, (name, sample), self.time)
