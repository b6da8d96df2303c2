"""Units of joints follow their type: a lift slides in m, whatever its place."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from lexstack_bag.figures.export import _VELOCITY, _entries
from lexstack_bag.replay.outcome import joints_of
from lexstack_bag.report import control, switches
from support.lift import JOINTS, lift_scenario, lift_team
from support.scenario import team


def test_a_joint_that_slides_is_known_by_its_type(tmp_path):
    (robot,) = lift_team(tmp_path).robots
    assert robot.joints == ("base_x", "base_y", "base_yaw", *JOINTS)
    assert robot.prismatic == (True, True, False, True, False, False, False)
    assert team().robots[0].prismatic == (True, True, *[False] * 8)


def test_names_in_tables_and_replays_carry_the_unit_of_the_type(tmp_path):
    lifted = lift_team(tmp_path)
    units = {joint: unit for _, joint, unit in _entries(lifted, _VELOCITY)}
    assert (units["base_x"], units["base_yaw"]) == ("m/s", "rad/s")
    assert (units["lift"], units["a1"]) == ("m/s", "rad/s")
    replayed = {joint.name: joint.unit for joint in joints_of(lifted)}
    assert (replayed["robot_a/lift"], replayed["robot_a/a2"]) == ("m/s", "rad/s")


def test_choices_of_a_joint_in_the_report_carry_the_unit_of_the_type(tmp_path):
    lifted = lift_team(tmp_path)
    labels = control.joints(SimpleNamespace(team=lambda: lifted))
    assert labels[:3] == (
        "robot_a base x [m/s]",
        "robot_a base y [m/s]",
        "robot_a base yaw [rad/s]",
    )
    assert labels[3:5] == ("robot_a arm joint 1 (lift) [m/s]", "robot_a arm joint 2 (a1) [rad/s]")


def test_the_axis_of_an_arm_with_a_lift_names_both_units(tmp_path):
    (robot,) = lift_team(tmp_path).robots
    assert switches._arm_units(robot) == ["m/s", "rad/s"]
    assert switches._arm_units(team().robots[0]) == ["rad/s"]


def test_the_stop_of_a_lift_is_millimetres_beyond_its_limit(tmp_path):
    """As an angle it would be 1 degree, 17 mm if it is taken for a length."""
    from lexstack_sim.world import SLIDE_STOP_MARGIN, STOP_MARGIN, build_world

    scenario = lift_scenario(tmp_path)
    arm = replace(scenario.robots["lift"].arm)
    world = build_world(lift_team(tmp_path))
    ranges = {world.joint(i).name.split("/")[-1]: world.joint(i).range for i in range(world.njnt)}
    assert SLIDE_STOP_MARGIN <= 0.005
    expected = np.array([arm.position_lower[0] - SLIDE_STOP_MARGIN, 0.4 + SLIDE_STOP_MARGIN])
    assert ranges["lift"] == pytest.approx(expected)
    assert ranges["a1"] == pytest.approx([-2.9 - STOP_MARGIN, 2.9 + STOP_MARGIN])
