"""Robots on differential bases, for tests."""

import dataclasses

import numpy as np

import lexstack
from lexstack.robots import DifferentialConfig
from lexstack_config.resolved import load_robot
from support.scenario import CONFIG

DT = 0.01  # s
HEIGHT = 0.5  # m, of the platform


def driven(name: str = "ur10", *, place: str = "robot") -> lexstack.RobotModel:
    """Return one of the shipped robots on a differential base, called ``place``."""
    config = load_robot(CONFIG / "robots" / f"{name}.yaml")
    mount = config.arm.mount
    if config.base is None:
        mount = dataclasses.replace(mount, xyz=(0.0, 0.0, HEIGHT))
    mass = 0.0 if config.base is not None and config.base.chassis_mass == 0.0 else 100.0
    arm = dataclasses.replace(config.arm, mount=mount)
    base = DifferentialConfig(chassis_mass=mass)
    return lexstack.RobotModel(place, dataclasses.replace(config, base=base, arm=arm))


def loop(team, stacks, first, bases=None, duration=1.0):
    """Return the controller, the plant and the lockstep of stacks, by lists of levels."""
    built = {
        name: lexstack.build_stack(lexstack.StackConfig.of_tasks(name, *levels), team)
        for name, levels in stacks.items()
    }
    options = lexstack.TransitionOptions(first, lexstack.TransitionConfig(duration=duration))
    controller = lexstack.make_controller(team, built, options)
    plant = lexstack.ExactPlant(team.home(bases), team.dt, team)
    solver = lexstack.make_stack_solver(team, built)
    return controller, plant, lexstack.control.Lockstep(team, controller, solver, plant)


def random_q(robot: lexstack.RobotModel, rng: np.random.Generator) -> np.ndarray:
    """Return a configuration within the limits of the arm; the base anywhere within 3 m."""
    lower, upper = (
        np.clip(limit[robot.arm], -6.0, 6.0)
        for limit in (robot.limits.position_lower, robot.limits.position_upper)
    )
    base = rng.uniform(-3.0, 3.0, 3) if robot.has_base else np.zeros(0)
    return np.concatenate((base, rng.uniform(lower, upper)))
