"""A stack file that is wrong, or made for other robots, is named when somebody asks for it."""

from dataclasses import replace

import pytest
import yaml

from lexstack.errors import ConfigurationError
from lexstack.tasks import LevelConfig
from lexstack_config.checked import checked
from lexstack_config.parts import Parts, build_controller
from lexstack_config.resolved import ResolvedScenario, load_scenario
from support.scenario import SCENARIO
from support.stack_files import HEAD, LEVELS, folder

NAME = "name: mine\ndescription: d\n"
ONE = f"{NAME}levels:\n  - tasks:\n      - "
ELBOW = "limits: {robot_a: {elbow_joint: {velocity: 1.0}}}\n"
FAST = "limits: {robot_a: {base_x: {velocity: 50.0}}}\n"
FILE = "config/stacks/mine.yaml: "

WRONG = {
    "no YAML": ("levels: [", f"{FILE}not valid YAML"),
    "unknown key": (f"{NAME}speed: 1\n{LEVELS}", "unknown key 'speed'"),
    "another name": (HEAD + LEVELS, f"{FILE}name: expected 'mine', got 'some'"),
    "unknown task": (ONE + "type: dance\n", f"{FILE}levels[0].tasks[0]: type: unknown task"),
    "wrong parameter": (
        ONE + "{type: base, parameters: {x: 1}}\n",
        f"{FILE}levels[0].tasks[0]: parameters: unknown key 'x'",
    ),
    "posture of another arm": (
        ONE + "{type: posture, parameters: {target: [0.0, 1.0]}}\n",
        f"{FILE}levels[0].tasks[0]",
    ),
    "a wider limit": (
        NAME + LEVELS + FAST,
        f"{FILE}limits.robot_a.base_x: velocity: 50.0 is beyond",
    ),
    "other robots": (
        f"{NAME}robots: [rover]\n{LEVELS}",
        "is for other robots: the scenario has not rover",
    ),
    "joints of another arm": (
        NAME + LEVELS + ELBOW,
        "is for other robots: robot_a has not elbow_joint",
    ),
}


@pytest.fixture(params=WRONG.values(), ids=WRONG)
def case(request, tmp_path):
    """Return a scenario's file with a wrong stack ``mine`` beside it, and what is wrong."""
    text, reason = request.param
    return folder(tmp_path, mine=text), reason


def naming(path, line):
    """Write the stack's name into a scenario's line."""
    text = path.read_text(encoding="utf-8")
    assert line in text
    path.write_text(text.replace(line, line.replace("track", "mine")), encoding="utf-8")
    return path


def test_one_wrong_stack_of_the_users_own_does_not_break_a_scenario_that_does_not_name_it(case):
    path, reason = case
    resolved = checked(load_scenario(path), path.parent.parent)
    assert "mine" not in resolved.stacks
    assert {"track", "reach_base", "posture"} <= set(resolved.stacks)
    assert reason in resolved.unfit["mine"]
    assert "\n" not in resolved.unfit["mine"]
    assert str(path.parent) not in resolved.unfit["mine"], "a bag carries it: no machine's folders"


def test_a_stack_that_does_not_fit_is_refused_with_the_reason_when_it_is_asked_for(case):
    path, reason = case
    # As a node gets it: through the text of the resolved scenario.
    text = checked(load_scenario(path), path.parent.parent).to_yaml()
    resolved = ResolvedScenario.from_yaml(text, "copy")
    transition = build_controller(resolved, Parts.of(resolved)).transition
    answer = transition.ask("mine", 0.0, "", 0)
    assert not answer.accepted
    assert answer.message.startswith("stack 'mine' does not fit: ")
    assert reason in answer.message
    assert not transition.ask("mine", 0.0, "", 0, ["robot_a"]).accepted
    assert transition.ask("posture", 0.0, "", 0).accepted


def test_parts_are_built_without_a_check_before(case):
    path, _ = case
    parts = Parts.of(load_scenario(path))
    assert "mine" in parts.unfit
    assert "mine" not in parts.stacks


def test_where_every_stack_must_fit_a_wrong_one_is_an_error():
    base = load_scenario(SCENARIO)
    (task,) = base.stacks["posture"].levels[-1].tasks
    level = LevelConfig((replace(task, parameters={"gain": -1.0}),))
    wrong = replace(base.stacks["posture"], levels=(level,))
    changed = replace(base, stacks={**base.stacks, "confined": replace(wrong, name="confined")})
    assert "confined" in Parts.of(changed).unfit
    with pytest.raises(ConfigurationError, match=r"stacks/confined\.yaml: levels\[0\].*gain"):
        Parts.of(changed, every=True)


@pytest.mark.parametrize("line", ["initial_stack: track", "switch: track"])
def test_a_wrong_stack_that_the_scenario_names_is_refused_with_file_and_key(case, line):
    path, _ = case
    naming(path, line)
    with pytest.raises(ConfigurationError) as error:
        checked(load_scenario(path), path.parent.parent)
    text = str(error.value)
    assert "mine" in text
    assert text.startswith(str(path.parent.parent)), "the file"
    assert "\n" not in text


def test_every_stack_of_the_configuration_fits_or_says_why():
    for path in sorted(SCENARIO.parent.glob("*.yaml")):
        resolved = checked(load_scenario(path), path.parent.parent)
        for name in (SCENARIO.parent.parent / "stacks").glob("*.yaml"):
            assert (name.stem in resolved.stacks) != (name.stem in resolved.unfit)
        assert all(reason.startswith("is for other robots: ") for reason in resolved.unfit.values())


def test_a_wrong_robot_file_is_named_with_file_and_key(tmp_path):
    path = folder(tmp_path)
    robot = path.parent.parent / "robots" / "panda_summit.yaml"
    text = robot.read_text(encoding="utf-8")
    robot.write_text(text.replace("parent: panda_hand", "parent: no_such_link"), encoding="utf-8")
    with pytest.raises(
        ConfigurationError, match=r"panda_summit\.yaml: tool\.parent: .*no_such_link"
    ):
        checked(load_scenario(path), path.parent.parent)


@pytest.mark.parametrize(
    ("task", "message"),
    [
        ("{name: t, kind: ee_pose, points: [[1.0, 0.0, 1.0]]}", "points[0]: expected 7"),
        ("{name: t, kind: base_position, points: []}", "points: at least one"),
    ],
)
def test_a_sequence_that_cannot_be_is_named_with_file_and_key(tmp_path, task, message):
    path = folder(tmp_path).parent / "by-hand.yaml"
    more = f"sequences: {{deliver: {{robot: robot_a, tasks: [{task}]}}}}\n"
    path.write_text(path.read_text(encoding="utf-8") + more, encoding="utf-8")
    with pytest.raises(ConfigurationError) as error:
        checked(load_scenario(path), path.parent.parent, path)
    assert str(error.value).startswith(f"{path}: sequences.deliver: ")
    assert message in str(error.value)


def test_a_sequence_needs_the_stack_on_which_its_robot_follows_a_plan(tmp_path):
    path = folder(tmp_path).parent / "by-hand.yaml"
    (path.parent.parent / "stacks" / "plan_robot_b.yaml").unlink()
    task = "{name: t, kind: base_position, points: [[1.0, 1.0]]}"
    more = f"sequences: {{deliver: {{robot: robot_b, tasks: [{task}]}}}}\n"
    path.write_text(path.read_text(encoding="utf-8") + more, encoding="utf-8")
    with pytest.raises(ConfigurationError, match=r"sequences\.deliver: .*plan_robot_b"):
        checked(load_scenario(path), path.parent.parent, path)


def test_an_unfit_stack_survives_the_text_of_the_scenario():
    resolved = replace(load_scenario(SCENARIO), unfit={"mine": "why"})
    assert yaml.safe_load(resolved.to_yaml())["unfit"] == {"mine": "why"}
    assert ResolvedScenario.from_yaml(resolved.to_yaml(), "copy") == resolved
