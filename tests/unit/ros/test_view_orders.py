"""What the live page may ask for: all else is refused, with the field named."""

from __future__ import annotations

import json

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lexstack.errors import InputError
from lexstack_ros.view.orders import Cancel, NewTarget, Push, Switch, read_order

ROBOTS, STACKS = ("robot_a", "robot_b"), ("posture", "track")
PUSH = {"do": "push", "robot": "robot_b", "link": "tool", "force": [0, 40, -1.5], "duration": 0.5}


def read(content):
    text = content if isinstance(content, bytes) else json.dumps(content).encode()
    return read_order(text, ROBOTS, STACKS)


@pytest.mark.parametrize(
    ("content", "order"),
    [
        ({"do": "switch", "stack": "track", "duration": 1}, Switch("track", 1.0)),
        ({"do": "cancel"}, Cancel()),
        (
            {"do": "target", "robot": "robot_a", "kind": "base", "values": [1, 2, 0.5]},
            NewTarget("robot_a", "base", (1.0, 2.0, 0.5)),
        ),
        (PUSH, Push("robot_b", "tool", (0.0, 40.0, -1.5), 0.5)),
    ],
)
def test_an_order_is_read(content, order):
    assert read(content) == order


@pytest.mark.parametrize(
    ("content", "field"),
    [
        (b"{", "not JSON"),
        (b"\xff", "not JSON"),
        (b"[" * 3000, "not JSON"),
        ([], "expected a JSON object"),
        ({}, "do: expected one of switch, cancel"),
        ({"do": "shutdown"}, "do"),
        ({"do": ["switch"]}, "do"),
        ({"do": "switch", "stack": "nope", "duration": 0}, "stack: expected one of posture, track"),
        ({"do": "switch", "stack": "track", "duration": -1}, "duration: must be from 0 to 60"),
        ({"do": "switch", "stack": "track", "duration": True}, "duration: expected a number"),
        ({"do": "switch", "stack": "track"}, "duration: expected a number"),
        (b'{"do": "switch", "stack": "track", "duration": NaN}', "NaN is no number"),
        (b'{"do": "switch", "stack": "track", "duration": 1e999}', "duration: must be"),
        (PUSH | {"force": [0, 0]}, "force: expected three numbers"),
        (PUSH | {"force": [0, 0, "1"]}, r"force\[2\]: expected a number"),
        (PUSH | {"force": [0, 2000, 0]}, r"force\[1\]: must be from -1000 to 1000"),
        (PUSH | {"duration": 0}, "duration"),
        (PUSH | {"robot": "robot_c"}, "robot"),
        (PUSH | {"link": "panda_link0"}, "link"),
    ],
)
def test_what_is_no_order_is_refused(content, field):
    with pytest.raises(InputError, match=field):
        read(content)


JSON = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=20),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=8), inner),
    max_leaves=12,
)


@settings(derandomize=True, deadline=None, max_examples=300)
@given(
    do=st.sampled_from(["switch", "cancel", "target", "push"]) | JSON,
    content=st.dictionaries(
        st.sampled_from(["stack", "duration", "robot", "kind", "values", "link", "force"]), JSON
    ),
)
def test_whatever_comes_is_an_order_or_an_input_error(do, content):
    rejection = ""
    try:
        order = read(content | {"do": do})
    except InputError as error:
        order, rejection = None, str(error)
    assert isinstance(order, Switch | Cancel | NewTarget | Push) != (0 < len(rejection) < 300)
