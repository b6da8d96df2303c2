"""The stand-in without ROS: MuJoCo at 1 kHz behind messages, as values, with habits."""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import cos, sin
from typing import Any

import numpy as np

from lexstack.limits import LIMITS, JointLimits
from lexstack.robots import RobotModel, Team
from lexstack.types import Vector
from lexstack_config.parts import build_team
from lexstack_config.plant_file import PlantFile
from lexstack_config.resolved import ResolvedScenario
from lexstack_plant.hardware.base_intake import BaseSample, composed, inverse, turned
from lexstack_plant.hardware.joint_intake import JointSample
from lexstack_plant.hardware.spline import Point
from lexstack_sim.impedance import ImpedanceLoop, TorqueLoop
from lexstack_sim.plant import Plant
from lexstack_testing.stand_in.consumers import (
    ArmConsumer,
    BaseConsumer,
    PositionConsumer,
    TrajectoryConsumer,
    VelocityConsumer,
)
from lexstack_testing.stand_in.drive import Drive
from lexstack_testing.stand_in.habits import Habits
from lexstack_testing.stand_in.torques import HeldTorques

PERIOD = 1e-3  # s, of everything inside
_FASTEST = 2.0  # times the velocity limit: how fast q* goes where it has been pulled back
_STRANGERS = ("gripper_left", "gripper_right")  # joints that nobody controls here


@dataclass(frozen=True, slots=True)
class Sent:
    """A message of the stand-in: of a robot, about its joints or its platform."""

    robot: str
    sample: JointSample | BaseSample


class _Robot:
    """One robot: its controllers and drives, and what it measures."""

    def __init__(
        self, model: RobotModel, part: slice, kind: str, period: float, home: Vector, habits: Habits
    ) -> None:
        """Stand at home, shape (n,) of the robot; commands come every ``period`` [s]."""
        self.model, self.part = model, part
        arm = home[model.arm]
        limits = model.limits
        self.most = _FASTEST * limits.velocity[model.arm]
        mine = JointLimits(**{name: getattr(limits, name)[model.arm] for name in LIMITS})
        self.drive = Drive(mine, arm, PERIOD, reflex=habits.reflex)
        kinds: dict[str, ArmConsumer] = {
            "joint_trajectory": TrajectoryConsumer(arm),
            "position": PositionConsumer(arm, period),
            "velocity": VelocityConsumer(arm, period),
            "effort": PositionConsumer(arm, period),  # of no effect
        }
        self.arm = kinds[kind]
        self.base = BaseConsumer(limits.acceleration[model.base]) if model.has_base else None
        # Odometry begins at zero where the robot stands.
        self.start = home[model.base].copy() if model.has_base else np.zeros(3)
        self.odometry: Vector = np.zeros(3)
        self.before = self.start.copy()


class StandIn:
    """Robots in MuJoCo, with what lies between them and whoever commands them.

    Times are seconds of the clock of whoever calls, who advances it.

    Attributes:
        plant: the robots themselves, with ticks of 1 ms.
        time: up to which they were moved [s].
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
        self._effort = [name for name in self.team.names if plant.robots[name].arm.type == "effort"]
        self._held: dict[str, Vector] = {}
        self.plant = Plant(fast, self.team, seed, loop=self._loop)
        self.time = now
        self.habits = habits
        self._state = self.plant.state()
        home = self._state.q
        self.robots = {
            model.name: _Robot(
                model, part, plant.robots[model.name].arm.type, 1.0 / plant.rate, home[part], habits
            )
            for model, part in zip(self.team.robots, self.team.slices, strict=True)
        }
        self._random = np.random.default_rng(seed)
        self._count = itertools.count()
        self._coming: list[tuple[float, int, tuple[str, str], Any]] = []  # commands on their way
        self._going: list[tuple[float, int, tuple[str, str], Any]] = []  # states on their way
        self._arrival: dict[tuple[str, str], float] = {}  # of the last message of each line
        self._next = now

    def _loop(self, team: Team, period: float, control: Vector) -> TorqueLoop:
        """Return what controls the actuators: torques are passed on as they come."""
        places = {
            model.name: part.start + np.arange(model.arm.start, model.arm.stop)
            for model, part in zip(team.robots, team.slices, strict=True)
            if model.name in self._effort
        }
        return HeldTorques(ImpedanceLoop(team, period, control), control, places, self._held)

    def command_arm(self, robot: str, command: Sequence[Point] | Vector, now: float) -> None:
        """Send an arm a trajectory with absolute times, or an array, at ``now`` [s]."""
        self._send(self._coming, now, (robot, "arm"), command)

    def command_base(self, robot: str, twist: Vector, now: float) -> None:
        """Send a platform a twist along its own axes, shape (3,), at ``now`` [s]."""
        self._send(self._coming, now, (robot, "base"), twist)

    def press(self, robot: str) -> None:
        """Press a robot's emergency stop: its drives stop and refuse everything."""
        self.robots[robot].drive.stop("emergency stop")

    def release(self, robot: str) -> None:
        """Let a robot's drives follow again, from where they are; commands of before are gone."""
        mine = self.robots[robot]
        q = self._state.q_star[mine.part][mine.model.arm].copy()
        mine.drive.release(q)
        period = getattr(mine.arm, "_period", 0.01)
        kind = type(mine.arm)
        mine.arm = kind(q) if kind is TrajectoryConsumer else kind(q, period)

    def stopped(self) -> dict[str, str]:
        """Return the robots whose drives have stopped, and why."""
        return {
            name: robot.drive.stopped for name, robot in self.robots.items() if robot.drive.stopped
        }

    def advance(self, now: float) -> list[Sent]:
        """Move the robots up to ``now`` [s]; return the messages that arrive until then."""
        while self.time + PERIOD <= now + 1e-9:
            self._step()
        arrived = []
        while self._going and self._going[0][0] <= now:
            arrived.append(heapq.heappop(self._going)[3])
        return arrived

    def _step(self) -> None:
        """Move the robots by one millisecond."""
        while self._coming and self._coming[0][0] <= self.time:
            at, _, (name, what), command = heapq.heappop(self._coming)
            robot = self.robots[name]
            if what == "arm" and name in self._effort:
                self._held[name] = command
            elif what == "arm":
                robot.arm.take(command, max(at, self.time))
            elif robot.base is not None:
                robot.base.take(command, self.time)
        state = self._state
        self.time += PERIOD
        chi = np.zeros(self.team.n)
        for robot in self.robots.values():
            mine = chi[robot.part]
            model, q_star = robot.model, state.q_star[robot.part]
            asked = robot.drive.follow(robot.arm.at(self.time))
            lead = (asked - q_star[model.arm]) / PERIOD
            mine[model.arm] = np.minimum(np.maximum(lead, -robot.most), robot.most)
            if robot.base is not None:
                twist = robot.base.step(self.time, PERIOD)
                if robot.drive.stopped:
                    twist = np.zeros(3)
                mine[model.base] = turned(twist, float(state.q[robot.part][2]))
        after = self._state = self.plant.step(chi)
        if self.time >= self._next - 1e-9:
            self._next += 1.0 / self.habits.rate
            for name, robot in self.robots.items():
                self._drift(robot, after.q[robot.part])
                self._tell(name, robot, after.q[robot.part], after.v[robot.part])

    def _drift(self, robot: _Robot, q: Vector) -> None:
        """Integrate a platform's odometry, wrong by its share of the way."""
        if robot.base is None:
            return
        pose = q[robot.model.base]
        moved = composed(inverse(robot.before), pose)  # in the axes of the platform
        robot.odometry = composed(robot.odometry, (1.0 + self.habits.drift) * moved)
        robot.before = pose.copy()

    def _tell(self, name: str, robot: _Robot, q: Vector, v: Vector) -> None:
        """Send what a robot measures."""
        habits, arm = self.habits, robot.model.arm
        names = [*robot.model.joints[arm]]
        positions, velocities = q[arm].copy(), v[arm].copy()
        if habits.quantum:
            positions = habits.quantum * np.round(positions / habits.quantum)
        if habits.reorder:
            names += _STRANGERS
            positions = np.concatenate([positions, [0.01, 0.02]])
            velocities = np.concatenate([velocities, [0.0, 0.0]])
            order = self._random.permutation(len(names))
            names = [names[i] for i in order]
            positions, velocities = positions[order], velocities[order]
        sent = velocities.tolist() if habits.velocities else []
        self._report(name, JointSample(names, positions.tolist(), sent, self.time, 0.0))
        if robot.base is None:
            return
        x, y, yaw = robot.odometry.tolist()
        twist = turned(v[robot.model.base], -float(q[robot.model.base][2]))
        turn = (0.0, 0.0, sin(0.5 * yaw), cos(0.5 * yaw))
        self._report(name, BaseSample(x, y, turn, twist.tolist(), self.time, 0.0, "odom"))

    def _report(self, name: str, sample: JointSample | BaseSample) -> None:
        """Send a message, perhaps twice."""
        line = (name, type(sample).__name__)
        self._send(self._going, self.time, line, Sent(name, sample))
        if self._random.random() < self.habits.repeat:
            self._send(self._going, self.time, line, Sent(name, sample))

    def _send(self, queue: list[Any], now: float, line: tuple[str, str], message: Any) -> None:
        """Put a message on its way, late by jitter or more, or lose it.

        None overtakes another one on its line: one that is late holds up those behind it.
        """
        habits = self.habits
        chance, lateness = self._random.random(2)
        if chance < habits.drop:
            return
        delay = habits.jitter * lateness
        if chance < habits.drop + habits.late:
            delay += habits.late_by
        arrives = max(now + delay, self._arrival.get(line, -np.inf))
        self._arrival[line] = arrives
        heapq.heappush(queue, (arrives, next(self._count), line, message))
