"""Real robots behind the adapter: who may move them, and what stops them."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace

import numpy as np
import pytest

from lexstack.errors import InputError
from lexstack.types import PlantStatus
from lexstack_config.plant_file import load_plant
from lexstack_plant.hardware.base_intake import BaseSample, turned
from lexstack_plant.hardware.joint_intake import JointSample
from lexstack_plant.hardware.plant import Phase
from support.ideal_hardware import PLANT, IdealHardware


@pytest.fixture
def hardware():
    return IdealHardware()


def start(hardware, ticks=60, speed=0.1):
    """Enable the robots and move all their joints; return the command."""
    hardware.enable()
    chi = np.zeros(hardware.team.n)
    wanted = speed * hardware.team.limits.velocity
    for _ in range(ticks):
        chi = np.minimum(chi + 0.2 * hardware.plant._rules.step_limit, wanted)
        hardware.step(chi)
    assert hardware.plant.phase is Phase.ENABLED
    return chi


def braked(hardware, reason):
    """Go on until the robots are disabled; check that they were braked within their limits."""
    plant, limits, dt = hardware.plant, hardware.team.limits, hardware.dt
    assert plant.phase is Phase.STOPPING, plant.reason
    assert reason in plant.reason
    before, ticks = plant.state().command, 0
    while plant.phase is Phase.STOPPING:
        state = hardware.step(np.full(hardware.team.n, 0.1))
        assert (np.abs(state.command - before) <= limits.acceleration * dt * (1 + 1e-9)).all()
        assert plant.status == PlantStatus.BRAKING
        before, ticks = state.command, ticks + 1
        assert ticks < 300
    assert reason in plant.reason
    for command in hardware.sent.values():
        assert not command.twist.any()
        assert all(not point.velocity.any() for point in command.points[-1:])
    return ticks


# ---- enabling


def test_nothing_is_sent_before_all_robots_are_enabled(hardware):
    hardware.hear()
    assert not hardware.plant.enable("robot_a")
    assert hardware.plant.phase is Phase.DISABLED
    assert hardware.plant.enable("robot_b")
    assert not hardware.sent
    hardware.step(np.zeros(hardware.team.n))
    assert set(hardware.sent) == {"robot_a", "robot_b"}


def test_the_first_state_is_the_measured_one_at_rest(hardware):
    state = hardware.enable()
    np.testing.assert_allclose(state.q, hardware.q)
    np.testing.assert_allclose(state.q_star, hardware.q)
    assert not state.command.any()
    assert (state.tick, state.stamp) == (0, 0.0)


def test_robots_that_are_moved_by_others_are_taken_over_at_their_velocity(hardware):
    hardware.v[3:10] = 0.2
    state = hardware.enable()
    np.testing.assert_allclose(state.command[3:10], 0.2)
    hardware.step(state.command)
    point = hardware.sent["robot_a"].points[0]
    np.testing.assert_allclose(point.velocity, 0.2)
    np.testing.assert_allclose(point.position, hardware.q[3:10] + 2 * hardware.dt * 0.2)


@pytest.mark.parametrize(
    ("spoil", "reason"),
    [
        (lambda h: h.silent.add("robot_a"), "robot_a: no state of panda_joint1"),
        (lambda h: h.q.__setitem__(4, 1.9), "panda_joint2 is at 1.9, beyond its limit"),
        (lambda h: h.v.__setitem__(4, 1.5), "panda_joint2 moves at 1.5"),
        (lambda h: setattr(h.plant.robots["robot_a"], "unheard", "nobody listens"), "nobody list"),
        (lambda h: h.plant.press("robot_a", True), "the emergency stop is pressed"),
        (lambda h: h.q.__setitem__(3, np.nan), "no state of"),
    ],
)
def test_a_robot_that_may_not_move_is_not_enabled(hardware, spoil, reason):
    spoil(hardware)
    with suppress(InputError):
        hardware.hear()
    with pytest.raises(InputError, match=reason):
        hardware.plant.enable("robot_a")
    assert hardware.plant.phase is Phase.DISABLED


def test_a_state_that_has_become_old_does_not_enable(hardware):
    hardware.hear()
    hardware.now += 0.2
    with pytest.raises(InputError, match="joint states are 200 ms old"):
        hardware.plant.enable("robot_a")


def test_the_last_robot_starts_only_if_the_first_is_still_well(hardware):
    hardware.hear()
    hardware.plant.enable("robot_a")
    hardware.silent.add("robot_a")
    for _ in range(20):
        hardware.now += hardware.dt
        hardware.hear()
    with pytest.raises(InputError, match="robot_a: joint states are"):
        hardware.plant.enable("robot_b")
    assert not hardware.plant.armed


def test_unknown_robots_and_enabled_ones_are_refused(hardware):
    with pytest.raises(InputError, match="unknown robot 'robot_c'"):
        hardware.plant.enable("robot_c")
    start(hardware)
    with pytest.raises(InputError, match="enabled"):
        hardware.plant.enable("robot_a")


# ---- following


def test_the_state_is_that_of_robots_without_delay(hardware):
    state = hardware.enable()
    q, chi = state.q.copy(), np.zeros(hardware.team.n)
    arms = np.r_[3:10, 13:20]
    random = np.random.default_rng(0)
    for _ in range(100):
        step = hardware.plant._rules.step_limit
        chi = np.clip(chi + random.uniform(-step, step), -0.1, 0.1)
        state = hardware.step(chi)
        q += hardware.dt * chi
        np.testing.assert_allclose(state.q[arms], q[arms], atol=1e-12)
        np.testing.assert_allclose(state.q, q, atol=2e-3)  # a platform turns within a tick
        np.testing.assert_array_equal(state.command, chi)
    assert state.tick == 100
    assert state.stamp == pytest.approx(1.0)


def test_late_ticks_go_on_as_the_trajectories_did(hardware):
    chi = start(hardware)
    before = hardware.plant.robots["robot_a"].output.led.copy()
    hardware.plant._m.slip[:] = 0.0
    hardware.now += 3 * hardware.dt
    hardware.q[3:10] += 3 * hardware.dt * chi[3:10]
    hardware.q[13:20] += 3 * hardware.dt * chi[13:20]
    hardware.hear()
    hardware.plant.step(chi, hardware.now)
    led = hardware.plant.robots["robot_a"].output.led
    np.testing.assert_allclose(led - before, 3 * hardware.dt * chi[3:10], atol=1e-12)
    assert hardware.plant.counters.late == 1
    assert hardware.plant.phase is Phase.ENABLED


# ---- stopping


def test_a_robot_that_is_disabled_brakes_all(hardware):
    start(hardware)
    hardware.plant.disable("robot_b")
    assert braked(hardware, "robot_b was disabled") > 5
    hardware.sent.clear()
    hardware.plant.look()
    assert not hardware.sent


def test_stale_states_brake(hardware):
    chi = start(hardware)
    hardware.silent.add("robot_a")
    for _ in range(12):
        hardware.step(chi)
    braked(hardware, "robot_a: joint states are")


def test_a_jump_brakes(hardware):
    chi = start(hardware)
    hardware.now += hardware.dt
    names = list(hardware.team.robots[0].joints[3:])
    q = hardware.q[3:10].copy()
    q[2] += 0.3
    robot = hardware.plant.robots["robot_a"]
    robot.joints.hear(JointSample(names, q.tolist(), [0.0] * 7, hardware.now, hardware.now))
    hardware.plant.step(chi, hardware.now)
    braked(hardware, "robot_a: panda_joint3 jumped by 0.3")


def test_a_platform_that_jumps_brakes(hardware):
    chi = start(hardware)
    hardware.now += hardware.dt
    turn = (0.0, 0.0, 0.0, 1.0)
    entry = BaseSample(5.0, 5.0, turn, (0.0, 0.0, 0.0), hardware.now, hardware.now)
    hardware.plant.robots["robot_b"].base.hear(entry)
    hardware.plant.step(chi, hardware.now)
    yaw, twists = hardware.q[12], []
    while hardware.plant.phase is Phase.STOPPING:
        hardware.now += hardware.dt
        hardware.plant.step(None, hardware.now)
        twists.append(hardware.sent["robot_b"].twist.copy())
    assert "robot_b: the base" in hardware.plant.reason
    # It brakes along the way that it was on, whatever yaw is measured now.
    first, way = twists[0], turned(chi[10:13], -yaw)
    assert first[0] / first[1] == pytest.approx(way[0] / way[1], rel=0.05)
    assert not twists[-1].any()


def test_an_arm_that_does_not_follow_brakes(hardware):
    chi = start(hardware)
    hardware.stuck.add("robot_b")
    for _ in range(200):
        hardware.step(chi)
        if hardware.plant.reason:
            break
    braked(hardware, "does not follow")


def test_a_joint_beyond_its_limit_brakes(hardware):
    start(hardware)
    hardware.sent["robot_a"].points[0].position[1] = 1.79  # as if the arm overshot
    hardware.plant.robots["robot_a"].joints.q[1] = 1.785
    hardware.step(hardware.plant.state().command)
    braked(hardware, "panda_joint2 is at")


def test_a_command_beyond_the_limits_is_not_followed(hardware):
    chi = start(hardware)
    wild = chi.copy()
    wild[5] += 3.0 * hardware.plant._rules.step_limit[5]
    state = hardware.step(wild)
    assert abs(state.command[5]) < abs(chi[5])
    braked(hardware, "exceeds the acceleration limit of robot_a/panda_joint3 3 times")


def test_without_commands_it_holds_then_brakes_then_disables(hardware):
    chi = start(hardware)
    seen = []
    for _ in range(150):
        state = hardware.step(None)
        seen.append(hardware.plant.status)
        if hardware.plant.phase is Phase.DISABLED:
            break
    assert seen[:10] == [PlantStatus.HOLDING] * 10
    assert set(seen[10:]) == {PlantStatus.BRAKING}
    np.testing.assert_array_equal(state.command, 0.0)
    assert "no commands for 1.1 s" in hardware.plant.reason
    assert chi.any()


def test_commands_that_come_back_in_time_are_followed_again(hardware):
    start(hardware)
    for _ in range(40):
        state = hardware.step(None)
    assert hardware.plant.phase is Phase.ENABLED
    state = hardware.step(state.command + 0.5 * hardware.plant._rules.step_limit)
    assert hardware.plant.status == PlantStatus.FOLLOWING
    assert state.command.any()


def test_after_an_emergency_stop_nothing_of_before_is_resumed(hardware):
    chi = start(hardware)
    hardware.plant.press("robot_a", True)
    hardware.step(chi)
    braked(hardware, "robot_a: emergency stop")
    hardware.plant.press("robot_a", False)
    hardware.q[3] += 0.4  # somebody moves the arm by hand meanwhile
    hardware.now += 1.0
    hardware.v[:] = 0.0
    hardware.hear()
    assert hardware.plant.phase is Phase.DISABLED
    state = hardware.enable()
    assert state.tick == 0
    np.testing.assert_allclose(state.q, hardware.q)
    assert not state.command.any()
    hardware.sent.clear()
    hardware.step(np.zeros(hardware.team.n))
    np.testing.assert_allclose(hardware.sent["robot_a"].points[0].position, hardware.q[3:10])


def test_an_adapter_that_stood_still_stops(hardware):
    chi = start(hardware)
    hardware.now += 50 * hardware.dt
    hardware.hear()
    for robot in hardware.plant.robots.values():
        robot.forget()
    hardware.plant.step(chi, hardware.now)
    braked(hardware, "the adapter stood still for 490 ms")


def test_a_plant_at_another_rate_uses_its_own_tolerances():
    plant = load_plant(PLANT)
    strict = replace(plant, safety=replace(plant.safety, stale=0.015))
    hardware = IdealHardware(strict)
    chi = start(hardware)
    hardware.silent.add("robot_b")
    hardware.step(chi)
    hardware.step(chi)
    braked(hardware, "robot_b: joint states are 20 ms old, at most 15")
