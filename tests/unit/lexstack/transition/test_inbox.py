"""Which chi of the solver counts: by its tick, and by the revision of its references."""

import dataclasses
import itertools

import numpy as np
import pytest

from lexstack.control import StackSolver
from lexstack.references import Target
from lexstack.transition import Phase, Source, SourceSample
from lexstack.transition.sources.inbox import Sources
from lexstack.transition.sources.partial_samples import PartialSampleMerger
from lexstack.transition.sources.residual_check import ResidualCheck
from lexstack.types import LinearTask
from lexstack_config.parts import transition_options
from support.channels import loop, parts
from support.scenario import changed, home, team

ANY = [None, 4]
LEVEL = (LinearTask.equality("x", np.eye(2), np.array([3.0, 4.0])),)


def sources(mode="lockstep"):
    local = StackSolver(team(), parts().stacks, None, 0.01)
    return Sources(local, transition_options(changed(mode=mode).scenario))


def sample(tick, revision=None, *, value=0.0, solved=True):
    return SourceSample(1, tick, np.full(20, value), solved, revision=revision)


@pytest.mark.parametrize("order", [*itertools.permutations([5, 6, 7])])
def test_an_older_chi_never_takes_the_place_of_a_newer_one(order):
    found = sources("realtime")
    for tick in order:
        found.hear(sample(tick))
    assert found.fresh(1, 8).tick == 7


def test_of_two_chi_for_one_tick_the_later_revision_counts():
    for order in ([3, 4], [4, 3]):
        found = sources("realtime")
        for revision in order:
            found.hear(sample(7, revision))
        assert found.fresh(1, 7).revision == 4


def test_a_chi_of_the_future_hides_none_of_the_present():
    found = sources("realtime")
    found.hear(sample(9_000))
    for tick in range(40):
        found.hear(sample(tick))
        assert found.fresh(1, tick).tick == tick
    assert found.fresh(1, 39 + 5).tick == 39, "0.05 s old"
    assert found.fresh(1, 39 + 6) is None


@pytest.mark.parametrize(("heard", "asked", "is_fresh"), [
    (4, 4, True), (3, 4, False), (5, 4, False), (None, 4, True), (3, None, True), (None, None, True)
])  # fmt: skip
def test_in_lockstep_a_chi_must_have_the_references_of_its_tick(heard, asked, is_fresh):
    found = sources()
    found.hear(sample(7, heard))
    assert (found.fresh(1, 7, asked) is not None) is is_fresh


def test_in_realtime_a_chi_with_older_references_is_as_old_as_its_tick():
    found = sources("realtime")
    found.hear(sample(7, 3))
    assert found.fresh(1, 8, 4).tick == 7


def test_in_lockstep_a_waits_for_the_chi_with_the_references_of_the_tick():
    transition = loop().controller.transition
    transition.ask("reach_base", 0.0, "", 3)
    transition.hear(sample(3, 1))
    assert transition.awaits(3, 2)
    assert not transition.awaits(3, 1)
    assert not transition.awaits(3), "the revision is not known"
    transition.hear(sample(3, 2))
    assert not transition.awaits(3, 2)


def test_in_mid_blend_a_chi_with_older_references_counts_as_lost():
    run = loop()
    ask = run.ask_solver
    run.ask_solver = lambda *args: dataclasses.replace(ask(*args), revision=1)
    run.controller.transition.ask("reach_base", 0.0, "", 2)
    run.run(10)
    assert run.record.commands[-1].transition.source is Source.SOLVER
    tool = team().tools(home())[0]
    moved = dataclasses.replace(tool, position=tool.position + 1e-6)
    run.controller.references.add(Target(0.0, 0, ee=moved))
    lost = run.step().transition
    assert lost.source is Source.LOCAL
    assert lost.reason.startswith(
        "the solver lost at tick 10, last heard tick 10 with references 1 "
    )
    run.ask_solver = lambda *args: dataclasses.replace(ask(*args), revision=2)
    assert run.step().transition.source is Source.SOLVER


@pytest.mark.parametrize("revision", ANY)
def test_parts_with_different_references_are_not_joined(revision):
    def part(robot, number):
        values = {"robots": (robot,), "stack": "track", "revision": number}
        return dataclasses.replace(sample(7), **values)

    joiner = PartialSampleMerger(team())
    assert joiner.join(part(0, revision), (0, 1)) is None
    assert joiner.join(part(1, 5), (0, 1)) is None, "the first part is of the past"
    assert joiner.join(part(0, 5), (0, 1)).revision == 5


# ---- the witness


def judged(witness, tick, heard, rows, *, slack=1.0, anew=False):
    chi = SourceSample(1, tick, np.zeros(2), True, slack, revision=heard)
    return witness.miss(chi, tick, LEVEL, anew=anew, revision=rows)


def test_a_chi_is_compared_with_rows_of_its_own_references_alone():
    witness = ResidualCheck(5, 1)
    assert judged(witness, 10, 1, 2, anew=True) == 0.0, "B has not the new references yet"
    assert judged(witness, 11, 2, 2) == pytest.approx(4.0), "it has: a wrong chi shows at once"
    assert judged(ResidualCheck(5, 1), 11, None, 2, anew=True) == 0.0, (
        "not known: a guess, as before"
    )


def test_a_frozen_b_does_not_hide_behind_old_references():
    witness = ResidualCheck(5, 3)
    judged(witness, 9, 1, 1, slack=5.0)
    found = [judged(witness, tick, 1, 2, anew=tick == 10) for tick in range(10, 20)]
    assert np.flatnonzero(found).tolist() == [7, 8, 9], "5 ticks of grace, then 3 that miss"


def test_a_b_that_answers_late_is_followed_in_the_order_of_its_ticks():
    """The chi of tick 8 arrives behind that of tick 9: the controller goes on with that of 9."""
    run = loop(mode="realtime")
    run.controller.transition.ask("reach_base", 0.0, "", 2)
    held = []

    def link(message):
        if message.tick == 8:
            held.append(message)
            return None
        return held.pop() if message.tick == 10 else message

    run.link = link
    run.run(11)
    assert run.record.commands[-1].transition.phase is Phase.BLENDING
    blend = run.controller.transition._channels[0].blend
    np.testing.assert_array_equal(blend.source_chi, run.record.sources[9])


def test_a_b_that_answers_with_wrong_references_is_lost_and_not_waited_for():
    """It was waited for at every tick, a second each, for as long as it had wrong ones."""
    run = loop()
    ask = run.ask_solver
    run.controller.transition.ask("reach_base", 0.0, "", 2)
    run.run(10)
    run.ask_solver = lambda *args: dataclasses.replace(ask(*args), revision=7)
    lost = run.step().transition
    assert lost.source is Source.LOCAL
    assert "last heard tick 10 with references 7 in place of 1: " in lost.reason
    run.step()
    assert not run.controller.awaits(run.plant.state())
