"""Stacks sent as text into a run: smooth, in the bag, replayed; refused with the reason."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from lexstack_bag.replay.changes import Changes
from lexstack_bag.replay.nodes import REPLAYERS, Question, recorded_nodes
from lexstack_bag.run.reader import read_run
from lexstack_interfaces.msg import TransitionStatus
from lexstack_interfaces.srv import SwitchStack
from lexstack_testing.played_run import together
from support.runs import acceleration_ratio, read, short_scenario
from support.scenario import team

pytestmark = pytest.mark.system
# A task goes in between the two of reach_base; then it goes out again.
INSERTED = """
name: look_and_reach
description: The tools keep their poses, robot_a stands back, then the bases.
levels:
  - tasks: [{type: ee_pose, parameters: {gain: 3.0, max_linear: 0.5, max_angular: 1.0}}]
  - tasks: [{type: posture, robot: robot_a, parameters: {gain: 1.0}}]
  - tasks: [{type: base, parameters: {gain: 1.0}}]
  - tasks: [{type: velocity_damping}]
limits:
  robot_b: {panda_joint1: {velocity: 0.5}}
"""
FRAMED = """
name: elbow
description: A frame that no file names.
levels: [{tasks: [{type: frame_position, robot: robot_a, parameters: {frame: panda_link5}}]}]
"""
REFUSED = {
    "another stack already": INSERTED.replace("look_and_reach", "track"),
    "unknown task 'dance'": INSERTED.replace("look_and", "x").replace("type: base", "type: dance"),
    "not valid YAML": "name: [",
}


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """Run 6 s: in the blend to reach_base a stack comes as text; later one goes back to track."""
    out = tmp_path_factory.mktemp("recorded")
    first = short_scenario().scenario.events[0]
    events = (replace(first, base_target={"robot_a": (0.1, -0.3, 0.4)}),)
    answers, topics = [], set()
    with together(short_scenario(duration=6.0, events=events), out) as run:
        client = run.player.create_client(SwitchStack, "/robot_a/switch_stack")

        def ask(**fields):
            answers.append(client.call_async(SwitchStack.Request(**fields)))

        def watch():
            run.check()
            status = run.player.transition
            if status is None:
                return
            if not answers and status.phase == TransitionStatus.BLENDING and status.alpha > 0.3:
                for text in REFUSED.values():
                    ask(stack_yaml=text)
                ask(stack_yaml=INSERTED, duration=0.8)
            elif len(answers) == 4 and run.player.tick > 350:
                ask(stack="track", duration=0.5)
                ask(stack="look_and_reach", duration=0.5, at_tick=480)  # by its name now
                ask(stack_yaml=FRAMED, at_tick=5000)  # long after the end
            heard = run.player.get_subscriber_names_and_types_by_node("hqp_controller", "/")
            topics.update(name for name, _ in heard)

        run.play(watch)
        assert run.end() == []
    assert "/robot_a/panda_link5/ee_target" in topics, "a frame of a sent stack has its topics"
    return out, [answer.result() for answer in answers]


def test_a_text_is_accepted_or_refused_with_the_key(recorded):
    _, answers = recorded
    for reason, answer in zip(REFUSED, answers, strict=False):
        assert not answer.accepted
        assert answer.message.startswith("stack_yaml: ")
        assert reason in answer.message
    assert [answer.accepted for answer in answers[3:]] == [True] * 4
    assert "to 'look_and_reach' starts at tick" in answers[3].message


def test_the_command_goes_over_smoothly_while_the_robots_move(recorded):
    out, answers = recorded
    assert acceleration_ratio(out / "bag", team().limits.acceleration, 0.01) <= 1.0001
    run = read_run(out)
    phases = run.transition.phase[run.transition.id == answers[3].id]
    assert TransitionStatus.ADOPTING in phases
    begun = run.transition.tick[run.transition.id == answers[3].id][0]
    chi = run.chi["robot_a"]
    row = int(np.searchsorted(chi.tick, begun))
    # Across the trigger the command turns no faster than on its way before: it does not jump.
    steps = np.abs(np.diff(chi.chi, axis=0)).max(axis=1)
    assert np.abs(chi.chi[row]).max() > 0.05, "in motion"
    assert steps[row - 1 : row + 1].max() < 1.5 * steps[row - 10 : row - 1].max()


def test_its_limits_hold_once_it_is_in_effect(recorded):
    out, _ = recorded
    run = read_run(out)
    last = run.chi["robot_a"]
    assert last.stack[-1] == "look_and_reach"
    joint = run.team().joint_names.index("robot_b/panda_joint1")
    assert np.abs(last.chi[last.tick > 540, joint]).max() <= 0.5
    assert last.upper[-1, joint] <= 0.5 + 1e-6


def test_the_solver_solves_it_and_the_bag_keeps_its_text(recorded):
    out, answers = recorded
    requests = read(out / "bag", "/robot_a/stack_request")["/robot_a/stack_request"]
    texts = {(m.id, m.active): m.stack_yaml for m in requests}
    assert texts[answers[3].id, True] == texts[answers[5].id, True] == INSERTED
    assert texts[answers[3].id, False] == ""
    assert texts[answers[4].id, True] == ""
    run = read_run(out)
    solved = run.chi["robot_b"].stack[run.chi["robot_b"].transition_id == answers[3].id]
    assert set(solved) == {"look_and_reach"}
    assert len(run.resolved.stacks["look_and_reach"].levels) == 4


def test_it_is_replayed_bit_for_bit(recorded):
    run = read_run(recorded[0])
    assert recorded_nodes(run) == ("robot_a", "robot_b")
    for node in recorded_nodes(run):
        found = REPLAYERS[node](Question(run, Changes(), run.resolved))
        assert found.identical, found.line()
