"""What a lockstep run's recorder wrote late comes back to where it was sent."""

from types import SimpleNamespace

import pytest

from lexstack_bag.replay.order import in_lockstep

STATE, PLAN, CHI, COMMAND = "/plant/state", "/htmpc/plan", "/robot_b/chi", "/robot_a/chi"


def message(topic, tick):
    stamp = SimpleNamespace(sec=0, nanosec=10_000_000 * tick)
    return SimpleNamespace(topic=topic, tick=tick, header=SimpleNamespace(stamp=stamp))


def ordered(*entries):
    messages = [message(*entry) for entry in entries]
    return [(m.topic, m.tick) for m in in_lockstep(messages, lambda m: m)]


@pytest.mark.parametrize("late", [PLAN, CHI])
def test_an_answer_comes_before_the_next_state(late):
    found = ordered((STATE, 1), (COMMAND, 1), (STATE, 2), (COMMAND, 2), (late, 1), (STATE, 3))
    assert found == [
        (STATE, 1), (COMMAND, 1), (late, 1), (STATE, 2), (COMMAND, 2), (STATE, 3)
    ]  # fmt: skip


def test_what_is_in_order_stays_so():
    entries = [(topic, tick) for tick in range(400) for topic in (STATE, PLAN, CHI, COMMAND)]
    assert ordered(*entries) == entries


def test_an_answer_to_the_same_state_stays_behind_it():
    assert ordered((STATE, 1), (STATE, 2), (PLAN, 2)) == [(STATE, 1), (STATE, 2), (PLAN, 2)]


@pytest.mark.parametrize("early", [PLAN, CHI])
def test_an_answer_waits_for_its_state(early):
    found = ordered((STATE, 1), (CHI, 1), (early, 2), (COMMAND, 1), (STATE, 2), (COMMAND, 2))
    assert found == [
        (STATE, 1), (CHI, 1), (COMMAND, 1), (STATE, 2), (early, 2), (COMMAND, 2)
    ]  # fmt: skip
