"""The default posture is not singular: a switch after it needs a part of what the limits allow."""

import dataclasses
import itertools

import numpy as np
import pytest

from lexstack.errors import ConfigurationError
from lexstack.options import build
from lexstack.robots import RobotModel
from lexstack_config.parts import build_team
from lexstack_config.resolved import load_robot
from lexstack_config.scenario import EventConfig
from lexstack_experiments.ideal import IdealPlant
from lexstack_experiments.loop import Loop
from support.scenario import CONFIG, changed

AT = (1.0, 9.0, 17.0)  # s
END = 21.0  # s


def peaks(posture):
    """Return the peak acceleration over its limit after each of three switches."""
    events = tuple(
        EventConfig(at=time, switch=stack)
        for time, stack in zip(AT, ("reach_base", posture, "reach_base"), strict=True)
    )
    resolved = changed(events=events, duration=END)
    team = build_team(resolved)
    record = Loop(resolved, IdealPlant(resolved, team)).run()
    chi = np.array([command.chi for command in record.commands])
    ratio = np.abs(np.diff(chi, axis=0)) / (team.dt * team.limits.acceleration)
    ticks = [round(time / team.dt) - 1 for time in (*AT, END)]
    return [ratio[a:b].max() for a, b in itertools.pairwise(ticks)]


@pytest.mark.slow
def test_reach_base_after_posture_leaves_three_quarters_of_the_acceleration_limit():
    """At the Panda's mid-range, on its shoulder singularity, the whole limit is used up."""
    assert peaks("posture_mid_range")[2] == pytest.approx(1.0, abs=1e-9)
    first, second, third = peaks("posture")
    assert first < 0.13
    assert second < 0.25
    assert third < 0.30


@pytest.mark.parametrize(("name", "least"), [("panda_summit", 0.21), ("ur10_ridgeback", 0.31)])
def test_the_default_posture_is_not_singular(name, least):
    robot = RobotModel("one", load_robot(CONFIG / f"robots/{name}.yaml"))
    found = {}
    for title, arm in (("posture", robot.posture), ("mid-range", robot.mid_range)):
        jacobian = robot.tool(np.concatenate((np.zeros(3), arm)))[1][:, 3:]
        found[title] = np.linalg.svd(jacobian, compute_uv=False)[-1]
    assert found["posture"] > least
    assert found["mid-range"] < 0.7 * found["posture"]


def test_a_posture_outside_the_position_limits_is_refused():
    robot = load_robot(CONFIG / "robots/panda_summit.yaml")
    wrong = (0.0, -2.0, *robot.arm.posture[2:])
    for posture, message in (
        (wrong, "panda_joint2: posture is outside the position limits"),
        (wrong[:3], "posture: expected 7 values, got 3"),
    ):
        arm = dataclasses.replace(robot.arm, posture=posture)
        with pytest.raises(ConfigurationError, match=message):
            build(type(arm), arm, "here")
