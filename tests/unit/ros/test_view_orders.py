"""What the page may ask for: all else is refused, with the field named."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lexstack.errors import InputError
from lexstack_ros.view.orders import BaseTarget, Enable, Execute, Known, Push, Switch, ToolTarget

KNOWN = Known(("robot_a", "robot_b"), ("posture", "track"), ("deliver",))
DOWN = (1.0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("asked", "order"),
    [
        (KNOWN.switch("track", 1), Switch("track", 1.0)),
        (KNOWN.base_target("robot_a", (1, 2, 0.5)), BaseTarget("robot_a", (1.0, 2.0, 0.5))),
        (
            KNOWN.tool_target("robot_b", np.array([0.4, 0.0, 0.9]), DOWN),
            ToolTarget("robot_b", (0.4, 0.0, 0.9), DOWN),
        ),
        (
            KNOWN.push("robot_b", "tool", [0, 40, -1.5], 0.5),
            Push("robot_b", "tool", (0.0, 40.0, -1.5), 0.5),
        ),
        (KNOWN.enable("robot_a", True), Enable("robot_a", True)),
        (KNOWN.execute("deliver"), Execute("deliver")),
    ],
)
def test_an_order_is_read(asked, order):
    assert asked == order


@pytest.mark.parametrize(
    ("ask", "field"),
    [
        (lambda: KNOWN.switch("nope", 0), "stack: expected one of posture, track"),
        (lambda: KNOWN.switch(["track"], 0), "stack"),
        (lambda: KNOWN.switch("track", -1), "duration: must be from 0 to 60"),
        (lambda: KNOWN.switch("track", True), "duration: expected a number"),
        (lambda: KNOWN.switch("track", None), "duration: expected a number"),
        (lambda: KNOWN.switch("track", float("nan")), "duration"),
        (lambda: KNOWN.base_target("robot_c", (0, 0, 0)), "robot: expected one of"),
        (lambda: KNOWN.base_target("robot_a", (0, 0)), "place: expected 3 numbers"),
        (lambda: KNOWN.base_target("robot_a", "123"), "place: expected 3 numbers"),
        (lambda: KNOWN.base_target("robot_a", (0, 0, 1000)), r"place\[2\]: must be from -100"),
        (lambda: KNOWN.tool_target("robot_a", (0, np.inf, 0), DOWN), r"position\[1\]"),
        (lambda: KNOWN.tool_target("robot_a", (0, 0, 0), (1, 1, 0, 0)), "orientation: norm must"),
        (lambda: KNOWN.tool_target("robot_a", (0, 0, 0), (0, 0, 0)), "orientation: expected 4"),
        (lambda: KNOWN.push("robot_a", "elbow", (0, 0, 0), 1), "link: expected one of base, tool"),
        (lambda: KNOWN.push("robot_a", "tool", (0, 0, 1e4), 1), r"force\[2\]: must be from"),
        (lambda: KNOWN.push("robot_a", "tool", (0, 0, 0), 0), "duration: must be from 0.001"),
        (lambda: KNOWN.execute("steal"), "sequence: expected one of deliver"),
        (lambda: KNOWN.enable("robot_c", True), "robot: expected one of"),
    ],
)
def test_what_is_no_order_is_refused_with_its_field(ask, field):
    with pytest.raises(InputError, match=field):
        ask()


ANYTHING = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=9),
    lambda inner: st.lists(inner, max_size=5) | st.dictionaries(st.text(max_size=3), inner),
    max_leaves=8,
)


@given(first=ANYTHING, second=ANYTHING, third=ANYTHING, fourth=ANYTHING)
@settings(max_examples=200, deadline=None)
def test_whatever_a_browser_sends_is_an_order_within_limits_or_refused(
    first, second, third, fourth
):
    for ask in (
        lambda: KNOWN.switch(first, second),
        lambda: KNOWN.push(first, second, third, fourth),
        lambda: KNOWN.tool_target("robot_a", second, third),
        lambda: KNOWN.base_target("robot_a", second),
    ):
        try:
            order = ask()
        except InputError:
            continue
        for name in ("position", "place", "quaternion", "force"):
            assert np.isfinite(getattr(order, name, ())).all()
