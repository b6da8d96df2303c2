"""Every message that a node hears, with every kind of wrong field: taken or refused, no crash."""

import math

import numpy as np
import pytest
from geometry_msgs.msg import PoseStamped
from hypothesis import given, settings
from hypothesis import strategies as st
from std_msgs.msg import String

from lexstack.errors import InputError
from lexstack.types import RobotState
from lexstack_interfaces.msg import Chi, PlantState, StackRequest
from lexstack_interfaces.srv import ApplyWrench, SwitchStack
from lexstack_ros.messages import conversions
from support import fuzz_messages
from support.scenario import home, state_at, team

numbers = st.floats() | st.sampled_from([1e300, -1e300, 1e6, 1e7, 0.0])
vectors = st.lists(numbers, max_size=25) | st.lists(
    st.floats(-1e6, 1e6), min_size=team().n, max_size=team().n
)
texts = st.text(max_size=30) | st.sampled_from(["x" * 5_000, "track", "robot_a", "bridge", "\n"])
names = st.lists(texts, max_size=3) | st.just(list(team().names))
counts = st.integers(0, 2**32 - 1)
ticks = st.integers(0, 2**64 - 1)


def thorough(test):
    """Run a property on many inputs, the same ones each time."""
    return settings(max_examples=300, deadline=None, derandomize=True)(test)


def stamped(message, sec, nanosec):
    """Return a message with a stamp."""
    message.header.stamp.sec, message.header.stamp.nanosec = sec, nanosec
    return message


stamps = {"sec": st.integers(-(2**31), 2**31 - 1), "nanosec": counts}


@thorough
@given(
    values=st.fixed_dictionaries(dict.fromkeys(("q", "v", "q_star", "command"), vectors)),
    head=st.fixed_dictionaries(
        {
            "tick": ticks,
            "robots": names,
            "sender": texts | st.just(fuzz_messages.SENDER),
            "resets": counts,
        }
    ),
    **stamps,
)
def test_states(values, head, sec, nanosec):
    fuzz_messages.take(stamped(PlantState(**head, **values), sec, nanosec))


@thorough
@given(chi=vectors, tick=ticks, robots=names, status=st.integers(0, 255), id_=counts)
def test_solutions(chi, tick, robots, status, id_):
    taken = fuzz_messages.take(
        Chi(chi=chi, tick=tick, robots=robots, status=status, transition_id=id_)
    )
    fits = len(chi) == team().n and all(abs(value) <= 1e6 for value in chi)
    assert taken == (fits and robots == list(team().names))


@thorough
@given(id_=counts, stack=texts, robots=names, start=ticks, active=st.booleans())
def test_requests_to_a_source(id_, stack, robots, start, active):
    fuzz_messages.take(
        StackRequest(id=id_, stack=stack, robots=robots, start_tick=start, active=active)
    )


@thorough
@given(frame=texts | st.sampled_from(["", "world"]), pose=st.tuples(*[numbers] * 7), **stamps)
def test_targets(frame, pose, sec, nanosec):
    message = stamped(PoseStamped(), sec, nanosec)
    message.header.frame_id = frame
    place, turn = message.pose.position, message.pose.orientation
    place.x, place.y, place.z, turn.x, turn.y, turn.z, turn.w = pose
    fuzz_messages.take(message)


@thorough
@given(
    kind=st.sampled_from(fuzz_messages.MOVING[:4]),
    values=st.lists(st.tuples(*[numbers | st.floats(-1.0, 1.0)] * 7), min_size=2, max_size=2),
    seconds=st.tuples(st.integers(-3, 80), st.integers(-3, 80)),
    frame=texts | st.sampled_from(["", "world", "robot_b/tool"]),
    **stamps,
)
def test_targets_that_move(kind, values, seconds, frame, sec, nanosec):
    message = stamped(fuzz_messages.good_target(kind), sec, nanosec)
    message.header.frame_id = frame
    points = getattr(message, "points", []) or getattr(message, "poses", [])
    for point, numbers_, second in zip(points, values, seconds, strict=False):
        if hasattr(point, "positions"):
            point.positions = list(numbers_)
        elif hasattr(point, "transforms"):
            place, turn = point.transforms[0].translation, point.transforms[0].rotation
            place.x, place.y, place.z = numbers_[:3]
            turn.x, turn.y, turn.z, turn.w = numbers_[3:]
        else:
            point.pose.position.x, point.header.stamp.sec = numbers_[0], second
        if hasattr(point, "time_from_start"):
            point.time_from_start.sec = second
    fuzz_messages.take(message)


@thorough
@given(stack=texts, duration=numbers, method=texts, at_tick=ticks)
def test_switches(stack, duration, method, at_tick):
    fuzz_messages.take(
        SwitchStack.Request(stack=stack, duration=duration, method=method, at_tick=at_tick)
    )


@thorough
@given(texts)
def test_switches_by_topic(stack):
    fuzz_messages.take(String(data=stack))


@thorough
@given(robot=texts, link=texts | st.just("tool"), force=st.tuples(*[numbers] * 3), duration=numbers)
def test_pushes(robot, link, force, duration):
    request = ApplyWrench.Request(robot=robot, link=link, duration=duration)
    request.wrench.force.x, request.wrench.force.y, request.wrench.force.z = force
    taken = fuzz_messages.take(request)
    strong = not all(math.isfinite(f) and abs(f) <= 1e4 for f in force)
    assert not (taken and strong)


@thorough
@given(st.binary(max_size=300), st.integers(0, len(fuzz_messages.TARGETS) - 1))
def test_any_bytes_as_any_message(data, kind):
    fuzz_messages.one(bytes([kind]) + data)


@thorough
@given(
    q=st.lists(st.floats(-1e6, 1e6), min_size=team().n, max_size=team().n),
    command=st.lists(st.floats(-1e6, 1e6), min_size=team().n, max_size=team().n),
    tick=st.integers(0, 10**6),
)
def test_whatever_the_state_the_command_is_finite_and_inside_its_bounds(q, command, tick):
    fuzz_messages.answer(state_at(np.array(q), np.array(command), tick))


def test_a_good_state_is_answered_after_bad_ones():
    fuzz_messages.answer(RobotState(5, 0.05, home(), *[np.zeros(team().n)] * 3))


@pytest.mark.parametrize("value", [1.1e6, -1e300])
def test_a_huge_value_is_refused(value):
    values = [0.0] * team().n
    values[3] = value
    with pytest.raises(InputError, match="out of range"):
        conversions.to_vector(values, team().n, "q")
