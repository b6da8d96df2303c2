"""The configuration: every file loads, every mistake is named with its file and key."""

import copy

import pytest
import yaml

from lexstack.errors import ConfigurationError
from lexstack.tasks import StackConfig
from lexstack_config.reader import build
from lexstack_config.resolved import (
    ResolvedScenario,
    load_robot,
    load_scenario,
    load_stacks,
)
from lexstack_config.scenario import ScenarioConfig
from support.scenario import CONFIG, SCENARIO, resolved


@pytest.mark.parametrize("path", sorted((CONFIG / "robots").glob("*.yaml")), ids=lambda p: p.stem)
def test_every_robot_loads(path):
    assert load_robot(path).name == path.stem


@pytest.mark.parametrize(
    "path", sorted((CONFIG / "scenarios").glob("*.yaml")), ids=lambda p: p.stem
)
def test_every_scenario_loads(path):
    assert load_scenario(path).scenario.name == path.stem


def test_every_stack_loads():
    stacks = load_stacks(CONFIG / "stacks")
    assert {"track", "reach_base", "posture"} <= set(stacks)


def test_the_resolved_scenario_survives_its_text():
    text = resolved().to_yaml()
    assert ResolvedScenario.from_yaml(text, "copy") == resolved()


BREAKS = {
    "rate: must be finite and > 0, got -1": {"rate": -1.0},
    "rate: must be finite and > 0, got inf": {"rate": float("inf")},
    "unknown key 'speed'": {"speed": 1},
    "mode: 'fast' is not one of: lockstep, realtime": {"mode": "fast"},
    "seed: expected int, got 1.5": {"seed": 1.5},
    "seed: expected int, got True": {"seed": True},
    "robots: at least one robot": {"robots": {}},
    "robots: expected a mapping": {"robots": [1]},
    "robots.robot_a: key 'model' is missing": {"robots": {"robot_a": {"base": [0, 0, 0]}}},
    "robots.robot_a: base: expected 3 values, got 2": {
        "robots": {"robot_a": {"model": "panda_summit", "base": [0.0, 0.0]}}
    },
    "ee_target: unknown robot 'robot_c'; known: robot_a, robot_b": {
        "ee_target": {"robot_c": {"position": [0, 0, 0], "orientation": [0, 0, 0, 1]}}
    },
    "orientation: norm must be 1, got 2": {
        "ee_target": {"robot_a": {"position": [0, 0, 0], "orientation": [0, 0, 0, 2]}}
    },
    "base_target.robot_a[2]: must be a number, got NaN": {
        "base_target": {"robot_a": [0, 0, float("nan")]}
    },
    "events[0].at: after the scenario's end": {"events": [{"at": 100.0}]},
    "transition: duration: must be finite and > 0, got 0": {"transition": {"duration": 0.0}},
    "extensions[0]: a module has a Python name, with dots between its parts": {
        "extensions": ["../x"]
    },
    "extensions: expected a list, got 'x'": {"extensions": "x"},
    "timeouts: watchdog: must be finite and > 0": {"timeouts": {"watchdog": -0.1}},
}


@pytest.mark.parametrize(("message", "values"), BREAKS.items(), ids=BREAKS)
def test_a_wrong_scenario_value_is_named(message, values):
    data = yaml.safe_load(SCENARIO.read_text(encoding="utf-8"))
    with pytest.raises(ConfigurationError) as error:
        build(ScenarioConfig, {**data, **values}, "file.yaml")
    text = str(error.value)
    assert text.startswith("file.yaml: ")
    assert message in text
    assert "\n" not in text


def test_a_missing_key_is_named():
    data = yaml.safe_load(SCENARIO.read_text(encoding="utf-8"))
    del data["rate"]
    with pytest.raises(ConfigurationError, match="key 'rate' is missing"):
        build(ScenarioConfig, data, "file.yaml")


def copy_of_config(folder):
    """Copy the configuration to change it."""
    for name in ("robots", "stacks", "scenarios"):
        (folder / name).mkdir()
        for path in (CONFIG / name).glob("*.yaml"):
            (folder / name / path.name).write_bytes(path.read_bytes())
    return folder / "scenarios" / SCENARIO.name


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"initial_stack": "dance"}, "initial_stack: unknown 'dance'; known: "),
        ({"events": [{"at": 1.0, "switch": "dance"}]}, "events[0].switch: unknown 'dance'"),
        ({"robots": {"robot_a": {"model": "r2d2", "base": [0, 0, 0]}}}, "r2d2.yaml"),
        ({"name": "other"}, "name: expected"),
    ],
)
def test_what_a_scenario_names_must_be_there(tmp_path, values, message):
    path = copy_of_config(tmp_path)
    data = yaml.safe_load(path.read_text(encoding="utf-8"))
    for key in ("ee_target", "base_target", "events"):
        if "robots" in values:
            data.pop(key, None)
    path.write_text(yaml.safe_dump({**data, **values}), encoding="utf-8")
    if "name" in values:
        # A scenario may be any file; robots and stacks bear their file's name.
        robot = tmp_path / "robots" / "panda_summit.yaml"
        robot.write_text(robot.read_text(encoding="utf-8").replace("name: panda_summit", "name: x"))
    with pytest.raises(ConfigurationError) as error:
        load_scenario(path)
    assert message in str(error.value)


@pytest.mark.parametrize("text", ["a: [1", "- 1\n- 2\n", "\x00"])
def test_a_file_that_is_no_mapping_is_refused(tmp_path, text):
    path = tmp_path / "scenario.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ConfigurationError) as error:
        load_scenario(path)
    assert str(path) in str(error.value)
    assert "\n" not in str(error.value)


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(ConfigurationError, match="cannot be read"):
        load_scenario(tmp_path / "none.yaml")


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("home", [0.0], "home: expected 7 values, got 1"),
        ("velocity", [0.0] * 7, "velocity[0]: must be finite and > 0"),
        ("home", [9.0] * 7, "panda_joint1: home is outside the position limits"),
        ("position_lower", [3.0] * 7, "panda_joint1: position_lower >= position_upper"),
    ],
)
def test_a_wrong_arm_is_named(tmp_path, key, value, message):
    data = yaml.safe_load((CONFIG / "robots" / "panda_summit.yaml").read_text(encoding="utf-8"))
    broken = copy.deepcopy(data)
    broken["arm"][key] = value
    path = tmp_path / "panda_summit.yaml"
    path.write_text(yaml.safe_dump(broken), encoding="utf-8")
    with pytest.raises(ConfigurationError) as error:
        load_robot(path)
    assert message in str(error.value)
    assert "arm" in str(error.value)


@pytest.mark.parametrize(
    ("levels", "message"),
    [
        ([], "levels: a stack needs at least one level"),
        ([{"tasks": []}], "tasks: a level needs at least one task"),
        ([{"tasks": [{"type": "base", "weight": 0.0}]}], "weight: must be finite and > 0"),
    ],
)
def test_a_wrong_stack_is_named(levels, message):
    with pytest.raises(ConfigurationError) as error:
        build(StackConfig, {"name": "s", "description": "", "levels": levels}, "s.yaml")
    assert message in str(error.value)


@pytest.mark.parametrize(
    ("text", "advice"),
    [
        ("1.0e9", ", which YAML reads as text: write 1.0e+9"),
        ("1e9", ", which YAML reads as text: write 1.0e+9"),
        ("-2.5E3", ", which YAML reads as text: write -2.5e+3"),
        ("1e-3", ", which YAML reads as text: write 1.0e-3"),
        ("1.e3", ", which YAML reads as text: write 1.0e+3"),
        (".5e2", ", which YAML reads as text: write 0.5e+2"),
        ("fast", ""),
        ("e9", ""),
        ("9" * 400 + "e1", ""),
    ],
)
def test_a_number_that_yaml_reads_as_text_is_told_how_to_write(text, advice):
    rate = yaml.safe_load(f"rate: {text}")["rate"]
    assert isinstance(rate, str)
    data = yaml.safe_load(SCENARIO.read_text(encoding="utf-8")) | {"rate": rate}
    with pytest.raises(ConfigurationError) as error:
        build(ScenarioConfig, data, "s.yaml")
    assert str(error.value).startswith("s.yaml: rate: expected float, got '")
    assert str(error.value).rpartition("'")[2] == advice


def test_what_the_advice_says_is_a_number_for_yaml():
    assert yaml.safe_load("a: 1.0e+9") == {"a": 1.0e9}
    assert yaml.safe_load("a: -2.5e+3") == {"a": -2500.0}
