"""What a robot B that comes late learns of the references, and when it may serve."""

from types import SimpleNamespace

import pytest

from lexstack_ros.references import CatchingUp
from support.scenario import team

TOPICS = [f"/{name}/{kind}_reference" for name in ("robot_a", "robot_b") for kind in ("ee", "base")]


class Node:
    """Keeps the callbacks of the subscriptions."""

    def __init__(self):
        self.heard = {}

    def create_subscription(self, _kind, topic, callback, _qos):
        self.heard[topic] = callback


@pytest.fixture
def late():
    """Return a node that catches up, what it took, and how often it had all."""
    node, taken, complete = Node(), [], []
    catching_up = CatchingUp(
        node, team(), lambda *entry: taken.append(entry), lambda: complete.append(len(taken))
    )
    return SimpleNamespace(up=catching_up, heard=node.heard, taken=taken, complete=complete)


def test_it_is_complete_when_every_reference_has_come(late):
    assert sorted(late.heard) == sorted(TOPICS)
    late.up.join(500)
    for topic in TOPICS:
        assert not late.up.complete
        assert late.complete == []
        late.heard[topic](f"of {topic}")
    assert late.up.complete
    assert late.complete == [4]
    assert late.taken[1] == ("base_target", 0, "/robot_a/base_reference", f"of {TOPICS[1]}")
    late.heard[TOPICS[0]]("a new one")
    assert late.taken[-1][-1] == "a new one"
    assert late.complete == [4], "told once"


def test_what_came_before_the_first_state_counts(late):
    for topic in TOPICS[:3]:
        late.heard[topic](topic)
    assert late.taken == []
    late.up.join(500)
    assert [entry[-1] for entry in late.taken] == TOPICS[:3]
    assert not late.up.complete
    late.heard[TOPICS[3]](TOPICS[3])
    assert late.up.complete


def test_who_was_there_from_the_start_waits_for_nothing(late):
    late.up.join(0)
    assert late.up.complete
    late.heard[TOPICS[0]]("robot A's own word")
    assert late.taken == []
    assert late.complete == []
