"""Robots that follow their messages exactly, behind the adapter, without ROS and MuJoCo."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from lexstack.control import ExactPlant
from lexstack_config.plant_file import load_plant
from lexstack_plant.hardware.base_intake import BaseSample, turned
from lexstack_plant.hardware.joint_intake import JointSample
from lexstack_plant.hardware.plant import HardwarePlant
from support.scenario import CONFIG, resolved, team

__all__ = ["ExactPlant", "IdealHardware"]
PLANT = Path(CONFIG) / "plants" / "two_pandas.yaml"


class IdealHardware:
    """The adapter of the default scenario's robots, which are at home.

    Attributes:
        now: s, the time of both.
        sent: what was sent in the last tick, by robot.
        q: where the robots are, shape (n,).
        silent: robots whose states do not come any more.
        stuck: robots that do not move.
    """

    def __init__(self, plant=None):
        self.now = 50.0
        self.sent = {}
        self.silent, self.stuck = set(), set()
        self.team = team()
        scenario = resolved().scenario
        places = {name: place.base for name, place in scenario.robots.items()}
        self.q = self.team.home(places)
        self.v = np.zeros(self.team.n)
        self.plant = HardwarePlant(
            resolved(), self.team, plant or load_plant(PLANT), self._send, lambda: self.now
        )
        self.dt = self.plant.period

    def _send(self, name, command):
        self.sent[name] = command

    def hear(self):
        """Tell the adapter where the robots are, in the world's frame."""
        for model, part in zip(self.team.robots, self.team.slices, strict=True):
            if model.name in self.silent:
                continue
            robot, q, v = self.plant.robots[model.name], self.q[part], self.v[part]
            names, arm = list(model.joints[model.arm]), model.arm
            robot.joints.hear(
                JointSample(names, q[arm].tolist(), v[arm].tolist(), self.now, self.now)
            )
            x, y, yaw = q[:3].tolist()
            turn = (0.0, 0.0, np.sin(yaw / 2), np.cos(yaw / 2))
            twist = turned(v[:3], -yaw).tolist()
            robot.base.hear(BaseSample(x, y, turn, twist, self.now, self.now))

    def enable(self):
        """Enable all robots where they are."""
        self.hear()
        for name in self.team.names:
            self.plant.enable(name)
        return self.plant.state()

    def step(self, chi=None, periods=1.0):
        """Let a period pass, in which the robots do what they were sent; send the next command."""
        self.now += periods * self.dt
        for model, part in zip(self.team.robots, self.team.slices, strict=True):
            command = self.sent.get(model.name)
            if command is None or model.name in self.stuck:
                self.v[part] = 0.0
                continue
            q, v = self.q[part], self.v[part]
            q[model.arm] = command.points[0].position
            v[model.arm] = command.points[0].velocity
            v[:3] = turned(command.twist, float(q[2]))
            q[:3] += self.dt * v[:3]
        self.hear()
        return self.plant.step(chi, self.now)
