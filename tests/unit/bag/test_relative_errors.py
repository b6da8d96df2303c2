"""Objects that two robots hold, and obstacles, in the figures of a run."""

import json

import numpy as np
import pinocchio as pin
import pytest

from lexstack.robots import ObstacleConfig
from lexstack_bag.figures.goals import summary_lines
from lexstack_bag.report.tables import phases_table
from lexstack_config.resolved import load_scenario
from lexstack_config.scenario import PoseConfig
from lexstack_experiments.ideal import IdealPlant
from lexstack_experiments.loop import Loop
from lexstack_experiments.runs import analysed, changed
from support.scenario import CONFIG


class Standing(IdealPlant):
    """Robots that stay where they are, whatever they are told."""

    def step(self, chi):
        """Let a tick pass."""
        return super().step(np.zeros(20))


def measured(name, seconds, stack, plant=None, **values):
    """Return a run of a scenario on one stack."""
    resolved = load_scenario(CONFIG / "scenarios" / f"{name}.yaml")
    resolved = changed(
        resolved, initial_stack=stack, events=(), duration=seconds, mode="lockstep", **values
    )
    loop = Loop(resolved)
    if plant is not None:
        loop.plant = plant(resolved, loop.parts.team)
    loop.run()
    return loop, analysed(loop)


def pose(position, rotation):
    """Return a pose as a scenario has it."""
    return PoseConfig(tuple(position), tuple(pin.Quaternion(rotation).coeffs()))


def test_an_object_that_is_held_wrongly_is_told():
    """The reference of robot B's tool is 30 mm and 0.1 rad away from where the tool stays."""
    loop, _ = measured("carry", 0.1, "track")
    tools = loop.parts.team.tools(loop.record.states[0].q)
    turned = pin.exp3(np.array([0.0, 0.0, 0.1])) @ tools[1].rotation
    targets = {
        "robot_a": pose(tools[0].position, tools[0].rotation),
        "robot_b": pose(tools[1].position + np.array([0.0, 0.03, 0.0]), turned),
    }
    _, run = measured("carry", 1.0, "carry", Standing, ee_target=targets)
    phase = run.metrics.phases[0]
    assert phase.relative_error_mm == {"robot_a": pytest.approx(30.0), "robot_b": None}
    assert phase.relative_error_mrad == {"robot_a": pytest.approx(100.0), "robot_b": None}
    assert phase.relative_peak_error_mm == {"robot_a": pytest.approx(30.0), "robot_b": None}
    assert phase.obstacle_distance_mm is None
    assert "object [mm]: carry 30.00 / –" in summary_lines(run.metrics)
    assert "robot_a, object, peak [mm]" in phases_table(run.metrics)
    assert json.loads(run.metrics.to_json())["phases"][0]["relative_error_mm"]["robot_b"] is None


def test_a_stack_without_an_object_has_no_such_figures():
    _, run = measured("carry", 0.2, "track")
    phase = run.metrics.phases[0]
    assert phase.relative_error_mm is phase.relative_peak_error_mrad is None
    assert not any("object" in line for line in summary_lines(run.metrics))
    assert "object" not in phases_table(run.metrics)


def test_the_least_distance_to_an_obstacle_is_told_for_each_robot():
    """A ball flies over both robots, 0.15 m beside their wrists."""
    ball = ObstacleConfig((-5.0, 0.154, 4.0), 0.1, velocity=(2.5, 0.0, 0.0))
    far = ObstacleConfig((2.0, 9.0, 0.5), 0.1)
    _, run = measured("obstacle", 4.0, "track", Standing, obstacles={"ball": ball, "far": far})
    distance = run.metrics.phases[0].obstacle_distance_mm
    # The wrist is the highest: link6[1] at (0.304, -0.0005, 1.2168), radius 0.07.
    above = 1e3 * (np.hypot(4.0 - 1.2168, 0.1545) - 0.07 - 0.1)
    assert distance["robot_a"] == pytest.approx(above, abs=5.0)
    assert distance["robot_b"] == pytest.approx(above, abs=5.0)
    lines = [line for line in summary_lines(run.metrics) if line.startswith("nearest obstacle")]
    assert len(lines) == 1
