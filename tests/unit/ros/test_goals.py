"""Goals of the action execute_sequence: what cannot be is refused, with the reason."""

import numpy as np
import pytest

from lexstack.errors import InputError
from lexstack.mpc import SequenceTask
from lexstack_interfaces.action import ExecuteSequence
from lexstack_ros.messages.plans import task_message
from lexstack_ros.planner.goals import base_at, wanted_of
from support.scenario import home, state_at, team

EVERY = 5  # ticks from plan to plan


def goal(**values):
    """Return a goal that is right, with other values."""
    task = task_message(SequenceTask("give", "ee_position", ((1.0, 0.0, 1.0),)))
    return ExecuteSequence.Goal(**{"robot": "robot_a", "tasks": [task], **values})


def test_a_goal_for_now_begins_with_the_plan_after_the_next_one():
    found = wanted_of(goal(), team(), state_at(home(), tick=103), EVERY)
    assert (found.robot, found.architecture) == (0, "ht")
    assert (found.at_tick, found.begin) == (110, 110)
    found = wanted_of(goal(at_tick=123, architecture="st"), team(), None, EVERY)
    assert (found.at_tick, found.begin, found.architecture) == (123, 120, "st")


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"robot": "robot_x"}, "robot: unknown 'robot_x'; known: robot_a, robot_b"),
        ({"robot": ""}, "robot: unknown ''"),
        ({"tasks": []}, "tasks: expected 1 to"),
        ({"architecture": "xx"}, "architecture: unknown 'xx'; known: ht, st"),
        ({"at_tick": 100}, "at_tick: 100 is too early; the present tick is 100"),
        ({"tasks": goal().tasks * 2}, "two tasks have the name 'give'"),
    ],
)
def test_a_goal_that_cannot_be_is_refused_with_the_reason(values, message):
    with pytest.raises(InputError) as error:
        wanted_of(goal(**values), team(), state_at(home(), tick=100), EVERY)
    assert message in str(error.value)


def test_before_the_first_state_a_goal_needs_its_tick():
    with pytest.raises(InputError, match="at_tick: must be given"):
        wanted_of(goal(), team(), None, EVERY)


def test_a_base_stands_only_where_it_does_not_move():
    part = team().slices[1]
    assert base_at(None, team(), 1) is None
    assert base_at(state_at(home()), team(), 1) == tuple(home()[part][:3])
    command = np.zeros(team().n)
    command[part.start + 2] = 0.1  # rad/s
    assert base_at(state_at(home(), command), team(), 1) is None
    command[part.start + 2], command[part.start + 5] = 0.0, 0.1
    assert base_at(state_at(home(), command), team(), 1) is not None, "an arm may move"
