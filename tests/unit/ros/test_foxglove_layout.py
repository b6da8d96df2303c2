"""The layouts of Foxglove and RViz: every topic and field that they name is one of ours."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest
import yaml
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from lexstack_bag.storage.definitions import message_definition
from lexstack_bag.topics import ONLOOKERS, contract_topics
from lexstack_ros.view.markers import MARKERS

CONFIG = Path(__file__).parents[3] / "config"
LAYOUT = CONFIG / "foxglove/lexstack.json"
ROBOTS = ("robot_a", "robot_b")
LATCHED = {
    f"/{robot}/{topic}": kind
    for robot in ROBOTS
    for topic, kind in (
        ("robot_description", "std_msgs/msg/String"),
        ("ee_reference", "geometry_msgs/msg/PoseStamped"),
    )
}
TOPICS = contract_topics(ROBOTS) | ONLOOKERS | LATCHED
PANELS = {"3D", "Plot", "StateTransitions", "DiagnosticSummary", "RawMessages"}


def layout() -> dict[str, Any]:
    return json.loads(LAYOUT.read_text(encoding="utf-8"))


def paths(content: dict[str, Any]) -> list[str]:
    """Return every message path of every panel."""
    found = []
    for panel in content["configById"].values():
        found += [path["value"] for path in panel.get("paths", [])]
        found += list(panel.get("topics", {}))
        found += [panel[key] for key in ("topicPath", "topicToRender") if key in panel]
        layers = panel.get("layers", {}).values()
        found += [layer["topic"] for layer in layers if "topic" in layer]
    return found


def check(path: str) -> None:
    """Raise KeyError or ValueError where a path leads to nothing."""
    topic, *fields = path.split(".")
    name = TOPICS[topic]
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(message_definition(name), name))
    for step in fields:
        field, index = re.fullmatch(r"(\w+)(\[\d+\])?", step).groups()
        members = dict(store.fielddefs[name][1])
        kind, value = members[field]
        if int(kind) in (3, 4):  # array, sequence
            if not index:
                raise ValueError(f"{path}: {field} is a list")
            kind, value = value[0]
        elif index:
            raise ValueError(f"{path}: {field} is no list")
        name = value if int(kind) == 2 else ""
        if not name and step != fields[-1]:
            raise ValueError(f"{path}: {field} has no fields")


@pytest.mark.parametrize("path", paths(layout()))
def test_every_path_leads_to_a_field_of_our_messages(path):
    check(path)


@pytest.mark.parametrize(
    "path",
    [
        "/robot_a/transition.alfa",
        "/robot_c/chi.solve_time",
        "/robot_a/chi.slacks",
        "/robot_a/chi.solve_time[0]",
        "/robot_a/ee_pose.pose.position.w",
        "/robot_a/chi.stack.name",
    ],
)
def test_a_wrong_path_is_found(path):
    with pytest.raises((KeyError, ValueError)):
        check(path)


def test_every_panel_is_shown_once():
    def panels(node):
        if isinstance(node, str):
            return [node]
        assert node["direction"] in ("row", "column")
        assert 0 < node["splitPercentage"] < 100
        return panels(node["first"]) + panels(node["second"])

    content = layout()
    assert sorted(panels(content["layout"])) == sorted(content["configById"])
    assert {name.partition("!")[0] for name in content["configById"]} == PANELS


def test_it_shows_what_a_run_is_about():
    shown = paths(layout())
    for path in (
        "/robot_a/chi.transitions[0].alpha",
        "/robot_a/transition.phase",
        "/robot_a/transition.to_stack",
        "/robot_a/chi.slacks[0]",
        "/robot_b/chi.solve_time",
        "/diagnostics",
        "/robot_b/ee_target",
        "/robot_a/robot_description",
        MARKERS,
    ):
        assert path in shown


DISPLAYS = {  # of RViz, and the types that they take
    "RobotModel": ("Description Topic", "std_msgs/msg/String"),
    "MarkerArray": ("Topic", "visualization_msgs/msg/MarkerArray"),
    "Pose": ("Topic", "geometry_msgs/msg/PoseStamped"),
    "SetGoal": ("Topic", "geometry_msgs/msg/PoseStamped"),
}


def test_rviz_draws_topics_of_ours_in_the_world():
    manager = yaml.safe_load((CONFIG / "rviz/lexstack.rviz").read_text(encoding="utf-8"))
    manager = manager["Visualization Manager"]
    assert manager["Global Options"]["Fixed Frame"] == "world"
    heard = {}
    for display in (*manager["Displays"], *manager["Tools"]):
        key, kind = DISPLAYS.get(display["Class"].rpartition("/")[2], ("", ""))
        if key:
            topic = display[key]["Value"]
            assert TOPICS[topic] == kind, topic
            heard[topic] = display[key]
    assert heard[MARKERS]["Reliability Policy"] == "Best Effort"
    for topic in LATCHED:
        assert heard[topic]["Durability Policy"] == "Transient Local"
