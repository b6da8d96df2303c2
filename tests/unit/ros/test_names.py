"""Names: relative in every node, so that a namespace moves them all; plain again in analysis."""

from __future__ import annotations

import argparse
import ast

import pytest

from lexstack.errors import ConfigurationError
from lexstack_bag.topics import plain_name, role_names
from lexstack_bringup.naming import Naming, add_naming_arguments
from lexstack_bringup.processes import arguments_of
from support.scenario import ROOT

MAKERS = {"create_publisher": 1, "create_subscription": 1, "create_service": 1, "create_client": 1}
MAKERS |= {"ActionClient": 2, "GoalServer": 2}  # the place of the name among the arguments
SOURCES = [
    path
    for package in ("lexstack_ros", "lexstack_plant", "lexstack_bringup")
    for path in sorted((ROOT / "ros2_ws/src" / package / package).rglob("*.py"))
]
# These take names that others have made; those of real robots stand in the plant's file.
ANY = {"recorder/topics.py", "node/calls.py", "hardware/topics.py", "view/foxglove.py"}
ANY |= {"finding/graph.py"}


def absolute(source: str) -> list[str]:
    """Return the names of topics and services that a source makes absolute."""
    found = []
    for node in ast.walk(ast.parse(source)):
        if not isinstance(node, ast.Call):
            continue
        maker = getattr(node.func, "attr", getattr(node.func, "id", ""))
        if maker not in MAKERS:
            continue
        name = node.args[MAKERS[maker]]
        if isinstance(name, ast.JoinedStr):
            name = name.values[0]
        text = ast.unparse(name)
        is_relative = isinstance(name, ast.FormattedValue) or text.startswith("relative(")
        if not is_relative and not (isinstance(name, ast.Constant) and name.value[0] != "/"):
            found.append(text)
    return found


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: path.name)
def test_no_node_makes_an_absolute_name(path):
    if not any(str(path).endswith(name) for name in ANY):
        assert absolute(path.read_text(encoding="utf-8")) == []


def test_an_absolute_name_is_seen():
    for name in ('"/plant/state"', "PLAN", 'f"/{name}/odom"'):
        assert absolute(f"node.create_publisher(Kind, {name}, 10)")
    for name in ('"plant/state"', "relative(PLAN)", 'f"{name}/odom"', '"~/pause"'):
        assert not absolute(f"node.create_publisher(Kind, {name}, 10)")


@pytest.mark.parametrize(
    ("topic", "namespace", "plain"),
    [
        ("/plant/state", "", "/plant/state"),
        ("/cell1/plant/state", "/cell1", "/plant/state"),
        ("/cell1/controller/chi", "/cell1", "/robot_a/chi"),
        ("/solver/references", "", "/robot_b/references"),
        ("/controller/ee_target", "", "/controller/ee_target"),  # of a robot with that name
        ("/cell12/plant/state", "/cell1", ""),
        ("/rosout", "/cell1", ""),
        ("/cell1/plant/state", "", "/cell1/plant/state"),
    ],
)
def test_analysis_knows_topics_by_their_plain_names(topic, namespace, plain):
    assert plain_name(topic, namespace) == plain


def naming(*arguments: str) -> Naming:
    parser = argparse.ArgumentParser()
    add_naming_arguments(parser)
    return Naming.of(parser.parse_args(arguments))


def test_without_options_a_node_is_started_as_ever():
    assert naming() == Naming()
    assert arguments_of("recorder", {"a": "b"}) == ["--ros-args", "-p", "a:=b"]


def test_a_namespace_moves_a_node_and_its_clock():
    given = arguments_of("stack_solver_2", {}, naming("--namespace", "/hall/cell1"))
    assert "-r __ns:=/hall/cell1 -r /clock:=clock -r __node:=stack_solver_2" in " ".join(given)


def test_roles_rename_every_topic_and_service_of_the_two_computers():
    rules = naming("--roles").rules
    assert "robot_a/chi:=controller/chi" in rules
    assert "robot_b/chi:=solver/chi" in rules
    assert "robot_a/switch_stack:=controller/switch_stack" in rules
    assert len(rules) == 2 * len(role_names())


@pytest.mark.parametrize("wrong", ["a b", "1cell", "cell1/", "a//b", "~", "x" * 101, "é"])
def test_what_is_no_namespace_is_refused(wrong):
    with pytest.raises(ConfigurationError, match="--namespace: expected names of letters"):
        naming("--namespace", wrong)
