"""What the recorder calls lost, and what it does not."""

import pytest
from rclpy.qos import QoSProfile, ReliabilityPolicy

from lexstack_ros.recorder.topics import Tap, matching_qos


class Node:
    """Stands for a node: keeps what a subscription would call."""

    def create_subscription(self, _type, _topic, callback, _qos, *, raw, event_callbacks):
        assert raw
        assert event_callbacks.message_lost is None, "it stands still under load"
        assert not event_callbacks.use_default_callbacks
        self.hear = lambda number: callback(b"", {"publication_sequence_number": number})
        return object()


@pytest.fixture
def node():
    return Node()


@pytest.fixture
def tap(node):
    return Tap(node, "/topic", "std_msgs/msg/String", matching_qos([]), lambda *_: None)


def test_a_gap_is_a_loss(node, tap):
    for number in (1, 2, 5):
        node.hear(number)
    assert tap.lost == 2


def test_what_was_sent_before_the_beginning_is_not_lost(node, tap):
    for number in (1, 5):
        node.hear(number)
    tap.begin()
    assert tap.lost == 0
    node.hear(8)
    assert tap.lost == 2


def test_a_second_publisher_that_started_earlier_makes_no_gap(node, tap):
    for number in (1, 2, 9, 10):  # 9 and 10 are another's, whose first eight nobody awaited
        node.hear(number)
    tap.shared = True
    assert tap.lost == 0


def test_what_is_sent_best_effort_is_not_lost(node):
    qos = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
    tap = Tap(node, "/topic", "std_msgs/msg/String", qos, lambda *_: None)
    for number in (1, 5):
        node.hear(number)
    assert tap.lost == 0
