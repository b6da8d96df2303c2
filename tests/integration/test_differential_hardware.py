"""A robot on a differential base behind the adapter: TIAGo drives arcs, parks, and is stopped."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import lexstack
from lexstack.robots import wrap
from lexstack.types import PlantStatus
from lexstack_config.parts import build_team
from lexstack_config.plant_file import check_plant, load_plant
from lexstack_config.resolved import load_scenario
from lexstack_plant.hardware.base_intake import BaseSample
from lexstack_plant.hardware.joint_intake import JointSample
from lexstack_plant.hardware.memory import Phase
from lexstack_sim.impedance import gravity
from lexstack_testing.stand_in.habits import ALL, Habits
from lexstack_testing.stand_in.in_process import HardwareInProcess
from support.differential import loop
from support.ideal_hardware import IdealHardware
from support.scenario import CONFIG

PLANT = CONFIG / "plants" / "tiago.yaml"
GOAL = (-0.6, 0.9, 1.2)  # m, m, rad
START = (0.5, 0.2, 0.4)


@cache
def scenario():
    """Return scenario drive, begun elsewhere and with the stack that parks the base."""
    given = load_scenario(CONFIG / "scenarios" / "drive.yaml")
    place = {"robot_a": replace(given.scenario.robots["robot_a"], base=START)}
    changed = replace(given.scenario, robots=place, initial_stack="reach_base", events=())
    return replace(given, scenario=changed)


@pytest.fixture
def tiago():
    return IdealHardware(load_plant(PLANT), scenario())


def driven(tiago, ticks=80, v=0.4, w=-0.6):
    """Enable TIAGo and let it drive; return the command."""
    tiago.enable()
    chi, wanted = np.zeros(tiago.team.n), np.zeros(tiago.team.n)
    wanted[:2] = v, w
    for _ in range(ticks):
        step = 0.9 * tiago.plant._rules.step_limit
        chi = chi + np.clip(wanted - chi, -step, step)
        tiago.step(chi)
    assert tiago.plant.phase is Phase.ENABLED, tiago.plant.reason
    return chi


def braked(tiago):
    """Go on until TIAGo rests; return the twists that it was sent."""
    twists = []
    while tiago.plant.phase is Phase.STOPPING:
        before = tiago.plant.state().command
        state = tiago.step()
        change = np.abs(state.command - before)
        assert (change <= tiago.team.limits.acceleration * tiago.dt * (1 + 1e-9)).all()
        twists.append(tiago.sent["robot_a"].twist)
    assert not twists[-1].any()
    return twists


def test_the_file_fits_the_scenario():
    check_plant(load_plant(PLANT), load_scenario(CONFIG / "scenarios" / "drive.yaml"), "tiago")


def test_it_is_sent_its_speed_ahead_and_its_yaw_rate(tiago):
    chi = driven(tiago)
    np.testing.assert_array_equal(tiago.sent["robot_a"].twist, [chi[0], 0.0, chi[1]])


def test_the_state_follows_the_arcs_of_the_commands(tiago):
    """Q is where the command finds the base, as if there were no delay; q* agrees."""
    state = tiago.enable()
    q, chi = state.q.copy(), np.zeros(tiago.team.n)
    assert q.shape == (tiago.team.nq,)
    for tick in range(300):
        chi[0], chi[1] = 0.3 * math.sin(0.02 * tick), 0.8 * math.sin(0.015 * tick)
        state = tiago.step(chi)
        q = tiago.team.integrate(q, chi, tiago.dt)
        np.testing.assert_allclose(state.q, q, atol=1e-9)
        np.testing.assert_allclose(state.q_star, q, atol=1e-9)
    assert state.v.shape == (tiago.team.n,)
    assert not tiago.plant.reason


def test_it_parks_and_switches_on_the_way(tiago):
    """It goes as a robot without delay would, for the controllers see one."""
    tiago.enable()
    stacks = {"park": ("base", "posture"), "rest": ("posture", "velocity_damping")}
    ends = []
    for plant in (tiago, None):
        controller, exact, run = loop(tiago.team, stacks, "park", {"robot_a": START})
        run.plant = plant or exact
        target = lexstack.Target(at=0.0, robot=0, base=np.array(GOAL))
        controller.references.add(target)
        for stack, tick in (("rest", 60), ("park", 200)):
            controller.transition.ask(stack, duration=1.0, method="bridge", at_tick=tick)
        for _ in range(1500):
            assert not run.step().fallback
            assert not tiago.plant.reason
        ends.append(run.plant.state().q)
    x, y, yaw = tiago.q[:3]
    assert math.hypot(GOAL[0] - x, GOAL[1] - y) < 5e-3
    assert abs(wrap(GOAL[2] - yaw)) < 5e-3
    assert tiago.plant.counters.clamped == 0
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-6)


@pytest.mark.parametrize("habits", [Habits(), ALL])
def test_it_parks_on_the_stand_in(habits):
    """MuJoCo's base behind odometry and twists, with all habits of hardware; it never slides."""
    given, plant = scenario(), load_plant(PLANT)
    robot = plant.robots["robot_a"]
    settled = replace(robot, arm=replace(robot.arm, ahead=5))
    team = build_team(given)
    hardware = HardwareInProcess(given, team, replace(plant, robots={"robot_a": settled}), habits)
    controller, _, run = loop(team, {"park": ("base", "posture")}, "park")
    run.plant = hardware
    controller.references.add(lexstack.Target(at=0.0, robot=0, base=np.array(GOAL)))
    for _ in range(1500):
        assert not run.step().fallback
        assert not hardware.adapter.reason
        assert hardware.commands["robot_a"].twist[1] == 0.0
    assert not hardware.robots.stopped()
    x, y, yaw = hardware.state().q[:3]
    assert math.hypot(GOAL[0] - x, GOAL[1] - y) < 5e-3
    assert abs(wrap(GOAL[2] - yaw)) < 5e-3


def test_it_is_taken_over_at_the_speed_of_whoever_drove_it(tiago):
    tiago.v[:2] = 0.2, -0.3
    state = tiago.enable()
    np.testing.assert_allclose(state.command[:2], [0.2, -0.3])
    tiago.step(state.command)
    np.testing.assert_allclose(tiago.sent["robot_a"].twist, [0.2, 0.0, -0.3])


def test_it_brakes_v_and_w_and_nothing_else(tiago):
    chi = driven(tiago)
    tiago.plant.stop("test")
    twists = braked(tiago)
    assert all(twist[1] == 0.0 for twist in twists)
    assert abs(twists[0][0]) < abs(chi[0])


def test_without_commands_it_holds_and_brakes(tiago):
    driven(tiago)
    seen = []
    while tiago.plant.phase is Phase.ENABLED:
        tiago.step()
        seen.append(tiago.plant.status)
    assert {PlantStatus.HOLDING, PlantStatus.BRAKING} <= set(seen)
    assert "no commands for" in tiago.plant.reason


@pytest.mark.parametrize(
    ("entry", "reason"),
    [((5.0, 5.0, 0.0), "the base jumped by"), ((0.0, 0.0, 2.0), "the base turned by")],
)
def test_its_pose_may_not_jump(tiago, entry, reason):
    chi = driven(tiago)
    x, y, yaw = np.add(tiago.q[:3], entry)
    turn = (0.0, 0.0, math.sin(0.5 * yaw), math.cos(0.5 * yaw))
    tiago.now += tiago.dt
    sample = BaseSample(x, y, turn, (0.0, 0.0, 0.0), tiago.now, tiago.now)
    tiago.plant.robots["robot_a"].base.hear(sample)
    tiago.plant.step(chi, tiago.now)
    assert reason in tiago.plant.reason


@pytest.mark.parametrize(("joint", "name"), [(0, "base_v"), (1, "base_w"), (2, "torso_lift")])
def test_limits_are_those_of_v_w_and_the_arm(tiago, joint, name):
    chi = driven(tiago)
    wild = chi.copy()
    wild[joint] += 3.0 * tiago.plant._rules.step_limit[joint]
    tiago.step(wild)
    assert f"exceeds the acceleration limit of robot_a/{name}" in tiago.plant.reason


def test_a_joint_beyond_its_limit_is_named(tiago):
    tiago.q[4] = -0.1  # arm_1_joint, whose lower limit is 0
    tiago.hear()
    with pytest.raises(lexstack.InputError, match=r"arm_1_joint is at -0\.1, beyond"):
        tiago.plant.enable("robot_a")


def test_a_base_that_does_not_make_its_way_is_stopped(tiago):
    chi = driven(tiago)
    tiago.stuck.add("robot_a")
    for _ in range(200):
        tiago.step(chi)
        if tiago.plant.reason:
            break
    assert "robot_a/base_" in tiago.plant.reason
    assert "does not follow" in tiago.plant.reason


def test_torques_are_those_of_the_arm_alone():
    """At rest they hold its weight, wherever the base stands."""
    plant = load_plant(PLANT)
    robot = plant.robots["robot_a"]
    effort = replace(robot, arm=replace(robot.arm, type="effort"))
    tiago = IdealHardware(replace(plant, robots={"robot_a": effort}), scenario())
    tiago.enable()
    tiago.step(np.zeros(tiago.team.n))
    assert tiago.sent["robot_a"].values is None
    model = tiago.team.robots[0]
    tiago.now += 1e-3
    q = tiago.q[model.arm_q].tolist()
    sample = JointSample(model.joints[model.arm], q, [0.0] * 8, tiago.now, tiago.now)
    tiago.plant.hear_joints("robot_a", sample)
    expected = gravity(model, model.pinocchio.createData(), tiago.q)[model.arm_q]
    assert np.abs(expected).max() > 5.0
    np.testing.assert_allclose(tiago.sent["robot_a"].values, expected, atol=1e-6)
