"""One robot of the stand-in: its controllers and drives, and what it measures."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import ceil, cos, sin
from typing import Any

import numpy as np

from lexstack.limits import LIMITS, JointLimits
from lexstack.robots import RobotModel
from lexstack.types import Matrix, Vector
from lexstack_config.plant_file import RobotInterfaceConfig
from lexstack_plant.hardware.base_intake import BaseSample, composed, inverse, turned
from lexstack_plant.hardware.joint_intake import JointSample
from lexstack_testing.stand_in.consumers import (
    ArmConsumer,
    BaseConsumer,
    PositionConsumer,
    TrajectoryConsumer,
    VelocityConsumer,
)
from lexstack_testing.stand_in.drive import Drive
from lexstack_testing.stand_in.habits import Habits

PERIOD = 1e-3  # s, of everything inside
_STRANGERS = ("gripper_left", "gripper_right")  # joints that nobody controls here
_DRIVEN = [0, 2]  # of a twist: what a differential platform can do
_SAME = 1e-6  # of a step: no difference of times


@dataclass(frozen=True, slots=True)
class Command:
    """A message that has arrived.

    Attributes:
        at: when [s].
        what: "arm" or "base".
        value: points of a trajectory, an array of the arm, or a twist.
    """

    at: float
    what: str
    value: Any


@dataclass(frozen=True, slots=True)
class Path:
    """Where one robot's drives lead it in k steps.

    Attributes:
        arm: positions before the first step and after each, shape (k + 1, m).
        chi: velocities of each step, shape (k, n).
        torques: of each step, shape (k, m); None: the drives follow ``arm``.
    """

    arm: Matrix
    chi: Matrix
    torques: Matrix | None = None


class StandInRobot:
    """One robot behind its topics.

    Attributes:
        model: the robot's.
        drive: those of its arm.
        odometry: x, y, yaw that it has counted, shape (3,).
    """

    def __init__(
        self,
        model: RobotModel,
        config: RobotInterfaceConfig,
        period: float,
        home: Vector,
        habits: Habits,
    ) -> None:
        """Stand at ``home``, shape (nq,); commands come every ``period`` [s]."""
        self.model, self._kind, self._period = model, config.arm.type, period
        arm, limits = home[model.arm_q], model.limits
        mine = JointLimits(**{name: getattr(limits, name)[model.arm] for name in LIMITS})
        self.drive = Drive(mine, arm, PERIOD, reflex=habits.reflex)
        self._habits = habits
        joints, names = model.joints[model.arm], config.joint_states.names
        self.names = [names.get(joint, joint) for joint in joints]
        self._arm = self._consumer(arm)
        self._torques: Vector | None = None
        self._base = BaseConsumer(limits.acceleration[model.base]) if model.has_base else None
        # Odometry begins at zero where the robot stands.
        self.odometry: Vector = np.zeros(3)
        self._before = home[model.base_q].copy()

    def press(self, arm: Vector) -> None:
        """Press the emergency stop of a robot whose arm is at a position, shape (m,)."""
        if self._torques is not None:
            self._torques = None
            self.drive.release(arm)
        self.drive.stop("emergency stop")

    def release(self) -> None:
        """Let the drives follow again, from where they are; commands of before are gone."""
        self.drive.release(self.drive.q)
        self._arm = self._consumer(self.drive.q)

    def path(self, start: float, steps: int, commands: Sequence[Command], yaw: float) -> Path:
        """Return where the drives lead the robot.

        Args:
            start: when the first step begins [s].
            steps: how many, each of 1 ms.
            commands: that arrive before the last step begins, in their order.
            yaw: of the platform at the start [rad].
        """
        model = self.model
        times = start + PERIOD * np.arange(1, steps + 1)
        before = self.drive.q
        asked, twists = np.empty((steps, len(before))), np.zeros((steps, 0))
        torques = np.full((steps, len(before)), np.nan)
        if self._base is not None:
            twists = np.empty((steps, model.base.stop - model.base.start))
        for part in self._parts(start, steps, commands):
            asked[part] = self._arm.path(times[part])
            if self._base is not None:
                twists[part] = self._base.path(times[part], PERIOD)
            if self._torques is not None:
                torques[part] = self._torques
        led, good = self.drive.follow(asked)
        twists[good:] = 0.0
        arm = np.concatenate([before[None], led])
        chi = np.empty((steps, model.n))
        chi[:, model.arm] = np.diff(arm, axis=0) / PERIOD
        chi[:, model.base] = twists if model.differential else _in_world(twists, yaw)
        return Path(arm, chi, None if self._torques is None else torques)

    def joints(self, q: Vector, v: Vector, time: float, random: np.random.Generator) -> JointSample:
        """Return what the encoders say at q (nq,), v (n,); ``random`` shuffles the joints."""
        habits, names = self._habits, self.names
        positions, velocities = q[self.model.arm_q], v[self.model.arm]
        if habits.quantum:
            positions = habits.quantum * np.round(positions / habits.quantum)
        if habits.reorder:
            names = [*names, *_STRANGERS]
            order = random.permutation(len(names))
            names = [names[i] for i in order]
            positions = np.append(positions, [0.01, 0.02])[order]
            velocities = np.append(velocities, [0.0, 0.0])[order]
        sent = velocities.tolist() if habits.velocities else []
        return JointSample(names, positions.tolist(), sent, time, 0.0)

    def platform(self, q: Vector, v: Vector, time: float) -> BaseSample | None:
        """Return what the wheels say at q (nq,), v (n,), wrong by a share of the way since then."""
        if self._base is None:
            return None
        pose = q[self.model.base_q]
        moved = composed(inverse(self._before), pose)  # in the axes of the platform
        self.odometry = composed(self.odometry, (1.0 + self._habits.drift) * moved)
        self._before = pose.copy()
        x, y, yaw = self.odometry.tolist()
        twist = v[self.model.base]
        if self.model.differential:
            twist = np.array([twist[0], 0.0, twist[1]])
        else:
            twist = turned(twist, -float(pose[2]))
        turn = (0.0, 0.0, sin(0.5 * yaw), cos(0.5 * yaw))
        return BaseSample(x, y, turn, twist.tolist(), time, 0.0, "odom")

    def _consumer(self, q: Vector) -> ArmConsumer:
        """Return a controller that holds a position, shape (m,)."""
        if self._kind == "joint_trajectory":
            return TrajectoryConsumer(q)
        kind = VelocityConsumer if self._kind == "velocity" else PositionConsumer
        return kind(q, self._period)  # of torques: what holds the arm before the first

    def _parts(self, start: float, steps: int, commands: Sequence[Command]) -> Iterator[slice]:
        """Yield the steps between two commands, each command taken before those that follow it."""
        done = 0
        for command in commands:
            step = max(0, ceil((command.at - start) / PERIOD - _SAME))
            if step > done:
                yield slice(done, step)
                done = step
            self._take(command, start + PERIOD * step)
        yield slice(done, steps)

    def _take(self, command: Command, now: float) -> None:
        """Hand a command to its controller at ``now`` [s]."""
        if command.what == "base":
            if self._base is not None:
                self._base.take(
                    command.value[_DRIVEN] if self.model.differential else command.value, now
                )
        elif self._kind != "effort":
            self._arm.take(command.value, now)
        elif not self.drive.stopped:
            self._torques = command.value


def _in_world(twists: Matrix, yaw: float) -> Matrix:
    """Return twists (k, 3) along the world's axes, of steps at whose begin the yaw is ``yaw``."""
    if not len(twists.T):
        return twists
    turn = yaw + PERIOD * (np.cumsum(twists[:, 2]) - twists[:, 2])
    c, s = np.cos(turn), np.sin(turn)
    x, y = twists[:, 0], twists[:, 1]
    return np.stack([c * x - s * y, s * x + c * y, twists[:, 2]], axis=1)
