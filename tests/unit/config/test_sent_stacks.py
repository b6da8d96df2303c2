"""Stacks sent as text: checked as the files are, and one name stands for one stack."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lexstack.control import make_stack_solver
from lexstack.errors import ConfigurationError
from lexstack.transition import Transition, TransitionConfig, TransitionOptions
from lexstack_bag.run.reader import with_sent
from lexstack_bag.run.run import StackRequested
from lexstack_config import sent_stacks
from lexstack_config.parts import Parts
from lexstack_config.sent_stacks import LARGEST, SentStacks
from support.scenario import CONFIG, resolved, team

LEAN = "{name: lean, description: x, levels: [{tasks: [{type: ee_pose}]}, {tasks: [{type: base}]}]}"
OTHER = LEAN.replace("base", "posture")


def sent() -> SentStacks:
    return SentStacks(team(), resolved().stacks, {"unfit"})


def test_a_text_is_read_as_a_file_is():
    text = (CONFIG / "stacks/reach_base.yaml").read_text(encoding="utf-8")
    config = sent().read("", text)
    assert config == resolved().stacks["reach_base"]
    assert not sent().is_new(config), "the same stack under its name is the known one"


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", "stack_yaml: expected a mapping of keys, got NoneType"),
        ("[]", "stack_yaml: expected a mapping of keys, got list"),
        ("{name: [", "stack_yaml: not valid YAML: "),
        ("{a: &x [1], b: *x}", "aliases are not supported"),
        ("name: lean", "stack_yaml: key 'description' is missing"),
        (LEAN + " # " + "x" * LARGEST, f"stack_yaml: {len(LEAN) + 3 + LARGEST} bytes, at most"),
        (LEAN.replace("lean", "<b>x</b>"), "stack_yaml: name: a name has letters, digits"),
        (LEAN.replace("lean", '"a\\n"'), "stack_yaml: name: a name has letters, digits"),
        (LEAN.replace("lean", "track"), "name: 'track' is another stack already; give this one"),
        (LEAN.replace("lean", "unfit"), "name: 'unfit' is another stack already"),
        (LEAN.replace("base", "dance"), "levels[1].tasks[0]: type: unknown task 'dance'"),
        (LEAN.replace("{type: base}", "{type: base, robot: r9}"), "unknown robot 'r9'; known: rob"),
        (LEAN.replace("{type: base}", "{type: base, gain: 1}"), "tasks[0]: unknown key 'gain'"),
        (LEAN.replace("{type: base}", "{type: base, parameters: {gain: .nan}}"), "gain"),
        (LEAN.replace("base", "ee_pose"), "stands in it twice"),
        (LEAN[:-1] + ", limits: {robot_a: {elbow: {velocity: 1.0}}}}", "unknown joint 'elbow'"),
    ],
)
def test_what_is_no_stack_is_refused_with_key_and_reason_in_one_line(text, reason):
    stacks = sent()
    with pytest.raises(ConfigurationError) as caught:
        stacks.fit(stacks.read("", text))
    assert reason in str(caught.value)
    assert str(caught.value).startswith("stack_yaml: ")
    assert str(caught.value).isprintable()


def test_the_name_of_the_request_is_empty_or_that_of_the_text():
    assert sent().read("lean", LEAN).name == "lean"
    with pytest.raises(ConfigurationError, match="'lean', but the request is for stack 'track'"):
        sent().read("track", LEAN)


def test_one_name_stands_for_one_stack_until_the_plant_is_reset(monkeypatch):
    stacks = sent()
    stacks.keep(stacks.read("", LEAN), LEAN)
    again = stacks.read("", f"# the same\n{LEAN}")
    assert not stacks.is_new(again)
    with pytest.raises(ConfigurationError, match="'lean' is another stack already"):
        stacks.read("", OTHER)
    monkeypatch.setattr(sent_stacks, "MOST", 1)
    with pytest.raises(ConfigurationError, match="1 stacks were sent in this run already"):
        stacks.read("", LEAN.replace("lean", "more"))
    stacks.forget()
    assert stacks.is_new(stacks.read("", OTHER))
    assert not stacks.texts


@given(st.text(max_size=200) | st.text("{}[]:,-&*!|>'\" \n#nameltyp0.", max_size=200))
def test_any_text_is_a_stack_or_refused_in_one_line(text):
    reason = ""
    try:
        sent().fit(sent().read("", text))
    except ConfigurationError as error:
        reason = str(error)
    assert reason.isprintable()


# ---- what follows from one


def transition() -> Transition:
    parts = Parts.of(resolved())
    options = TransitionOptions("track", TransitionConfig(1.0))
    return Transition(parts.stacks, make_stack_solver(team(), parts.stacks), options, team())


def test_a_stack_is_known_once_a_request_for_it_was_accepted():
    stacks, asked = sent(), transition()
    lean = stacks.fit(stacks.read("", LEAN))
    refused = asked.ask_new(lean, -1.0, "", 0)
    assert "duration" in refused.message
    assert "unknown stack 'lean'" in asked.ask("lean", 0.0, "", 0).message
    assert asked.ask_new(lean, 0.0, "", 5).accepted
    assert asked.ask("lean", 0.0, "", 9).accepted
    assert "known already" in asked.ask_new(lean, 0.0, "", 0).message
    assert [word.stack for word in asked.take_announcements()] == ["lean", "lean"]


def test_a_bag_knows_the_stacks_that_were_sent():
    requests = [
        StackRequested(0, 1, "track", 5, True, (), OTHER),  # a name of the scenario stays its own
        StackRequested(0, 2, "lean", 5, True, (), LEAN),
        StackRequested(0, 3, "lean", 9, True, (), OTHER),
        StackRequested(0, 4, "bad", 9, True, (), "]"),
    ]
    stacks = with_sent(resolved(), requests).stacks
    assert stacks["lean"] == sent().read("", LEAN)
    assert stacks["track"] == resolved().stacks["track"]
    assert "bad" not in stacks
    assert with_sent(resolved(), requests[:1]) is resolved()
