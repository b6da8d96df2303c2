"""How pink and mink reach: weighted inverse kinematics by one QP for each period.

Both get the model, the limits and the period of ours, and what their documentation shows: a
``FrameTask`` and a ``PostureTask``, and the limits that they have. mink has none of acceleration.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from typing import Any

import mujoco
import numpy as np
import pinocchio

from lexstack.robots import Pose, Team, inverse_kinematics
from lexstack.types import Vector
from lexstack_sim.world import wxyz


@dataclass(frozen=True, slots=True)
class Weighted:
    """How they are used; the defaults are those of their documentation.

    Attributes:
        gain: of the task that reaches, share of the error per period.
        lm_damping: of the same.
        posture: cost of the posture task beside costs of 1.
        accelerations: whether accelerations are limited too (pink).
        joints: whether the posture of ``inverse_kinematics`` is the only task (pink).
    """

    gain: float = 1.0
    lm_damping: float = 0.0
    posture: float = 1e-3
    accelerations: bool = False
    joints: bool = False


class Pink:
    """pink's ``solve_ik`` on the very pinocchio model that ours uses.

    Attributes:
        team: the arm.
        failures: how many problems had no solution; the command was zero then.
    """

    def __init__(self, team: Team, options: Weighted) -> None:
        """Build configuration, tasks and limits; raises ImportError where it is not installed."""
        self._pink = import_module("pink")
        tasks, kinds = import_module("pink.tasks"), import_module("pink.limits")
        self.team, self.failures, self._options = team, 0, options
        model, limits = team.robots[0].pinocchio.copy(), team.limits
        model.lowerPositionLimit = limits.position_lower
        model.upperPositionLimit = limits.position_upper
        model.velocityLimit = limits.velocity
        self._configuration = self._pink.Configuration(
            model, model.createData(), pinocchio.neutral(model)
        )
        self._frame = tasks.FrameTask("tool", 1.0, 1.0, options.lm_damping, options.gain)
        self._posture = tasks.PostureTask(
            1.0 if options.joints else options.posture, gain=options.gain if options.joints else 1.0
        )
        self._posture.set_target(team.robots[0].posture)
        self._tasks = [self._posture] if options.joints else [self._frame, self._posture]
        self._limits = [kinds.ConfigurationLimit(model), kinds.VelocityLimit(model)]
        self._accelerations: Any = None
        if options.accelerations:
            self._accelerations = kinds.AccelerationLimit(model, limits.acceleration)
            self._limits.append(self._accelerations)

    def begin(self, start: Vector, goal: Pose) -> None:
        """Set the target."""
        self._frame.set_target(pinocchio.SE3(goal.rotation, goal.position))
        if self._options.joints:
            end = inverse_kinematics(self.team.robots[0], goal, start)
            self._posture.set_target(start if end is None else end)

    def velocity(self, q: Vector, last: Vector) -> Vector:
        """Return what ``solve_ik`` does; rest where it finds nothing."""
        self._configuration.update(q)
        if self._accelerations is not None:
            self._accelerations.set_last_integration(last, self.team.dt)
        try:
            with np.errstate(invalid="ignore"):  # a joint outside its limits: root of a negative
                found = self._pink.solve_ik(
                    self._configuration,
                    self._tasks,
                    self.team.dt,
                    "daqp",
                    limits=self._limits,
                    safety_break=False,
                )
        except self._pink.exceptions.PinkError:
            self.failures += 1
            return np.zeros_like(q)
        return np.asarray(found)


class Mink:
    """mink's ``solve_ik`` on the same chain of joints as a MuJoCo model.

    Attributes:
        team: the arm.
        failures: how many problems had no solution; the command was zero then.
    """

    def __init__(self, team: Team, options: Weighted) -> None:
        """Build configuration, tasks and limits; raises ImportError where it is not installed."""
        self._mink = mink = import_module("mink")
        self.team, self.failures = team, 0
        robot, model = team.robots[0], chain(team)
        self._configuration = mink.Configuration(model)
        self._frame = mink.FrameTask("tool", "site", 1.0, 1.0, options.gain, options.lm_damping)
        posture = mink.PostureTask(model, cost=options.posture)
        posture.set_target(robot.posture)
        self._tasks = [self._frame, posture]
        velocities = dict(zip(robot.joints, team.limits.velocity.tolist(), strict=True))
        self._limits = [mink.ConfigurationLimit(model), mink.VelocityLimit(model, velocities)]

    def begin(self, start: Vector, goal: Pose) -> None:
        """Set the target."""
        del start
        turn = self._mink.SO3.from_matrix(goal.rotation)
        self._frame.set_target(self._mink.SE3.from_rotation_and_translation(turn, goal.position))

    def velocity(self, q: Vector, last: Vector) -> Vector:
        """Return what ``solve_ik`` does; rest where it finds nothing."""
        del last
        self._configuration.update(q)
        try:
            found = self._mink.solve_ik(
                self._configuration, self._tasks, self.team.dt, "daqp", limits=self._limits
            )
        except self._mink.exceptions.MinkError:
            self.failures += 1
            return np.zeros_like(q)
        return np.asarray(found)


def chain(team: Team) -> mujoco.MjModel:
    """Return the only robot of a team as a MuJoCo model: joints, limits and a site ``tool``."""
    robot, limits, spec = team.robots[0], team.limits, mujoco.MjSpec()
    spec.compiler.degree = False
    model, body = robot.pinocchio, spec.worldbody
    data = model.createData()
    jacobians = pinocchio.computeJointJacobians(model, data, np.zeros(model.nq))
    for k, name in enumerate(robot.joints):
        place = model.jointPlacements[k + 1]
        body = body.add_body(pos=place.translation, quat=wxyz(place.rotation))
        body.explicitinertial, body.mass, body.inertia = True, 1.0, np.ones(3)
        body.add_joint(
            name=name,
            axis=data.oMi[k + 1].rotation.T @ jacobians[3:, k],
            range=(limits.position_lower[k], limits.position_upper[k]),
            limited=mujoco.mjtLimited.mjLIMITED_TRUE,
        )
    place = model.frames[robot.frame("tool")].placement
    body.add_site(name="tool", pos=place.translation, quat=wxyz(place.rotation))
    return spec.compile()
