"""The Foxglove layout: every topic and field that it names is one of ours."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from lexstack_bag.storage.definitions import message_definition
from lexstack_bag.topics import contract_topics

LAYOUT = Path(__file__).parents[3] / "config/foxglove/lexstack.json"
TOPICS = contract_topics(("robot_a", "robot_b"))
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
        "/robot_a/transition.alpha",
        "/robot_a/transition.phase",
        "/robot_a/transition.to_stack",
        "/robot_a/chi.slacks[0]",
        "/robot_b/chi.solve_time",
        "/diagnostics",
        "/robot_b/ee_target",
    ):
        assert path in shown
