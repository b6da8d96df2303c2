"""The adapter and the stand-in in one process, in simulated time: a plant of closed loops."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from lexstack.robots import Team
from lexstack.types import RobotState, Vector
from lexstack_config.plant_file import PlantFile
from lexstack_config.resolved import ResolvedScenario
from lexstack_plant.hardware.joint_intake import JointSample
from lexstack_plant.hardware.outputs import RobotCommand
from lexstack_plant.hardware.plant import HardwarePlant, Phase
from lexstack_testing.stand_in.habits import Habits
from lexstack_testing.stand_in.robots import Sent, StandIn

_SETTLE = 0.1  # s, until all states have been heard


class HardwareInProcess:
    """A plant as closed loops need it: each step is a period of the stand-in.

    Attributes:
        adapter: what stands between the controllers and the robots.
        robots: the stand-in.
        commands: what was sent in the last tick, by robot.
    """

    def __init__(
        self,
        resolved: ResolvedScenario,
        team: Team,
        plant: PlantFile,
        habits: Habits,
        seed: int = 0,
        *,
        enable: bool = True,
        check: bool = True,
    ) -> None:
        """Bring both up, hear of all robots, and enable them.

        Args:
            resolved: the scenario.
            team: its robots.
            plant: where they are reached.
            habits: of the stand-in.
            seed: of everything random.
            enable: whether the robots are enabled.
            check: whether the adapter refuses commands beyond the limits.
        """
        self.now = 100.0  # s; no clock begins at zero
        self.robots = StandIn(resolved, plant, habits, self.now, seed)
        given = (resolved, team, plant, self._send, lambda: self.now)
        self.adapter = HardwarePlant(*given) if check else HardwarePlant(*given, accepted=np.inf)
        self.commands: dict[str, RobotCommand] = {}
        self._due = self.now
        self.pass_time(_SETTLE)
        if enable:
            self.enable()

    def enable(self) -> None:
        """Enable all robots; raises InputError where that cannot be."""
        for name in self.adapter.robots:
            self.adapter.enable(name)

    def state(self) -> RobotState:
        """Return the present state, as it was measured."""
        return self.adapter.look() if self.adapter.resting else self.adapter.state()

    def step(self, chi: Vector | None) -> RobotState:
        """Let a period pass, then send the command, as in realtime."""
        self.pass_time(self.adapter.period)
        if self.adapter.phase is Phase.DISABLED:
            return self.adapter.look()
        return self.adapter.step(chi)

    def pass_time(self, seconds: float) -> None:
        """Move the robots for a time [s], and hear what they measure."""
        self._due += seconds
        moved = self.now
        while moved < self._due - 1e-9:
            moved = min(self.robots.next_states, self._due)
            for sent in self.robots.advance(moved):
                self.now = max(self.now, sent.arrives)
                self._hear(sent)
        self.now = self._due

    def _hear(self, sent: Sent) -> None:
        """Hand a message to the adapter."""
        robot, sample = self.adapter.robots[sent.robot], replace(sent.sample, received=self.now)
        if isinstance(sample, JointSample):
            self.adapter.hear_joints(sent.robot, sample)
        elif robot.base is not None:
            robot.base.hear(sample)

    def _send(self, name: str, command: RobotCommand) -> None:
        """Hand a robot's commands to the stand-in."""
        self.commands[name] = command
        if command.points:
            points = [replace(point, time=command.due + point.time) for point in command.points]
            self.robots.command_arm(name, points, self.now)
        elif command.values is not None:
            self.robots.command_arm(name, np.array(command.values), self.now)
        if command.twist is not None:
            self.robots.command_base(name, command.twist, self.now)
