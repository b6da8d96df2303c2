"""One chi from several solvers, whatever the order of its parts."""

import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from lexstack.control import share
from lexstack.transition import SourceSample
from lexstack.transition.sources.partial_samples import PartialSampleMerger
from support.scenario import team

TEAM = team()
WHOLE = np.arange(1.0, TEAM.n + 1.0)


def part(robot, tick, *, id_=1, solved=True, slack=0.5):
    chi = np.zeros(TEAM.n)
    chi[TEAM.slices[robot]] = WHOLE[TEAM.slices[robot]] + tick
    return SourceSample(id_, tick, chi, solved, slack, (robot,), "track")


@settings(derandomize=True, deadline=None)
@given(st.permutations([(robot, tick) for robot in (0, 1) for tick in (3, 4, 5)]))
def test_parts_of_one_tick_meet_in_any_order(order):
    joiner, joined = PartialSampleMerger(TEAM), []
    for robot, tick in order:
        whole = joiner.join(part(robot, tick), (0, 1))
        if whole is not None:
            joined.append(whole)
    for whole in joined:
        np.testing.assert_array_equal(whole.chi, WHOLE + whole.tick)
        assert whole.robots is None
        assert whole.slack == math.hypot(0.5, 0.5)
    ticks = [whole.tick for whole in joined]
    assert ticks == sorted(set(ticks)), "never back in time, never twice"
    assert ticks[-1] == 5, "the newest is never given up"


def test_a_part_that_was_not_solved_spoils_the_whole_and_a_silent_one_the_slack():
    joiner = PartialSampleMerger(TEAM)
    assert joiner.join(part(0, 1, solved=False), (0, 1)) is None
    assert not joiner.join(part(1, 1), (0, 1)).solved
    joiner.join(part(0, 2, slack=None), (0, 1))
    assert joiner.join(part(1, 2), (0, 1)).slack is None


def test_transitions_do_not_mix_and_are_forgotten():
    joiner = PartialSampleMerger(TEAM)
    assert joiner.join(part(0, 1, id_=1), (0, 1)) is None
    assert joiner.join(part(1, 1, id_=2), (0, 1)) is None
    joiner.keep([2])
    assert joiner.join(part(1, 1, id_=1), (0, 1)) is None
    assert joiner.join(part(0, 1, id_=2), (0, 1)) is not None


def test_what_holds_all_that_is_needed_goes_through_as_it_is():
    joiner, one = PartialSampleMerger(TEAM), part(1, 1)
    assert joiner.join(one, (1,)) is one
    whole = SourceSample(1, 1, WHOLE, True)
    assert joiner.join(whole, (0, 1)) is whole


def test_every_robot_has_one_solver_and_coupled_ones_share_the_first():
    from lexstack_config.parts import Parts
    from support.scenario import changed

    stacks = Parts.of(changed()).stacks
    for name in ("track", "posture", "reach_base"):
        shares = [share(stacks[name], 2, number, 2) for number in (1, 2)]
        assert [each.robots for each in shares] == [(0,), (1,)]
        assert share(stacks[name], 2, 1, 1) is stacks[name]
    coupled = [name for name, stack in stacks.items() if stack.coupling({0})]
    assert coupled, "two robots carry one object"
    for name in coupled:
        assert share(stacks[name], 2, 1, 2) is stacks[name]
        assert share(stacks[name], 2, 2, 2) is None
