"""Closed loops through stretched arms and out of reach: solved, inside the box, strict, bounded.

Two mobile manipulators whose bases a higher level holds are sent where their arms do not reach,
and back. There level 2 wants joint velocities without limit.
"""

import numpy as np
import pytest

from lexstack.hqp import HqpProblem, make_solver
from lexstack.limits import JointLimits, viable_bounds
from lexstack.references import References
from lexstack.robots import Pose
from lexstack.tasks import LevelConfig, StackConfig, TaskConfig, build_stack
from lexstack_experiments.hierarchies.certificate import certified_excess
from support.scenario import home, state_at, team

TICKS = 500
EXCESS = 1e-8
STACKS = {
    "position": ("base", "ee_position", "velocity_damping"),
    "pose": ("base", "ee_pose", "posture", "velocity_damping"),
    "pose above base": ("ee_pose", "base", "velocity_damping"),
}


def stack_of(name):
    levels = tuple(LevelConfig((TaskConfig(kind),)) for kind in STACKS[name])
    return build_stack(StackConfig(name, "", levels), team())


def references(seconds, tools):
    """Return targets that swing 1.5 m to the side and back in 4 s."""
    away = 1.5 * np.sin(0.5 * np.pi * seconds / 2.0) ** 2
    sides = (1.0, -1.0)
    poses = [
        Pose(tool.position + np.array([0.0, side * away, 0.3 * away]), tool.rotation)
        for tool, side in zip(tools, sides, strict=True)
    ]
    return References(tuple(poses), tuple(home()[part][:3].copy() for part in team().slices))


def run(name, limits, with_jerk):
    """Return chi of all ticks, the largest certified excess, and the least singular value."""
    stack, solver, dt = stack_of(name), make_solver(), team().dt
    q, chi, before = home(), np.zeros(team().n), np.zeros(team().n)
    tools, solution = team().tools(q), None
    moved, excess, least = [], 0.0, np.inf
    for tick in range(TICKS):
        kinematics = team().kinematics(state_at(q, chi, tick))
        acceleration = (chi - before) / dt if with_jerk else None
        box = viable_bounds(q, limits, dt, chi, acceleration=acceleration)
        levels = stack.linearise(kinematics, references(tick * dt, tools))
        given = HqpProblem(levels, box)
        solution = solver.solve(given, solution)
        assert solution.solved, (tick, solution.reason)
        assert solution.note == "", tick
        assert np.all((solution.chi >= box.lower) & (solution.chi <= box.upper)), tick
        if tick % 10 == 0:
            excess = max(excess, *certified_excess(given, solution.chi))
        arm = kinematics.jacobians[0][:3, 3:]
        least = min(least, float(np.linalg.svd(arm, compute_uv=False).min()))
        before, chi = chi, solution.chi
        q = q + dt * chi
        moved.append(chi)
    return np.array(moved), excess, least


@pytest.mark.parametrize("name", STACKS)
def test_out_of_reach_and_back_every_tick_is_solved_and_jerk_stays_below_what_the_box_allows(name):
    limits, dt = team().limits, team().dt
    moved, excess, least = run(name, limits, with_jerk=False)
    assert excess <= EXCESS
    assert name != "position" or least < 0.05  # the arm was stretched
    steps = np.diff(moved, axis=0)
    assert np.abs(steps / (dt * limits.acceleration)).max() <= 1.0 + 1e-9
    jerk = np.abs(np.diff(steps, axis=0)) / dt**2
    assert np.all(jerk <= 2.0 * limits.acceleration / dt * (1.0 + 1e-9))


@pytest.mark.parametrize("name", STACKS)
def test_with_jerk_limits_the_command_keeps_them_through_the_singularity(name):
    own, dt = team().limits, team().dt
    bound = own.acceleration * 20.0  # 1/s: a twentieth of a second to full acceleration
    limits = JointLimits(
        own.position_lower, own.position_upper, own.velocity, own.acceleration, bound
    )
    moved, excess, _ = run(name, limits, with_jerk=True)
    assert excess <= EXCESS
    steps = np.diff(moved, axis=0)
    assert np.abs(steps / (dt * limits.acceleration)).max() <= 1.0 + 1e-9
    jerk = np.abs(np.diff(steps, axis=0)) / dt**2
    assert np.all(jerk <= bound * (1.0 + 1e-6))
