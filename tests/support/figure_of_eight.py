"""A tool on a figure of eight, and a run that follows it in the ideal plant."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from lexstack.control import ExactPlant, Lockstep, make_controller, make_stack_solver
from lexstack.references import ReferenceSchedule, Target
from lexstack.robots import Pose
from lexstack.tasks import StackConfig, build_stack
from lexstack.transition import TransitionConfig, TransitionOptions
from support.scenario import home, team

PERIOD = 7.5  # s, for 0.3 by 0.2 m: up to 0.21 m/s
NOD = 0.2  # rad


@dataclass(frozen=True)
class Eight:
    """0.3 m in y by 0.2 m in z about a pose, with a nod about x; never at rest."""

    centre: Pose
    start: float = 0.0
    end: float = np.inf

    def at(self, stamp):
        """Return the pose at a time."""
        phase = 2.0 * np.pi * (stamp - self.start) / PERIOD
        away = np.array([0.0, 0.15 * np.sin(phase), 0.1 * np.sin(2.0 * phase)])
        turn = pin.exp3(np.array([NOD * np.sin(phase), 0.0, 0.0]))
        return Pose(self.centre.position + away, turn @ self.centre.rotation)

    def rate(self, stamp):
        """Return the twist at a time."""
        w = 2.0 * np.pi / PERIOD
        phase = w * (stamp - self.start)
        turning = NOD * w * np.cos(phase)
        linear = [0.0, 0.15 * w * np.cos(phase), 0.2 * w * np.cos(2.0 * phase)]
        return np.array([*linear, turning, 0.0, 0.0])


def lockstep(stacks, initial, *, lead_in=0.5, waits=True):
    """Return a run of the two robots of the default scenario on stacks of one task a level.

    ``waits``: whether the controller waits for the solver's chi of every tick.
    """
    q, options = home(), TransitionOptions(initial, TransitionConfig(1.0), lockstep=waits)
    built = {
        name: build_stack(StackConfig.of_tasks(name, *levels), team())
        for name, levels in stacks.items()
    }
    references = ReferenceSchedule.at_home(team(), q, lead_in=lead_in)
    controller = make_controller(team(), built, options, references)
    plant = ExactPlant(q, team().dt)
    return Lockstep(team(), controller, make_stack_solver(team(), built), plant)


def follow(run, eight, seconds, *, at_tick=None):
    """Return the distance of robot A's tool to the eight at every tick [m], and the commands."""
    run.controller.references.add(Target(0.0, 0, ee=eight))
    distances, commands = [], []
    for k in range(int(seconds / team().dt)):
        if at_tick is not None:
            at_tick(k, run)
        state = run.plant.state()
        tool = team().kinematics(state).tools[0]
        distances.append(float(np.linalg.norm(tool.position - eight.at(state.stamp).position)))
        commands.append(run.step())
    return np.array(distances), commands
