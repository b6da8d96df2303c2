"""Stacks that change limits, in the closed loop: promises (i) and (ii), whatever is asked when.

Random starts, stacks with random limits, trigger times, pre-emptions, cancels, and a solver that
falls silent.
"""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from lexstack.limits import LimitOptions, LimitsInForce
from lexstack.tasks import JointLimitConfig
from lexstack.transition import TransitionConfig
from lexstack_config.parts import Parts, build_controller
from lexstack_experiments.experiments.sudden_limits_runs import Watched
from lexstack_experiments.ideal import IdealPlant
from lexstack_experiments.loop import Loop
from support.scenario import changed, home, resolved, team

STACKS = ("track", "reach_base", "posture")
TICKS = 90
KEPT = 1e-9
ARMS = np.flatnonzero(np.isfinite(team().limits.position_lower))
RUNS = st.fixed_dictionaries(
    {
        "seed": st.integers(0, 10_000),
        "jerk": st.booleans(),
        "move": st.sampled_from([0.0, 0.0, 0.2]),
        "duration": st.sampled_from([0.05, 0.3]),
        "switches": st.lists(
            st.tuples(st.integers(1, TICKS - 30), st.sampled_from((*STACKS, "tight", "slow"))),
            min_size=1,
            max_size=4,
        ),
        "cancel": st.sampled_from([0, 0, 25]),
        "lost_from": st.sampled_from([10_000, 25]),
    }
)


def tight_joints(rng, names=("position", "velocity", "acceleration")):
    """Return tighter limits for random arm joints of both robots."""
    limits = {}
    for robot, part in zip(team().robots, team().slices, strict=True):
        limits[robot.name] = {}
        for k in rng.choice(np.arange(3, robot.n), 3, replace=False):
            own, i = team().limits, part.start + k
            lower, upper = own.position_lower[i], own.position_upper[i]
            ends = np.sort(rng.uniform(lower, upper, 2))
            middle, half = ends.mean(), max(ends[1] - ends[0], 0.4) / 2
            position = (float(max(middle - half, lower)), float(min(middle + half, upper)))
            values = {
                "position": position,
                "velocity": float(rng.uniform(0.3, 1.0) * own.velocity[i]),
                "acceleration": float(rng.uniform(0.2, 1.0) * own.acceleration[i]),
                "jerk": float(own.acceleration[i] * rng.uniform(10.0, 100.0)),
            }
            kept = {name: value for name, value in values.items() if name in names}
            limits[robot.name][robot.joints[k]] = JointLimitConfig(**kept)
    return limits


def closed_loop(run):
    """Return the closed loop of one random run, and the law that it keeps limits by."""
    rng = np.random.default_rng(run["seed"])
    stacks = dict(resolved().stacks)
    stacks["tight"] = replace(stacks["track"], name="tight", limits=tight_joints(rng))
    slow = tight_joints(rng, ("velocity", "acceleration", "jerk"))
    stacks["slow"] = replace(stacks["posture"], name="slow", limits=slow)
    transition = TransitionConfig(duration=run["duration"], limits_move=run["move"])
    scenario = replace(
        changed(initial_stack="track", events=(), transition=transition, limit_jerk=run["jerk"]),
        stacks=stacks,
    )
    parts = Parts.of(scenario)
    options = LimitOptions(parts.dt, jerk=run["jerk"], duration=run["move"])
    law = Watched(LimitsInForce(parts.team.limits, options))
    plant = IdealPlant(scenario, parts.team)
    q = home() + rng.uniform(-0.4, 0.4, team().n)
    own = team().limits
    inside = 0.2 * (own.position_upper[ARMS] - own.position_lower[ARMS])
    q[ARMS] = np.clip(q[ARMS], own.position_lower[ARMS] + inside, own.position_upper[ARMS] - inside)
    plant.put(q, rng.uniform(-0.1, 0.1, team().n))
    loop = Loop(scenario, plant, build_controller(scenario, parts, box=law))
    loop.solver_answers = lambda tick: tick < run["lost_from"]
    for tick, stack in run["switches"]:
        loop.controller.transition.ask(stack, 0.0, "", tick)
    return loop, law


def out_of(q, limits):
    """Return how far outside its position limits each joint is, negative inside."""
    return np.maximum(q - limits.position_upper, limits.position_lower - q)


@settings(max_examples=30, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(RUNS)
def test_feasible_and_within_the_limits_in_force_at_every_tick(run):
    loop, law = closed_loop(run)
    own, dt = team().limits, loop.parts.dt
    before, a = loop.plant.state().command, np.zeros(team().n)
    for tick in range(TICKS):
        if tick == run["cancel"] > 0:
            loop.controller.transition.cancel()
        command = loop.step()
        limits = law.limits[-1]
        assert command.bounds.empty == 0
        assert command.fallback == ""
        assert np.all(limits.acceleration <= own.acceleration)
        change = np.abs(command.chi - before)
        assert np.all(change <= limits.acceleration * dt * (1.0 + KEPT) + 1e-14)
        assert np.all(np.abs(command.chi) <= own.velocity + KEPT)
        now = (command.chi - before) / dt
        if run["jerk"] and tick > 0:
            assert np.all(np.abs(now - a) <= own.jerk * dt * (1.0 + 1e-6) + 1e-9)
        before, a = command.chi, now
        assert np.all(out_of(loop.plant.state().q, own) <= KEPT)


@settings(max_examples=12, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(RUNS)
def test_in_the_end_all_joints_keep_the_limits_of_the_last_stack(run):
    loop, law = closed_loop(run)
    for _ in range(TICKS + 300):
        command = loop.step()
    wanted = loop.parts.stacks[command.stack.removesuffix(" at rest")].limits or team().limits
    for name in ("position_lower", "position_upper", "velocity", "acceleration"):
        np.testing.assert_array_equal(getattr(law.limits[-1], name), getattr(wanted, name))
    assert np.all(out_of(loop.plant.state().q, wanted) <= 1e-6)
    assert np.all(np.abs(command.chi) <= wanted.velocity + KEPT)


@settings(max_examples=10, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(RUNS)
def test_robot_b_takes_the_limits_of_the_new_stack_at_once(run):
    loop, _ = closed_loop(run)
    for _ in range(TICKS):
        command = loop.step()
        chi = loop.record.sources.get(command.tick)
        if chi is None or command.stack not in loop.parts.stacks:
            continue
        limits = loop.parts.stacks[command.stack].limits or team().limits
        assert np.all(np.abs(chi) <= limits.velocity + 1e-6)
        q, dt = loop.record.states[-1].q_star, loop.parts.dt
        further = np.maximum(out_of(q + dt * chi, limits), 0.0)
        assert np.all(further <= np.maximum(out_of(q, limits), 0.0) + 1e-6)


@pytest.mark.parametrize("fault", ["new limits at once", "old limits for ever"])
def test_the_tests_above_can_fail(fault, monkeypatch):
    run = {
        "seed": 3,
        "jerk": False,
        "move": 0.0,
        "duration": 0.3,
        "switches": [(5, "tight")],
        "cancel": 0,
        "lost_from": 10_000,
    }
    if fault == "new limits at once":
        monkeypatch.setattr(
            "lexstack.limits.limits_in_force.viable_bounds",
            lambda q, limits, dt, v, *_: loop_box(q, limits, dt, v),
        )
        test = test_feasible_and_within_the_limits_in_force_at_every_tick
    else:
        made = LimitsInForce.at
        monkeypatch.setattr(
            LimitsInForce,
            "at",
            lambda self, state, wanted, *args, **kwargs: made(
                self, state, team().limits, *args, **kwargs
            ),
        )
        test = test_in_the_end_all_joints_keep_the_limits_of_the_last_stack
    with pytest.raises(AssertionError):
        test.hypothesis.inner_test(run)


def loop_box(q, limits, dt, v):
    """Return T(31): empty where a limit excludes the configuration."""
    from lexstack_experiments.baselines.bounds import t31

    return t31(q, limits, dt, v)
