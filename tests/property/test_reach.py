"""Targets out of reach: at rest, as near as can be, and back; within reach as without damping."""

import numpy as np
import pytest

from lexstack.hqp import Damper, HqpProblem, make_solver
from lexstack.limits import viable_bounds
from lexstack.references import References, Target
from lexstack.robots import Pose
from lexstack.tasks import build_stack
from lexstack_config.parts import Parts, build_controller
from lexstack_experiments.experiments.reach_cases import (
    KINDS,
    Case,
    out_of_reach,
    scenario,
    stack_of,
    straight_up,
    within_reach,
)
from lexstack_experiments.experiments.reach_runs import LAWS, run
from lexstack_experiments.ideal import IdealPlant
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


@pytest.mark.parametrize(
    ("kind", "seed", "number"),
    [
        pytest.param(
            "held", 7, 3, id="joint pressed by the error as it is, not as it is shortened"
        ),
        pytest.param("held", 7, 13, id="valley with a joint at its limit"),
        pytest.param("held", 7, 18, id="valley that no joint limits"),
        pytest.param("two robots", 11, 4, id="valley that the model sees as a part of others"),
        pytest.param("relative", 7, 11, id="tools that turn with both robots"),
    ],
)
def test_along_a_valley_of_the_error_the_robots_do_not_creep(kind, seed, number):
    """All of these crept or swung at 10 s, 1e-6 to 1e-3 m^2 above the least error."""
    rng = np.random.default_rng([seed, list(KINDS).index(kind), number])
    motion = run(resolved(), out_of_reach(kind, rng, team(), home()), "lexstack", 10.0)
    assert motion.rest_after() is not None
    assert motion.sign_changes(1.0) == 0.0
    assert motion.excess() <= 1e-6


@pytest.mark.parametrize("number", range(2))
def test_two_levels_out_of_reach_stay_within_the_limits_and_are_told(number):
    rng = np.random.default_rng([SEED, 100, number])
    motion = run(resolved(), out_of_reach("nested", rng, team(), home()), "lexstack", 10.0)
    steps = np.abs(np.diff(motion.chi, axis=0))
    assert (steps / (motion.team.dt * motion.team.limits.acceleration)).max() <= 1.0 + 1e-9
    assert all(command.fallback == "" for command in motion.commands)
    assert all(command.undamped == "" for command in motion.commands)
    assert {near.level for near in motion.commands[-1].near} == {1, 2}


@pytest.mark.parametrize("beyond", [1e-4, 0.05])
def test_a_hair_out_of_reach_is_out_of_reach(beyond):
    motion = run(resolved(), straight_up(beyond, team(), home()), "lexstack", 10.0)
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


@pytest.mark.parametrize("kind", ["base below", "posture", "free position"])
def test_a_figure_of_eight_within_reach_is_the_same_to_the_bit(kind):
    start = team().tools(home())[0]
    case = Case(kind, -1.0, (start,), (home()[:3].copy(),))
    small = scenario(resolved(), case)
    runs = []
    for law in ("undamped", "lexstack"):
        parts = Parts.of(small)
        controller = build_controller(small, parts, damper=LAWS[law](parts.team, parts.dt))
        plant, chi = IdealPlant(small, parts.team), []
        for tick in range(600):
            turn = 2.0 * np.pi * tick / 400.0
            aside = np.array([0.0, 0.2 * np.sin(turn), 0.1 * np.sin(2.0 * turn)])
            aim = Pose(start.position + aside, start.rotation)
            controller.references.add(Target(tick * parts.dt, 0, ee=aim))
            chi.append(controller.tick(plant.state()).chi)
            plant.step(chi[-1])
        runs.append(np.array(chi))
    np.testing.assert_array_equal(*runs)
    assert np.abs(runs[0]).max() > 0.1
