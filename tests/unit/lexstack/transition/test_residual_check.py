"""Whether a source's chi is what it claims to be: noticed at once in lockstep, soon in realtime."""

from dataclasses import replace

import numpy as np
import pytest

from lexstack.references import Target
from lexstack.transition import Source, SourceSample, TransitionConfig
from lexstack.transition.sources.residual_check import ResidualCheck
from lexstack.types import LinearTask
from lexstack_config.parts import build_references
from lexstack_experiments.links import Delayed, Frozen
from support.channels import loop, state_of

LEVEL = (LinearTask.equality("x", np.eye(2), np.array([3.0, 4.0])),)
NEVER = 10**6


def sample(tick, chi=(0.0, 0.0), slack=5.0):
    return SourceSample(1, tick, np.array(chi), True, slack)


def judged(witness, ticks, *, lag=0, right=(), anew=()):
    """Return the miss at every tick of chi that come ``lag`` ticks late."""
    return [
        witness.miss(
            sample(tick - lag, slack=5.0 if tick - lag in right else 1.0),
            tick,
            LEVEL,
            anew=tick in anew,
        )
        for tick in ticks
    ]


def test_a_right_chi_misses_nothing():
    witness = ResidualCheck(0, 1)
    assert witness.miss(sample(7), 7, LEVEL) == 0.0
    assert witness.miss(sample(8, (3.0, 0.0), 4.0), 8, LEVEL) == 0.0
    assert witness.miss(sample(9, slack=5.0 + 1e-6), 9, LEVEL) == 0.0, "rounding"
    assert witness.miss(sample(10, slack=4.0), 10, LEVEL) == pytest.approx(1.0)


def test_nothing_to_compare_with_is_no_evidence():
    witness = ResidualCheck(0, 1)
    assert witness.miss(sample(7, slack=None), 7, LEVEL) == 0.0
    assert witness.miss(sample(7, slack=1.0), 7, ()) == 0.0
    assert witness.miss(sample(6, slack=1.0), 7, LEVEL) == 0.0, (
        "of a tick that the controller did not see"
    )


def test_so_many_in_a_row_must_miss():
    found = judged(ResidualCheck(5, 4), range(12), lag=2, right=(3,))
    # Judged from the controller's first tick on, chi of tick 3 was right, and those of 4 to 7 miss.
    assert np.flatnonzero(found).tolist() == [9, 10, 11]
    assert found[9] == pytest.approx(4.0)


def test_the_same_chi_counts_once():
    witness = ResidualCheck(5, 3)
    assert [witness.miss(sample(0, slack=1.0), tick, LEVEL) for tick in range(6)] == [0.0] * 6


def test_new_references_are_no_evidence_while_chi_may_be_late():
    witness = ResidualCheck(5, 4)
    assert not any(judged(witness, range(40), lag=1, anew=range(0, 40, 8)))
    witness = ResidualCheck(5, 4)
    found = judged(witness, range(40), lag=1, anew=(10,))
    # 0 to 3 have missed; then the references are new, and 15 to 18 are the next that count.
    assert np.flatnonzero(found).tolist() == [4, 5, 6, 7, 8, 9, *range(19, 40)]


def test_what_is_over_is_forgotten():
    witness = ResidualCheck(5, 2)
    assert any(judged(witness, range(4)))
    witness.keep([2])
    assert witness.miss(sample(4, slack=1.0), 4, LEVEL) == 0.0


# ---- in the closed loop, in realtime


def realtime(link, duration=0.8):
    run = loop(transition=TransitionConfig(duration=duration), mode="realtime")
    run.link = link
    run.controller.transition.ask("reach_base", 0.0, "", 2)
    return run


def through(*links):
    """Return links one behind another."""

    def link(message):
        for each in links:
            message = None if message is None else each(message)
        return message

    return link


@pytest.mark.parametrize("late", [0, 1, 3])
def test_a_frozen_b_is_noticed_soon(late):
    run = realtime(through(Frozen(30), Delayed(late)))
    run.run(160)
    told = [command.transition for command in run.record.commands]
    blamed = next(tick for tick, state in enumerate(told) if state.source is Source.LOCAL)
    assert 30 + late + 9 <= blamed <= 30 + late + 12
    assert f"the solver's chi at tick {blamed} misses level 1 by " in told[blamed].reason
    assert told[-1].to_stack == "reach_base"


@pytest.mark.parametrize("late", [0, 1, 4])
def test_a_late_b_is_believed(late):
    run = realtime(Delayed(late))
    run.run(80)
    sources = {state_of(run, "robot_a", tick).source for tick in range(2 + late + 1, 80)}
    assert sources == {Source.SOLVER}
    assert not any(state_of(run, "robot_a", tick).reason for tick in range(80))


def test_targets_that_reach_the_two_robots_at_different_ticks_are_no_evidence():
    run = realtime(Delayed(1), duration=2.0)
    run.solver_references = build_references(run.resolved, run.parts.team)
    ask = run.ask_solver
    run.ask_solver = lambda *args: replace(ask(*args), revision=None)
    tools = run.parts.team.tools(run.plant.state().q)
    rng = np.random.default_rng(3)
    coming = []
    for tick in range(200):
        # A stream for a while, then now and then one; the solver hears each some ticks later.
        if tick < 60 or tick % 25 == 0:
            pose = replace(tools[0], position=tools[0].position + rng.uniform(-0.01, 0.01, 3))
            target = Target(0.01 * tick, 0, ee=pose)
            run.controller.references.add(target)
            coming.append((tick + int(rng.integers(0, 4)), target))
        for due, target in [entry for entry in coming if entry[0] <= tick]:
            run.solver_references.add(target)
            coming.remove((due, target))
        run.step()
    assert {state_of(run, "robot_a", tick).source for tick in range(5, 200)} == {Source.SOLVER}


def test_a_b_that_thaws_is_followed_again():
    frozen, honest = Frozen(30), Frozen(NEVER)
    run = realtime(lambda message: (frozen if message.tick < 60 else honest)(message), 1.5)
    run.run(100)
    told = [state_of(run, "robot_a", tick) for tick in range(100)]
    assert told[50].source is Source.LOCAL
    assert told[99].source is Source.SOLVER
    assert any("the solver is back" in state.reason for state in told)
