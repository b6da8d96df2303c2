"""What the live page is told."""

from __future__ import annotations

import json

import numpy as np
import pytest

from lexstack_config.parts import build_references, home_of
from lexstack_interfaces.msg import Chi, PlantState, TransitionStatus
from lexstack_ros.view.news import news
from support.scenario import resolved, team


def told(*statuses, chi=None, tick=200):
    state = PlantState(tick=tick, q=home_of(team(), resolved()).tolist())
    state.header.stamp.sec = 2
    references = build_references(resolved(), team()).at(2.0)
    return json.loads(news(team(), state, statuses, chi or {}, references))


def status(phase, *robots):
    return TransitionStatus(
        phase=phase, from_stack="track", to_stack="posture", alpha=0.25, robots=robots
    )


@pytest.mark.parametrize(
    ("phase", "stack", "word"),
    [
        (TransitionStatus.IDLE, "posture", "idle"),
        (TransitionStatus.REQUESTED, "track, then posture", "requested"),
        (TransitionStatus.PREPARING, "track, then posture", "preparing"),
        (TransitionStatus.BLENDING, "track → posture", "blending"),
        (TransitionStatus.ADOPTING, "posture", "adopting"),
    ],
)
def test_the_stack_in_effect_is_named(phase, stack, word):
    content = told(status(phase))
    assert (content["stack"], content["phase"], content["alpha"]) == (stack, word, 0.25)


def test_transitions_of_several_robots_are_told_apart():
    idle = status(TransitionStatus.IDLE, "robot_a")
    busy = status(TransitionStatus.BLENDING, "robot_b")
    content = told(idle, busy)
    assert content["stack"] == "posture (robot_a); track → posture (robot_b)"
    assert content["phase"] == "blending"
    assert told(status(TransitionStatus.IDLE, "robot_a", "robot_b"))["stack"] == "posture"


def test_before_anything_is_known_it_says_so_without_failing():
    content = told()
    assert (content["tick"], content["time"], content["levels"], content["solve"]) == (
        200,
        2.0,
        [],
        {},
    )
    assert np.allclose(content["q"], home_of(team(), resolved()), atol=1e-5)
    assert np.shape(content["ee"]) == (2, 7)


def test_solve_times_are_in_milliseconds_and_old_ones_are_left_out():
    chi = {
        "robot_a": Chi(tick=200, solve_time=0.0005, slacks=[0.1, float("nan")]),
        "robot_b": Chi(tick=150, solve_time=0.0004),
    }
    content = told(chi=chi)
    assert content["solve"] == {"robot_a": pytest.approx(0.5), "robot_b": None}
    assert content["levels"] == [0.1, 0.0]
