"""Robots, stacks and scenarios in folders of the user's own."""

import argparse

import pytest
import yaml

from lexstack.errors import ConfigurationError
from lexstack_bringup.commands.demo import resolve_scenario
from lexstack_config.parts import Parts
from lexstack_config.resolved import load_scenario
from support.scenario import CONFIG

ROBOT = """
name: my_arm
arm: {description: my_arm.urdf, acceleration: 5.0}
"""
STACK = """
name: mine
description: The tool first.
robots: [arm]
levels:
  - tasks: [{type: ee_pose}]
  - tasks: [{type: minimum_velocity}]
"""
SCENARIO = """
name: own
description: An arm on a table.
robots: {arm: {model: my_arm, base: [0.5, 0.0, 1.0], z: 0.7}}
rate: 100.0
duration: 2.0
initial_stack: mine
transition: {duration: 0.5}
"""
TASK = {"name": "t", "kind": "ee_position", "points": [[0.5, 0.0, 1.0]]}


@pytest.fixture
def own(tmp_path):
    """Return a folder with a URDF, its robot, a stack and a scenario beside each other."""
    links = '<link name="a"/><link name="b"/><link name="c"/>'
    joint = (
        '<joint name="j{0}" type="revolute"><parent link="{1}"/><child link="{2}"/>'
        '<origin xyz="0 0 .3"/><axis xyz="0 {0} -1"/>'
        '<limit lower="-2" upper="2" velocity="1" effort="9"/></joint>'
    )
    urdf = f'<robot name="r">{links}{joint.format(0, "a", "b")}{joint.format(1, "b", "c")}</robot>'
    (tmp_path / "my_arm.urdf").write_text(urdf)
    for name, text in {"my_arm": ROBOT, "mine": STACK, "own": SCENARIO}.items():
        (tmp_path / f"{name}.yaml").write_text(text)
    return tmp_path


def options(scenario, *config):
    """Return a command line's values."""
    return argparse.Namespace(scenario=str(scenario), config=list(config), mode=None, seed=None)


def test_what_lies_beside_a_scenario_is_found_before_lexstack_s_own(own):
    resolved = resolve_scenario(CONFIG, options(own / "own.yaml"))
    assert resolved.robots["my_arm"].arm.joints == ("j0", "j1")
    assert "mine" in resolved.stacks
    assert "track" in resolved.stacks, "lexstack's own are there too"
    assert "reach_base" in resolved.unfit
    assert "has no base" in resolved.unfit["reach_base"]
    robot = Parts.of(resolved).team.robots[0]
    assert robot.mounting.position.tolist() == [0.5, 0.0, 0.7]


def test_folders_of_the_command_line_come_first(own, tmp_path_factory):
    other = tmp_path_factory.mktemp("other")
    (other / "robots").mkdir()
    text = ROBOT.replace("my_arm.urdf", str(own / "my_arm.urdf")).replace("5.0", "3.0")
    (other / "robots" / "my_arm.yaml").write_text(text)
    (other / "scenarios").mkdir()
    (other / "scenarios" / "elsewhere.yaml").write_text(SCENARIO)
    resolved = resolve_scenario(CONFIG, options(own / "own.yaml", other))
    assert resolved.robots["my_arm"].arm.acceleration == (3.0, 3.0)
    both = resolve_scenario(CONFIG, options("elsewhere", other, own))
    assert both.robots["my_arm"].arm.acceleration == (3.0, 3.0)
    assert "mine" in both.stacks
    with pytest.raises(ConfigurationError, match="--config: there is no folder"):
        resolve_scenario(CONFIG, options("elsewhere", other / "none"))


def test_the_scenario_of_a_run_s_folder_can_be_run_again(own, tmp_path_factory):
    resolved = resolve_scenario(CONFIG, options(own / "own.yaml"))
    run = tmp_path_factory.mktemp("run") / "scenario.yaml"
    run.write_text(resolved.to_yaml())
    again = resolve_scenario(CONFIG, options(run))
    assert again.scenario == resolved.scenario
    assert again.robots == resolved.robots
    assert again.stacks == resolved.stacks


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"base_target": {"arm": [0.0, 0.0, 0.0]}}, "base_target: robot 'arm' has no base"),
        (
            {"events": [{"at": 1.0, "base_target": {"arm": [0.0, 0.0, 0.0]}}]},
            "events[0].base_target: robot 'arm' has no base",
        ),
        ({"initial_stack": "reach_base"}, "reach_base.yaml: levels["),
        (
            {"sequences": {"s": {"robot": "arm", "tasks": [TASK]}}},
            "sequences.s: robot: 'arm' follows plans on the stack 'plan_arm': ",
        ),
    ],
)
def test_a_base_that_is_not_there_is_refused_in_one_line(own, changes, text):
    path = own / "own.yaml"
    path.write_text(yaml.safe_dump({**yaml.safe_load(path.read_text()), **changes}))
    with pytest.raises(ConfigurationError) as caught:
        resolve_scenario(CONFIG, options(path))
    assert text in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_robot_that_drives_has_no_height(own):
    path = own / "own.yaml"
    path.write_text(SCENARIO.replace("my_arm", "panda_summit"))
    with pytest.raises(ConfigurationError, match=r"robots\.arm\.z: only a robot without a base"):
        load_scenario(path, CONFIG)
