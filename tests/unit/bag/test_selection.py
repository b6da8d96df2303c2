"""Which topics are recorded."""

from __future__ import annotations

import pytest

from lexstack_bag.errors import BagError
from lexstack_bag.storage.selection import Selection

TOPICS = {
    "/plant/state": "lexstack_interfaces/msg/PlantState",
    "/robot_a/chi": "lexstack_interfaces/msg/Chi",
    "/robot_b/chi": "lexstack_interfaces/msg/Chi",
    "/robot_a/odom": "nav_msgs/msg/Odometry",
    "/clock": "rosgraph_msgs/msg/Clock",
}


@pytest.mark.parametrize(
    ("selection", "taken"),
    [
        (Selection(), list(TOPICS)),
        (Selection(topics=("/clock",)), ["/clock"]),
        (Selection(regex="robot_a"), ["/robot_a/chi", "/robot_a/odom"]),
        (Selection(regex="^/robot_.*/chi$"), ["/robot_a/chi", "/robot_b/chi"]),
        (Selection(topics=("/clock",), regex="odom"), ["/robot_a/odom", "/clock"]),
        (Selection(exclude_regex="/robot"), ["/plant/state", "/clock"]),
        (Selection(exclude_topics=("/clock",), regex="cl|st"), ["/plant/state"]),
        (
            Selection(exclude_topic_types=("lexstack_interfaces/msg/Chi",)),
            ["/plant/state", "/robot_a/odom", "/clock"],
        ),
        (Selection(topics=("/clock",), exclude_topics=("/clock",)), []),
    ],
)
def test_what_is_taken(selection, taken):
    assert [topic for topic, kind in TOPICS.items() if selection.takes(topic, kind)] == taken


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"regex": "("}, "regex: '(': missing ), unterminated subpattern at position 0"),
        ({"exclude_regex": "*"}, "exclude_regex: '*': nothing to repeat at position 0"),
        ({"topics": ("clock",)}, "topics: a topic begins with /, got 'clock'"),
        ({"exclude_topics": ("",)}, "exclude_topics: a topic begins with /, got ''"),
    ],
)
def test_what_makes_no_sense_is_refused(values, message):
    with pytest.raises(BagError) as error:
        Selection(**values)
    assert str(error.value) == message
