"""Robots that follow their messages exactly, behind the adapter, without ROS and MuJoCo."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from lexstack.control import ExactPlant
from lexstack.robots import arc
from lexstack_config.parts import build_team, home_of
from lexstack_config.plant_file import load_plant
from lexstack_plant.hardware.base_intake import BaseSample, turned
from lexstack_plant.hardware.joint_intake import JointSample
from lexstack_plant.hardware.plant import HardwarePlant
from support.scenario import CONFIG, resolved

__all__ = ["ExactPlant", "IdealHardware"]
PLANT = Path(CONFIG) / "plants" / "two_pandas.yaml"


class IdealHardware:
    """The adapter of a scenario's robots, which are at home; by default the two of paper T.

    It is a plant for closed loops, too: ``state`` and ``step``.

    Attributes:
        now: s, the time of both.
        sent: what was sent in the last tick, by robot.
        q: where the robots are, shape (nq,).
        v: how fast they are, shape (n,).
        silent: robots whose states do not come any more.
        stuck: robots that do not move.
    """

    def __init__(self, plant=None, given=None):
        self.now = 50.0
        self.sent = {}
        self.silent, self.stuck = set(), set()
        given = given or resolved()
        self.team = build_team(given)
        self.q = home_of(self.team, given)
        self.v = np.zeros(self.team.n)
        self.plant = HardwarePlant(
            given, self.team, plant or load_plant(PLANT), self._send, lambda: self.now
        )
        self.dt = self.plant.period
        self.state = self.plant.state

    def _send(self, name, command):
        self.sent[name] = command

    def hear(self):
        """Tell the adapter where the robots are, in the world's frame."""
        for model, at, part in self._parts():
            if model.name in self.silent:
                continue
            robot, q, v = self.plant.robots[model.name], self.q[at], self.v[part]
            names, arm = list(model.joints[model.arm]), model.arm
            robot.joints.hear(
                JointSample(names, q[model.arm_q].tolist(), v[arm].tolist(), self.now, self.now)
            )
            if robot.base is None:
                continue
            x, y, yaw = q[:3].tolist()
            turn = (0.0, 0.0, np.sin(yaw / 2), np.cos(yaw / 2))
            twist = [v[0], 0.0, v[1]] if model.differential else turned(v[:3], -yaw).tolist()
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
        for model, at, part in self._parts():
            command = self.sent.get(model.name)
            if command is None or model.name in self.stuck:
                self.v[part] = 0.0
                continue
            q, v = self.q[at], self.v[part]
            q[model.arm_q] = command.points[0].position
            v[model.arm] = command.points[0].velocity
            if model.differential:
                v[:2] = command.twist[0], command.twist[2]
                q[:3] = arc(q[:3], v[0], v[1], self.dt)
            elif command.twist is not None:
                v[:3] = turned(command.twist, float(q[2]))
                q[:3] += self.dt * v[:3]
        self.hear()
        return self.plant.step(chi, self.now)

    def _parts(self):
        """Return each robot's model, its part of q and of chi."""
        return zip(self.team.robots, self.team.q_slices, self.team.slices, strict=True)
