"""Which frames have targets on the page: those that tasks of the stacks in effect move."""

from __future__ import annotations

import numpy as np
import pytest

from lexstack.tasks import AT_REST
from lexstack_config.parts import build_references
from lexstack_interfaces.msg import PlantState, TransitionStatus
from lexstack_ros.view.heard import Heard, picture_of
from lexstack_ros.view.stacks import Stacks
from support.scenario import home, resolved, team

ELBOW = """
name: elbow
description: A frame, and one that no target moves.
levels:
  - tasks: [{type: frame_velocity_limit, parameters: {frame: panda_link3, linear: [1.0, 1.0, 1.0]}}]
  - tasks: [{type: frame_position, robot: robot_a, parameters: {frame: panda_link5}}]
  - tasks: [{type: ee_pose}, {type: posture}]
"""
ELBOWS = ELBOW.replace("robot: robot_a, ", "").replace("name: elbow", "name: elbows")


@pytest.fixture
def stacks():
    found = Stacks(team(), resolved().stacks)
    for text in (ELBOW, ELBOWS):
        found.learn(text)
    return found


def status(phase, before, after, *robots):
    return TransitionStatus(
        phase=phase, from_stack=before, to_stack=after, robots=robots or team().names
    )


IDLE, BLENDING = TransitionStatus.IDLE, TransitionStatus.BLENDING
A, B = (0, "panda_link5"), (1, "panda_link5")


@pytest.mark.parametrize(
    ("statuses", "frames"),
    [
        ((), ()),
        ((status(IDLE, "track", "elbow"),), (A,)),
        ((status(IDLE, "track", "elbow" + AT_REST),), (A,)),
        ((status(IDLE, "elbow", "track"),), ()),
        ((status(BLENDING, "elbow", "track"),), (A,)),
        ((status(TransitionStatus.REQUESTED, "elbow", "track"),), (A,)),
        ((status(TransitionStatus.ADOPTING, "elbow", "track"),), ()),
        ((status(BLENDING, "elbow", "elbows"),), (A, B)),
        ((status(IDLE, "track", "elbows", "robot_b"), status(IDLE, "", "track", "robot_a")), (B,)),
        ((status(IDLE, "track", "unheard of"),), ()),
    ],
)
def test_frames_are_those_of_the_stacks_in_effect(stacks, statuses, frames):
    assert set(stacks.frames(statuses)) == set(frames)


def test_a_stack_that_is_sent_is_known_by_its_name(stacks):
    assert {"elbow", "elbows", "track"} <= set(stacks.names)
    assert list(stacks.names) == sorted(stacks.names)


@pytest.mark.parametrize("text", ["name: [", "name: x", ELBOW.replace("frame_position", "dance")])
def test_a_text_that_is_no_stack_changes_nothing(stacks, text):
    before = stacks.names
    stacks.learn(text)
    assert stacks.frames([status(IDLE, "", "x")]) == ()
    assert stacks.frames([status(IDLE, "", "track")]) == ()
    assert set(before) <= set(stacks.names)


def test_after_a_reset_a_name_may_stand_for_another_stack(stacks):
    assert stacks.frames([status(IDLE, "", "elbow")]) == (A,)
    stacks.learn(ELBOW.replace("panda_link5", "panda_link4"))
    assert stacks.frames([status(IDLE, "", "elbow")]) == ((0, "panda_link4"),)


def test_a_frame_without_a_target_is_shown_where_it_is():
    references = build_references(resolved(), team()).at(0.0)
    heard = Heard(PlantState(q=home().tolist()), frames=(B,))
    ((frame, pose),) = picture_of(team(), heard, references, references).frames.items()
    assert frame == B
    model = team().robots[1]
    actual = model.at(home()[team().q_slices[1]], model.frame("panda_link5"))[0]
    assert np.array_equal(pose.position, actual.position)
    assert np.array_equal(pose.rotation, actual.rotation)
