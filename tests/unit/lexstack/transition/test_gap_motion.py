"""How a gap keeps its motion, and how a solver that is late or wrong is replaced."""

import numpy as np
import pytest

from lexstack.transition import GapMotion, Phase, Source, SourceSample, TransitionConfig
from lexstack_experiments.links import Delayed, Frozen
from support.channels import loop

RNG = np.random.default_rng(5)
H = 1e-4


def derivatives(carry, elapsed):
    """Return value, rate and second derivative at a time, from differences ahead."""
    values = [carry.at(elapsed + k * H) for k in range(4)]
    rate = (-11.0 * values[0] + 18.0 * values[1] - 9.0 * values[2] + 2.0 * values[3]) / (6.0 * H)
    curvature = (2.0 * values[0] - 5.0 * values[1] + 4.0 * values[2] - values[3]) / H**2
    return values[0], rate, curvature


@pytest.mark.parametrize("duration", [0.3, 1.0, 4.0])
def test_it_begins_with_the_motion_and_ends_at_rest(duration):
    rate, curvature, mismatch = RNG.normal(size=(3, 4))
    value, slope, second = derivatives(GapMotion(rate, curvature, duration), 0.0)
    np.testing.assert_allclose(value, 0.0, atol=1e-12)
    np.testing.assert_allclose(slope, rate, rtol=1e-3)
    np.testing.assert_allclose(second, curvature, rtol=0.05, atol=1e-2)
    _, slope, _ = derivatives(GapMotion(rate, curvature, duration, mismatch), 0.0)
    np.testing.assert_allclose(slope, rate + mismatch, rtol=1e-3, atol=1e-3)
    for end in (duration, duration + 1.0):
        np.testing.assert_array_equal(GapMotion(rate, curvature, duration, mismatch).at(end), 0.0)
    before = GapMotion(rate, curvature, duration, mismatch).at(duration - H)
    np.testing.assert_allclose(before, 0.0, atol=1e-9)


def test_the_motion_of_some_joints_can_be_put_in():
    one, other = (GapMotion(*RNG.normal(size=(2, 4)), 1.0) for _ in range(2))
    mixed = one.with_columns(slice(1, 3), other)
    np.testing.assert_array_equal(mixed.at(0.3)[1:3], other.at(0.3)[1:3])
    np.testing.assert_array_equal(mixed.at(0.3)[[0, 3]], one.at(0.3)[[0, 3]])


def bend_of(run, tick):
    """Return the largest jerk of the command around a tick, over its limit."""
    chi = np.array([c.chi for c in run.record.commands[tick - 3 : tick + 3]])
    limit = run.parts.dt**2 * run.parts.team.limits.jerk
    return float((np.abs(np.diff(chi, n=2, axis=0)) / limit).max())


def test_a_takes_over_smoothly_from_a_late_b():
    run = loop(transition=TransitionConfig(duration=0.4), mode="realtime")
    run.link = Delayed(4)
    run.controller.transition.ask("reach_base", 0.0, "", 2)
    run.run(120)
    sources = [c.transition.source for c in run.record.commands]
    begins = sources.index(Source.LOCAL)
    assert sources[begins - 1] is Source.SOLVER
    told = run.record.commands[begins].transition
    assert told.alpha == 0.0
    assert (
        "(m/s, rad/s) off the controller's own: the controller blends on to its own" in told.reason
    )
    assert run.record.commands[-1].transition.reason == "", "told only while it blends"
    assert bend_of(run, begins) < 0.05
    assert run.record.commands[-1].transition.phase is Phase.IDLE
    assert max(run.record.sources) <= begins + 1, "B is no longer needed"


def test_without_a_difference_the_stack_is_adopted_at_once():
    run = loop(transition=TransitionConfig(duration=0.4))
    run.controller.transition.ask("reach_base", 0.0, "", 2)
    run.run(60)
    phases = [c.transition.phase for c in run.record.commands]
    assert phases.index(Phase.ADOPTING) == 42
    assert phases[43] is Phase.IDLE


def test_a_frozen_b_is_noticed_at_its_first_tick():
    run = loop(transition=TransitionConfig(duration=0.4))
    run.link = Frozen(20)
    run.controller.transition.ask("reach_base", 0.0, "", 2)
    run.run(80)
    assert run.record.commands[19].transition.source is Source.SOLVER
    told = run.record.commands[20].transition
    assert told.source is Source.LOCAL
    assert told.reason.startswith("the solver's chi at tick 20 misses level 1 by ")
    assert bend_of(run, 20) < 0.05
    assert run.record.commands[-1].transition.phase is Phase.IDLE


def test_a_b_that_says_nothing_of_level_1_is_believed():
    run = loop(transition=TransitionConfig(duration=0.4))
    run.link = lambda s: SourceSample(s.transition_id, s.tick, s.chi + 0.01, s.solved)
    run.controller.transition.ask("reach_base", 0.0, "", 2)
    run.run(30)
    assert run.record.commands[-1].transition.source is Source.SOLVER
