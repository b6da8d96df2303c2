"""Robots, optimisers and states for the tests of the HTMPC."""

from __future__ import annotations

import dataclasses
from functools import cache
from typing import Any

import numpy as np
import pinocchio as pin

from lexstack.mpc import Htmpc, HtmpcConfig, Objective, Start
from lexstack.robots import RobotModel
from lexstack_config.resolved import load_htmpc, load_robot
from support.scenario import CONFIG

ROBOTS = ("ur10_ridgeback", "panda_summit")


@cache
def robot(name: str = "ur10_ridgeback") -> RobotModel:
    """Return a robot."""
    return RobotModel("robot", load_robot(CONFIG / "robots" / f"{name}.yaml"))


def config(name: str = "lexstack", **changes: Any) -> HtmpcConfig:
    """Return a configuration; ``tolerance`` changes delta of the end effector [m]."""
    loaded = load_htmpc(CONFIG / "htmpc" / f"{name}.yaml")
    if "tolerance" in changes:
        changes["ee"] = dataclasses.replace(loaded.ee, tolerance=changes.pop("tolerance"))
    return dataclasses.replace(loaded, **changes)


@cache
def optimiser(which: str = "ur10_ridgeback", name: str = "lexstack", **changes: Any) -> Htmpc:
    """Return an optimiser that keeps no distances; equal arguments give the same one."""
    return Htmpc(robot(which), config(name, **changes), ())


def random_start(
    rng: np.random.Generator, which: str = "ur10_ridgeback", wild: float = 1.0
) -> Start:
    """Return a state; ``wild`` above 1 lies outside the limits now and then."""
    model = robot(which)
    limits = model.limits
    middle = model.home((0.0, 0.0, 0.0))
    q = middle + wild * rng.uniform(-1.5, 1.5, model.n)
    if wild <= 1.0:
        q = np.clip(q, limits.position_lower, limits.position_upper)
    v = rng.uniform(-wild, wild, model.n) * 0.8 * limits.velocity
    return Start(0.0, q, v)


def random_objectives(
    rng: np.random.Generator, start: Start, solver: Htmpc, far: float = 0.3
) -> tuple[Objective, Objective]:
    """Return an end-effector task over a base task, with references about ``far`` [m] away."""
    stages = solver.config.horizon
    tool = solver.robot.tool(start.q)[0].position + rng.normal(0.0, far, 3)
    base = start.q[:2] + rng.normal(0.0, 2.0 * far, 2)
    return (
        Objective("ee", "ee_position", np.tile(tool, (stages, 1))),
        Objective("base", "base_position", np.tile(base, (stages, 1))),
    )


def sphere_centers(which: str, q: np.ndarray) -> np.ndarray:
    """Return the centres of all spheres at q by pinocchio alone, shape (s, 3), m."""
    model = robot(which).pinocchio
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)
    return np.array(
        [
            data.oMf[model.getFrameId(sphere.link, pin.FrameType.BODY)].act(np.array(sphere.xyz))
            for sphere in robot(which).config.spheres
        ]
    )
