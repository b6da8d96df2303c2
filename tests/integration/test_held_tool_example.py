"""The example of docs/htmpc.md: how far the held tool is off, as the page says."""

import dataclasses
import re

import numpy as np
import pytest

from lexstack.mpc import SequenceConfig
from lexstack_config.reader import build
from lexstack_config.resolved import load_scenario
from lexstack_config.scenario import EventConfig
from lexstack_experiments.ideal import IdealPlant
from support.planned_loop import PlannedLoop
from support.scenario import CONFIG, ROOT

GOAL = np.array([0.8, 0.3, 1.0])  # m
GIVE = {"name": "give", "kind": "ee_position", "points": [[0.8, 0.3, 1.0]], "held": True}
DRIVE = {
    "name": "drive",
    "kind": "base_position",
    "points": [[0.0, 1.0]],
    "speed": 0.3,
    "tolerance": 0.05,
}


def errors(give, *, ideal=False):
    """Return how far the tool is off tick by tick [mm]; the sequence begins at tick 100."""
    found = load_scenario(CONFIG / "scenarios/by-hand.yaml")
    sequence = build(SequenceConfig, {"robot": "robot_a", "tasks": [give, DRIVE]}, "page")
    scenario = dataclasses.replace(
        found.scenario,
        sequences={"example": sequence},
        events=(EventConfig(at=1.0, execute=("example",)),),
        mode="lockstep",
    )
    resolved = dataclasses.replace(found, scenario=scenario)
    loop = PlannedLoop(resolved)
    if ideal:
        loop.plant = IdealPlant(resolved, loop.parts.team)
    far = []
    for _ in range(600):
        loop.step()
        tool = loop.parts.team.tools(loop.plant.state().q)[0].position
        far.append(1e3 * float(np.linalg.norm(tool - GOAL)))
    return np.array(far)


def test_the_page_shows_this_example():
    text = (ROOT / "docs/htmpc.md").read_text(encoding="utf-8")
    assert re.search(r'task\("give", "ee_position", 0.8, 0.3, 1.0, speed=0.3, held=True\)', text)
    assert re.search(r'task\("drive", "base_position", 0.0, 1.0, speed=0.3, tolerance=0.05\)', text)


def test_the_held_tool_of_the_example_comes_to_rest_as_the_page_says():
    far = errors({**GIVE, "speed": 0.3})
    assert far[300:].max() < 6.0, "when it arrives"
    assert far[450:].max() < 1.1, "1.5 s later"


@pytest.mark.parametrize(("ideal", "soon", "later"), [(False, 12.5, 3.5), (True, 0.9, 0.2)])
def test_a_reference_that_jumps_rings_because_the_arm_follows_late(ideal, soon, later):
    far = errors(GIVE, ideal=ideal)
    assert 0.5 * soon < far[200:250].max() < soon
    assert 0.5 * later < far[250:300].max() < later
