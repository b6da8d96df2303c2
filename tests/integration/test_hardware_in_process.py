"""Adapter and stand-in in one process: a delivery, switches, torques; with all habits."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from lexstack import StackConfig
from lexstack.robots import DifferentialConfig
from lexstack_config.resolved import load_scenario
from lexstack_experiments.experiments.hardware_cases import plant_of, switches
from lexstack_experiments.loop import Loop
from lexstack_testing.stand_in.habits import ALL, Habits
from lexstack_testing.stand_in.in_process import HardwareInProcess
from support.planned_loop import PlannedLoop
from support.scenario import CONFIG

pytestmark = pytest.mark.timeout(300)


def on_hardware(loop, habits, plant=None):
    """Put a loop on the stand-in; return the adapter with it."""
    found = plant or plant_of(CONFIG)
    loop.plant = HardwareInProcess(loop.resolved, loop.parts.team, found, habits)
    return loop.plant


def well(hardware):
    assert not hardware.robots.stopped()
    assert not hardware.adapter.reason


@cache
def delivery():
    return load_scenario(CONFIG / "scenarios/deliver-one.yaml")


@pytest.mark.slow
def test_a_delivery_takes_as_long_as_in_mujoco_alone():
    ends = []
    for habits in (None, ALL):
        loop = PlannedLoop(delivery())
        hardware = None if habits is None else on_hardware(loop, habits)
        loop.run(1300)
        if hardware is not None:
            well(hardware)
        progress = loop.progress("deliver")
        ends.append(next(k for k, each in enumerate(progress) if each.sequence.done))
    assert ends[1] == pytest.approx(ends[0], abs=4)  # plans, 20 per second


@pytest.mark.parametrize("number", range(3))
def test_no_drive_stops_at_a_random_switch(number):
    case = list(switches(CONFIG, "bridge", 1, 3))[number]
    loop = Loop(case.resolved)
    hardware = on_hardware(loop, ALL)
    loop.run()
    well(hardware)
    peaks = hardware.robots.robots["robot_a"].drive.peaks
    assert (peaks <= 1.0).all()
    assert peaks[1] > 0.1


def test_every_drive_stops_at_an_instant_switch_if_the_adapter_lets_it():
    (case,) = switches(CONFIG, "instant", 1, 1)
    loop = Loop(case.resolved)
    for check in (True, False):
        hardware = HardwareInProcess(
            case.resolved, loop.parts.team, plant_of(CONFIG), ALL, check=check
        )
        loop = Loop(case.resolved, plant=hardware)
        loop.run()
        assert bool(hardware.robots.stopped()) != check
        assert ("exceeds the acceleration limit" in hardware.adapter.reason) == check


@pytest.mark.parametrize(
    ("kind", "habits"),
    [("velocity", Habits()), ("effort", Habits(rate=500.0)), ("joint_trajectory", Habits())],
)
def test_every_interface_leads_the_tool_within_a_millimetre(kind, habits):
    (case,) = switches(CONFIG, "bridge", 2, 1)
    found = plant_of(CONFIG)
    robots = {
        n: replace(r, arm=replace(r.arm, type=kind, ahead=2)) for n, r in found.robots.items()
    }
    loop = Loop(case.resolved)
    hardware = on_hardware(loop, replace(habits, reflex=False), replace(found, robots=robots))
    still = Loop(case.resolved)
    loop.run()
    still.run()
    assert not hardware.adapter.reason
    tools = [each.parts.team.tools(each.record.states[-1].q)[0] for each in (loop, still)]
    assert np.linalg.norm(tools[0].position - tools[1].position) < 1e-2


def parking():
    """Return a Panda on a differential platform that is to park, and its plant."""
    whole = load_scenario(CONFIG / "scenarios" / "transition-sequence.yaml")
    robot = whole.robots["panda_summit"]
    platform = DifferentialConfig(velocity=(1.0, 2.0), acceleration=(1.0, 2.0), jerk=(100.0, 200.0))
    stack = StackConfig.of_tasks("park", "base", "posture")
    scenario = replace(
        whole.scenario,
        robots={"robot_a": whole.scenario.robots["robot_a"]},
        base_target={"robot_a": (-0.4, 0.3, 0.6)},
        initial_stack="park",
        events=(),
        duration=9.0,
    )
    resolved = replace(
        whole,
        scenario=scenario,
        robots={"panda_summit": replace(robot, base=platform)},
        stacks={"park": stack},
    )
    plant = plant_of(CONFIG)
    return resolved, replace(plant, robots={"robot_a": plant.robots["robot_a"]})


def test_a_differential_platform_parks_as_in_mujoco_alone():
    resolved, plant = parking()
    alone, loop = Loop(resolved), Loop(resolved)
    hardware = on_hardware(loop, replace(ALL, drift=0.0), plant)
    for each in (alone, loop):
        each.run()
    well(hardware)
    ends = [each.record.states[-1].q[:3] for each in (alone, loop)]
    np.testing.assert_allclose(ends[0], (-0.4, 0.3, 0.6), atol=0.01)
    np.testing.assert_allclose(ends[1], ends[0], atol=2e-3)
    assert (hardware.robots.robots["robot_a"].drive.peaks <= 1.0).all()
