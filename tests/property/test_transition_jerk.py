"""Promise (iii) where jerk limits are on: the command is continuous, its acceleration too.

Over random starts, stacks, trigger times and pre-emptions in mid-blend; by the method bridge_jerk,
and with jerk limited at every tick. Random jerk limits, as the robots' own act within one tick.
"""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from lexstack.limits import LimitsInForce, is_viable
from lexstack.transition import Source, TransitionConfig
from lexstack_experiments.ideal import IdealPlant
from lexstack_experiments.loop import Loop
from support.scenario import changed, home, team

STACKS = ("track", "reach_base", "posture")
TICKS = 70
KEPT = 1e-6
ARMS = np.flatnonzero(np.isfinite(team().limits.position_lower))
RUNS = st.fixed_dictionaries(
    {
        "seed": st.integers(0, 10_000),
        "always": st.booleans(),
        "initial_stack": st.sampled_from(STACKS),
        "profile": st.sampled_from(["quintic", "linear", "time_optimal"]),
        "duration": st.sampled_from([0.05, 0.2, 1.0]),
        "switches": st.lists(
            st.tuples(st.integers(2, TICKS - 10), st.sampled_from(STACKS)), min_size=1, max_size=5
        ),
        "lost_from": st.sampled_from([10_000, 25]),
    }
)


def soft(scenario, rng):
    """Return the scenario with robots whose acceleration takes 30 to 200 ms to build up."""

    def softer(part):
        return replace(part, jerk=tuple(a * rng.uniform(5.0, 30.0) for a in part.acceleration))

    robots = {
        name: replace(robot, base=softer(robot.base), arm=softer(robot.arm))
        for name, robot in scenario.robots.items()
    }
    return replace(scenario, robots=robots)


def closed_loop(run):
    """Return the closed loop of one random run, its start at rest."""
    rng = np.random.default_rng(run["seed"])
    method = "bridge" if run["always"] else "bridge_jerk"
    transition = TransitionConfig(duration=run["duration"], method=method, profile=run["profile"])
    scenario = soft(
        changed(
            initial_stack=run["initial_stack"],
            events=(),
            transition=transition,
            limit_jerk=run["always"],
        ),
        rng,
    )
    own = team().limits
    q = home() + rng.uniform(-0.4, 0.4, team().n)
    inside = 0.2 * (own.position_upper[ARMS] - own.position_lower[ARMS])
    q[ARMS] = np.clip(q[ARMS], own.position_lower[ARMS] + inside, own.position_upper[ARMS] - inside)
    plant = IdealPlant(scenario, team())
    plant.put(q, np.zeros(team().n))
    loop = Loop(scenario, plant)
    loop.solver_answers = lambda tick: tick < run["lost_from"]
    for tick, stack in run["switches"]:
        loop.controller.transition.ask(stack, 0.0, "", tick)
    return loop


def steps(loop):
    """Yield each command with the state before it: q*, command, acceleration."""
    dt, a = loop.parts.dt, np.zeros(team().n)
    for _ in range(TICKS):
        state = loop.plant.state()
        command = loop.step()
        yield command, state.q_star, state.command, a
        a = (command.chi - state.command) / dt


@settings(max_examples=40, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(RUNS)
def test_the_acceleration_of_the_command_is_continuous(run):
    """|da| <= jerk dt at every tick at which jerk is limited: triggers and pre-emptions included.

    Where jerk limits come into force at a trigger, a joint that could not keep its other limits
    with them may go on without, as ``LimitsInForce`` says; all others keep them from there on.
    """
    loop = closed_loop(run)
    limits, dt = loop.parts.team.limits, loop.parts.dt
    on, under = run["always"], np.full(team().n, run["always"])
    for command, q, v, a in steps(loop):
        blending = command.transition.source is not Source.NONE
        now = on or blending
        viable = is_viable(q, limits, dt, v, a)
        under = (under | viable) & now
        assert command.bounds.empty == 0
        assert command.fallback == ""
        change = np.abs((command.chi - v) / dt - a)
        assert np.all((change <= limits.jerk * dt * (1.0 + KEPT) + 1e-9)[under])
        assert np.all(np.abs(command.chi - v) <= limits.acceleration * dt * (1.0 + KEPT))
        assert np.all(np.abs(command.chi) <= limits.velocity + KEPT)
    q = loop.plant.state().q
    assert np.all(q >= limits.position_lower - 1e-9)
    assert np.all(q <= limits.position_upper + 1e-9)


@settings(max_examples=15, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(RUNS.map(lambda run: {**run, "always": True}))
def test_where_jerk_is_always_limited_every_state_is_viable(run):
    loop = closed_loop(run)
    for command, q, v, a in steps(loop):
        assert np.all(is_viable(q, loop.parts.team.limits, loop.parts.dt, v, a)), command.tick


@pytest.mark.parametrize("fault", ["no jerk limit", "the acceleration of before"])
def test_the_tests_above_can_fail(fault, monkeypatch):
    run = {
        "seed": 1,
        "always": True,
        "initial_stack": "track",
        "profile": "quintic",
        "duration": 0.05,
        "switches": [(20, "posture"), (24, "reach_base")],
        "lost_from": 10_000,
    }
    acceleration = LimitsInForce._acceleration
    if fault == "no jerk limit":
        monkeypatch.setattr(
            LimitsInForce,
            "_within_jerk",
            lambda self, limits, motion: replace(limits, jerk=np.full(limits.n, np.inf)),
        )
    else:
        monkeypatch.setattr(LimitsInForce, "_acceleration", lambda *args: 0.0 * acceleration(*args))
    test = test_the_acceleration_of_the_command_is_continuous
    with pytest.raises(AssertionError):
        test.hypothesis.inner_test(run)
