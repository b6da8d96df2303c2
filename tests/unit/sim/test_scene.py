"""What a viewer gets: every robot that is configured, small, and without what moves by itself."""

from __future__ import annotations

import base64
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from lexstack.robots import ObstacleConfig
from lexstack_config.parts import build_team
from lexstack_config.resolved import load_robot
from lexstack_config.scenario import PlacementConfig
from lexstack_sim.scene import scene
from support.scenario import resolved

ROBOTS = sorted((Path(__file__).parents[3] / "config/robots").glob("*.yaml"))
SMALL = next(path for path in ROBOTS if path.stem == "panda_summit")


def team_of(path, **changes):
    base = resolved()
    places = {
        "robot_a": PlacementConfig(path.stem, (0.0, 0.0, 0.0)),
        "robot_b": PlacementConfig(path.stem, (2.0, 0.0, 0.0)),
    }
    scenario = replace(base.scenario, robots=places, **changes)
    return build_team(replace(base, scenario=scenario, robots={path.stem: load_robot(path)}))


@pytest.mark.parametrize("path", ROBOTS, ids=lambda path: path.stem)
def test_every_robot_can_be_drawn(path):
    team = team_of(path)
    found = scene(team)
    assert len(json.dumps(found)) < 900_000
    assert found["robots"] == ["robot_a", "robot_b"]
    joints = [joint for body in found["bodies"] for joint in body["joints"]]
    assert {joint["index"] for joint in joints} == set(range(team.nq))
    leading = [joint for joint in joints if (joint["ratio"], joint["offset"]) == (1.0, 0.0)]
    assert len(leading) >= team.n
    assert all(body["parent"] < place for place, body in enumerate(found["bodies"]))
    parts = [part for body in found["bodies"] for part in body["parts"]]
    assert {part["mesh"] for part in parts if part["kind"] == "mesh"} == set(
        range(len(found["meshes"]))
    )
    for mesh in found["meshes"]:
        vertices = np.frombuffer(base64.b64decode(mesh["vertices"]), "<u2").reshape(-1, 3)
        faces = np.frombuffer(base64.b64decode(mesh["faces"]), "<u4" if mesh["wide"] else "<u2")
        assert faces.max() < len(vertices)
        assert len(faces) % 3 == 0
        size = np.array(mesh["step"]) * np.ptp(vertices.astype(float), axis=0)
        assert 0.001 < size.max() < 1.5  # m


def test_robots_of_one_kind_share_their_meshes():
    two = scene(team_of(SMALL))
    assert len({part["mesh"] for b in two["bodies"] for part in b["parts"] if "mesh" in part}) < (
        sum("mesh" in part for b in two["bodies"] for part in b["parts"])
    )


def test_obstacles_are_left_to_the_viewer():
    ball = {"ball": ObstacleConfig(position=(1.0, 2.0, 0.5), radius=0.2)}
    without, with_ball = (scene(team_of(SMALL, obstacles=o)) for o in ({}, ball))
    assert without == with_ball
