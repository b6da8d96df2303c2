"""What the bridge promises, over random starts, stacks, trigger times and pre-emptions.

(i) the problem is feasible at every tick; (ii) the command changes by at most its acceleration
limit; (iii) it is continuous at the trigger; (iv) level 1 is as good as an independent solver
makes it within the same bounds, wherever it is not bridged itself.
"""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.optimize import lsq_linear

from lexstack.hqp import HqpProblem
from lexstack.limits import viable_bounds
from lexstack.transition import TransitionConfig
from lexstack_experiments.ideal import IdealPlant
from lexstack_experiments.links import Delayed
from lexstack_experiments.loop import Loop
from support.scenario import changed, home, team

STACKS = ("track", "reach_base", "posture_mid_range")  # those of T
TICKS = 60
ARMS = np.flatnonzero(np.isfinite(team().limits.position_lower))

RUNS = st.fixed_dictionaries(
    {
        "seed": st.integers(0, 10_000),
        "initial_stack": st.sampled_from(STACKS),
        "duration": st.sampled_from([0.05, 0.2, 1.0]),
        "switches": st.lists(
            st.tuples(st.integers(1, TICKS - 10), st.sampled_from(STACKS)), min_size=1, max_size=4
        ),
        "lost": st.sampled_from([(10_000, 10_000), (25, 10_000), (25, 35)]),  # from, until
        "late": st.sampled_from([0, 0, 3]),  # ticks
    }
)


def start(rng):
    """Return a configuration near home, and a velocity from which the robots can still stop."""
    limits = team().limits
    q = home() + rng.uniform(-0.4, 0.4, team().n)
    inside = 0.2 * (limits.position_upper[ARMS] - limits.position_lower[ARMS])
    q[ARMS] = np.clip(
        q[ARMS], limits.position_lower[ARMS] + inside, limits.position_upper[ARMS] - inside
    )
    return q, rng.uniform(-0.1, 0.1, team().n)


def closed_loop(run):
    """Return the closed loop of one random run, ready to go."""
    scenario = changed(
        initial_stack=run["initial_stack"],
        events=(),
        transition=TransitionConfig(duration=run["duration"]),
        mode="realtime" if run["late"] else "lockstep",
    )
    plant = IdealPlant(scenario, team())
    plant.put(*start(np.random.default_rng(run["seed"])))
    loop = Loop(scenario, plant)
    lost_from, until = run["lost"]
    loop.solver_answers = lambda tick: tick < lost_from or tick >= until
    if run["late"]:
        loop.link = Delayed(run["late"])
    for tick, stack in run["switches"]:
        loop.controller.transition.ask(stack, 0.0, "", tick)
    return loop


@settings(max_examples=40, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(RUNS)
def test_feasible_and_within_acceleration_limits_at_every_tick(run):
    loop = closed_loop(run)
    before = loop.plant.state().command
    limits = team().limits
    for _ in range(TICKS):
        command = loop.step()
        assert command.bounds.empty == 0
        assert command.fallback == ""
        ratio = np.abs(command.chi - before) / (loop.parts.dt * limits.acceleration)
        assert ratio.max() <= 1.0 + 1e-9
        assert (np.abs(command.chi) <= limits.velocity + 1e-12).all()
        before = command.chi
    q = loop.plant.state().q
    assert (q >= limits.position_lower - 1e-9).all()
    assert (q <= limits.position_upper + 1e-9).all()


@settings(max_examples=25, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(RUNS)
def test_the_command_is_continuous_at_every_trigger(run):
    """Where alpha is 0 the command goes on: it changes by a small part of the gap to the source.

    What is left is the drift of level 1's own rows within one tick, not bridged where level 1
    goes on; it is bounded by how much the command changed in the tick before, and by how much that
    changes itself in a tick of the blend before: the second derivative of a quintic that fades a
    gap in T is at most 5.774 gap / T^2.
    """
    loop = closed_loop(run)
    previous = before = loop.plant.state().command
    widest = 0.0
    for _ in range(TICKS):
        command = loop.step()
        transition = command.transition
        if transition.alpha == 0.0 and transition.source.value and command.tick > 1:
            drift = np.abs(before - previous).max()
            bend = 5.774 * widest * (loop.parts.dt / run["duration"]) ** 2
            allowed = 0.02 * transition.gap + 1.2 * drift + bend + 2e-3
            assert np.abs(command.chi - before).max() <= allowed
        widest = max(widest, transition.gap)
        previous, before = before, command.chi


@settings(max_examples=25, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(
    st.integers(0, 10_000),
    st.sampled_from(STACKS),
    st.sampled_from(STACKS),
    st.integers(15, 40),
    st.sampled_from(["request", "loss", "return"]),
)
def test_the_acceleration_goes_on_through_whatever_comes_in_mid_blend(seed, one, other, tick, what):
    """By how much it changes from tick to tick is of the size that it has anyway in the blend."""
    run = {
        "seed": seed,
        "initial_stack": "track",
        "duration": 0.5,
        "switches": [(1, one), *([(tick, other)] if what == "request" else [])],
        "lost": {"request": (10_000, 10_000), "loss": (tick, 10_000), "return": (8, tick)}[what],
        "late": 0,
    }
    loop = closed_loop(run)
    loop.plant.put(loop.plant.state().q, np.zeros(team().n))
    loop.run(TICKS)
    chi = np.array([command.chi for command in loop.record.commands])
    jerk = np.abs(np.diff(chi, n=2, axis=0)) / (loop.parts.dt**2 * team().limits.jerk)
    here = jerk[tick - 3 : tick + 2].max()
    assert here <= 4.0 * jerk[3:].max(axis=1).mean() + 0.02, "a command that stood still: 0.1 to 1"
    assert loop.record.commands[tick].transition.alpha == 0.0, "latched anew"


@settings(max_examples=15, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(RUNS)
def test_level_1_is_as_good_as_the_oracle_makes_it(run):
    """All three stacks share level 1 and its references, so it is never bridged here."""
    loop = closed_loop(run)
    for _ in range(TICKS):
        state = loop.plant.state()
        command = loop.step()
        level = loop.parts.stacks[run["initial_stack"]].levels[0]
        rows = level.linearise(team().kinematics(state), loop.solver_references.at(state.stamp))
        matrix = np.vstack([row.matrix for row in rows])
        target = np.concatenate([row.lower for row in rows])
        box = viable_bounds(state.q_star, team().limits, loop.parts.dt, state.command)
        lower, upper = box.lower, np.maximum(box.upper, box.lower + 1e-12)
        best = lsq_linear(matrix, target, (lower, upper), tol=1e-14, method="bvls")
        ours = np.linalg.norm(matrix @ command.chi - target)
        assert ours <= np.sqrt(2.0 * best.cost) + 1e-8


@pytest.mark.parametrize("fault", ["acceleration", "level 1"])
def test_the_tests_above_can_fail(fault, monkeypatch):
    """A controller without the acceleration box, or with its levels swapped, is caught."""
    run = {
        "seed": 1,
        "initial_stack": "track",
        "duration": 0.05,
        "switches": [(20, "posture_mid_range")],
        "lost": (10_000, 10_000),
        "late": 0,
    }
    if fault == "acceleration":
        monkeypatch.setattr(
            "lexstack.limits.limits_in_force.viable_bounds",
            lambda q, limits, dt, applied, *_: viable_bounds(q, limits, 1e3 * dt, applied),
        )
        test = test_feasible_and_within_acceleration_limits_at_every_tick
    else:
        monkeypatch.setattr(
            "lexstack.transition.methods.bridging.HqpProblem",
            lambda levels, bounds: HqpProblem(levels[::-1], bounds),
        )
        test = test_level_1_is_as_good_as_the_oracle_makes_it
    with pytest.raises(AssertionError):
        test.hypothesis.inner_test(run)
