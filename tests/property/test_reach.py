"""Targets out of reach: at rest, as near as can be, and back; within reach as without damping."""

import numpy as np
import pytest

from lexstack.hqp import Damper, HqpProblem, make_solver
from lexstack.limits import viable_bounds
from lexstack.references import References
from lexstack.robots import Pose
from lexstack.tasks import build_stack
from lexstack_experiments.experiments.reach_cases import Case, out_of_reach, stack_of, within_reach
from lexstack_experiments.experiments.reach_runs import run
from support.scenario import home, resolved, state_at, team

pytestmark = pytest.mark.slow

SINGLE = ("free", "free position", "held", "held position", "two robots", "posture", "base below")
SEED = 20_261
EXCESS = 1e-8


def drawn(kind, make=out_of_reach, number=0):
    return make(kind, np.random.default_rng([SEED, SINGLE.index(kind), number]), team(), home())


@pytest.mark.parametrize("kind", SINGLE)
def test_out_of_reach_the_robots_come_to_rest_as_near_as_can_be(kind):
    motion = run(resolved(), drawn(kind), "lexstack", 16.0)
    assert motion.rest_after() <= 10.0
    assert motion.sign_changes(6.0) == 0.0
    assert motion.excess() <= 1e-6
    assert all(command.fallback == "" for command in motion.commands)
    assert all(command.undamped == "" for command in motion.commands)
    steps = np.abs(np.diff(motion.chi, axis=0))
    assert (steps / (motion.team.dt * motion.team.limits.acceleration)).max() <= 1.0 + 1e-9
    assert motion.commands[-1].near[0].rows > 0
    assert "near a singularity" in motion.commands[-1].transition.reason


@pytest.mark.parametrize("beyond", [1e-4, 0.05])
def test_a_hair_out_of_reach_is_out_of_reach(beyond):
    motion = run(resolved(), straight_up(beyond), "lexstack", 10.0)
    assert motion.rest_after() is not None
    assert motion.excess() <= 1e-6


def test_with_jerk_limits_the_robots_come_to_rest_too():
    motion = run(resolved(), drawn("held position"), "lexstack", 10.0, jerk=True)
    assert motion.rest_after() is not None


@pytest.mark.parametrize("kind", ["free", "held", "base below"])
def test_a_target_within_reach_is_reached_as_fast_as_without_damping(kind):
    for number in range(2):
        case = drawn(kind, within_reach, number)
        ours, before = (run(resolved(), case, law, 8.0) for law in ("lexstack", "undamped"))
        if before.reached_after() is None:
            continue
        assert ours.reached_after() is not None
        assert ours.reached_after() <= 1.1 * before.reached_after()


@pytest.mark.parametrize("kind", ["free", "held position", "posture"])
def test_back_within_reach_the_robots_are_there_within_6_s(kind):
    motion = run(resolved(), drawn(kind), "lexstack", 6.0, back=6.0)
    tools = motion.team.tools(motion.q[-1])
    starts = motion.team.tools(motion.q[0])
    for tool, start in zip(tools, starts, strict=True):
        assert np.linalg.norm(tool.position - start.position) <= 1e-3


@pytest.mark.parametrize("kind", ["held", "base below", "posture"])
def test_levels_that_are_not_told_are_as_strict_as_ever(kind):
    """Down to the first level that is told, damping changes no slack."""
    stack, damper = build_stack(stack_of(kind), team()), Damper(team(), team().dt)
    solver, limits, rng = make_solver(), team().limits, np.random.default_rng(SEED)
    compared = 0
    for _ in range(60):
        q = home() + rng.normal(scale=0.5, size=team().n)
        q = np.clip(q, limits.position_lower, limits.position_upper)
        chi = rng.uniform(-0.2, 0.2, team().n) * limits.velocity
        kinematics = team().kinematics(state_at(q, chi))
        aims = tuple(
            Pose(tool.position + rng.normal(scale=1.0, size=3), tool.rotation)
            for tool in kinematics.tools
        )
        bases = tuple(q[part][:3] + rng.normal(size=3) for part in team().slices)
        given = HqpProblem(
            stack.linearise(kinematics, References(aims, bases)),
            viable_bounds(q, limits, team().dt, chi),
        )
        damped = damper.damped(given, kinematics, limits)
        plain, ours = solver.solve(given), damped.own(solver.solve(damped.problem))
        first = min((near.level for near in ours.near if near.rows), default=len(given.levels))
        assert np.abs(ours.slacks[:first] - plain.slacks[:first]).max(initial=0.0) <= EXCESS
        assert all(near.sigma < 0.15 for near in ours.near)
        compared += first
    assert compared > 60


def straight_up(beyond):
    """Return a target for the tool that many metres above the highest point it comes to."""
    q = home()[:10].copy()
    q[3:] = [0.0, -0.25537627, 0.0, -0.46700247, 0.0, 3.03484281, 0.0]
    best = team().robots[0].tool(q)[0]
    aim = best.position + np.array([0.0, 0.0, beyond])
    return Case("free position", beyond, (Pose(aim, best.rotation),), (home()[:3].copy(),))
