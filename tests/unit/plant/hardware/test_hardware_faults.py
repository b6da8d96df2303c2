"""What goes wrong while the adapter moves robots; other faults are in test_hardware_plant.py."""

from __future__ import annotations

import numpy as np
import pytest

import lexstack
from lexstack.errors import InputError
from lexstack.robots import wrap
from lexstack.types import PlantStatus
from lexstack_config.parts import Parts, build_controller, build_stack_solver
from lexstack_plant.hardware.base_intake import BaseSample
from lexstack_plant.hardware.joint_intake import JointSample
from lexstack_plant.hardware.memory import Phase
from support.ideal_hardware import IdealHardware
from support.scenario import resolved


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


def joints(hardware, name="robot_a", stamp=None, **changed):
    """Return a message of a robot's joints as they are, some of them changed."""
    model = hardware.team.robots[hardware.team.index(name)]
    part = hardware.team.q_slices[hardware.team.index(name)]
    q = dict(zip(model.joints[model.arm], hardware.q[part][model.arm_q].tolist(), strict=True))
    q |= changed
    known = {joint: value for joint, value in q.items() if value is not None}
    when = hardware.now if stamp is None else stamp
    return JointSample(list(known), list(known.values()), [0.0] * len(known), when, hardware.now)


def told_instead(hardware, monkeypatch, message):
    """Let robot_a's joints be told by ``message`` from now on; return what was refused."""
    refused, intake = [], hardware.plant.robots["robot_a"].joints
    hear = intake.hear

    def instead(_sample):
        try:
            hear(message())
        except InputError as error:
            refused.append(str(error))

    monkeypatch.setattr(intake, "hear", instead)
    return refused


def run_until_stopped(hardware, chi, most=200):
    """Go on with a command until the adapter stops; return for how many ticks it went on."""
    for tick in range(most):
        if hardware.plant.reason:
            return tick
        hardware.step(chi)
    raise AssertionError("it went on")


def rests(hardware):
    """Check that the robots are braked within their limits, and are sent zero at the end."""
    plant, limits, dt = hardware.plant, hardware.team.limits, hardware.dt
    assert plant.phase is Phase.STOPPING
    before = plant.state().command
    for _ in range(300):
        state = hardware.step()
        assert (np.abs(state.command - before) <= limits.acceleration * dt * (1 + 1e-9)).all()
        before = state.command
        if plant.phase is Phase.DISABLED:
            break
    assert not before.any()
    for command in hardware.sent.values():
        assert not command.twist.any()
        assert not command.points[-1].velocity.any()


# ---- states


def test_states_that_are_not_numbers_brake_when_the_last_good_one_is_old(hardware, monkeypatch):
    chi = start(hardware)
    refused = told_instead(hardware, monkeypatch, lambda: joints(hardware, panda_joint3=np.nan))
    ticks = run_until_stopped(hardware, chi)
    assert ticks == pytest.approx(0.1 / hardware.dt, abs=2)
    assert "robot_a: joint states are" in hardware.plant.reason
    assert "position of 'panda_joint3' is nan" in refused[0]
    rests(hardware)


def test_a_joint_that_is_left_out_of_messages_brakes(hardware, monkeypatch):
    chi = start(hardware)
    told_instead(hardware, monkeypatch, lambda: joints(hardware, panda_joint3=None))
    run_until_stopped(hardware, chi)
    assert "robot_a: joint states are" in hardware.plant.reason
    rests(hardware)


def test_a_platform_without_poses_brakes(hardware, monkeypatch):
    chi = start(hardware)
    monkeypatch.setattr(hardware.plant.robots["robot_b"].base, "hear", lambda _sample: None)
    run_until_stopped(hardware, chi)
    assert "robot_b: the base's pose is" in hardware.plant.reason
    rests(hardware)


def test_duplicated_and_reordered_messages_change_nothing(hardware):
    """Beside each message that is right come older ones, with other positions: nothing moves."""
    twin = IdealHardware()
    for each in (hardware, twin):
        each.enable()
    random, chi = np.random.default_rng(3), np.zeros(hardware.team.n)
    for _ in range(100):
        chi = np.clip(chi + 0.1 * hardware.plant._rules.step_limit, 0.0, 0.2)
        states = [each.step(chi) for each in (hardware, twin)]
        for back in (0.0, *random.uniform(0.0, 0.05, 2)):
            intake = hardware.plant.robots["robot_a"].joints
            intake.hear(joints(hardware, stamp=hardware.now - back, panda_joint1=0.5))
            base = hardware.plant.robots["robot_b"].base
            turn = (0.0, 0.0, 0.0, 1.0)
            base.hear(BaseSample(9.0, 9.0, turn, (0.0,) * 3, hardware.now - back, hardware.now))
        for name in ("q", "v", "q_star", "command"):
            np.testing.assert_array_equal(*(getattr(state, name) for state in states))
    assert not hardware.plant.reason
    counters = hardware.plant.robots["robot_a"].joints.counters
    assert (counters.repeated, counters.late) == (100, 200)


def test_a_speed_beyond_the_limit_brakes(hardware, monkeypatch):
    chi = start(hardware)
    fast = 1.3 * hardware.team.limits.velocity[5]

    def message():
        sample = joints(hardware)
        sample.velocities[2] = fast
        return sample

    told_instead(hardware, monkeypatch, message)
    run_until_stopped(hardware, chi)
    assert f"robot_a/panda_joint3 moves at {fast:.3g}" in hardware.plant.reason
    rests(hardware)


def test_a_platform_turns_on_and_on(hardware):
    """Its yaw wraps in messages, not in q, and nothing stops it."""
    hardware.enable()
    chi, step = np.zeros(hardware.team.n), hardware.plant._rules.step_limit
    wanted = 0.9 * hardware.team.limits.velocity[2]
    before = hardware.plant.state().q[2]
    for _ in range(1500):
        chi[2] = min(chi[2] + 0.5 * step[2], wanted)
        state = hardware.step(chi)
        assert 0.0 <= state.q[2] - before <= wanted * hardware.dt * 1.01
        before = state.q[2]
    assert not hardware.plant.reason
    assert state.q[2] > 2 * np.pi
    # What is on its way is ahead of the platform by a period.
    ahead = wanted * hardware.dt
    assert wrap(state.q[2] - hardware.q[2]) == pytest.approx(ahead, abs=1e-3)


# ---- clocks


def test_a_sender_whose_clock_is_set_back_brakes_and_is_heard_again(hardware, monkeypatch):
    """Without this all its messages would be late until its clock is where it was."""
    chi = start(hardware)
    offset = [0.0]
    told_instead(hardware, monkeypatch, lambda: joints(hardware, stamp=hardware.now - offset[0]))
    for _ in range(5):
        hardware.step(chi)
    offset[0] = 20.0
    run_until_stopped(hardware, chi)
    assert "robot_a: the clock of its messages was set back by 20 s" in hardware.plant.reason
    rests(hardware)
    for _ in range(20):
        hardware.step()
    assert hardware.enable().tick == 0
    hardware.step(np.zeros(hardware.team.n))
    assert not hardware.plant.reason


def test_odometry_whose_clock_is_set_back_brakes(hardware):
    chi = start(hardware)
    base = hardware.plant.robots["robot_a"].base
    x, y, yaw = hardware.q[:3].tolist()
    turn = (0.0, 0.0, np.sin(yaw / 2), np.cos(yaw / 2))
    base.hear(BaseSample(x, y, turn, (0.0, 0.0, 0.0), hardware.now - 5.0, hardware.now))
    hardware.step(chi)
    assert "robot_a: the clock of its messages was set back by 5" in hardware.plant.reason


# ---- controllers


def test_a_controller_that_is_lost_brakes_with_its_topic(hardware):
    chi = start(hardware)
    hardware.plant.robots["robot_b"].unheard = "nobody listens to /arm/commands (X): start it"
    hardware.step(chi)
    assert hardware.plant.reason == "robot_b: nobody listens to /arm/commands (X): start it"
    rests(hardware)
    with pytest.raises(InputError, match="nobody listens to /arm/commands"):
        hardware.enable()


def test_a_users_own_controller_hands_over_at_its_velocity():
    """Our controller's first commands begin at what the arm does, and slow it down smoothly."""
    given = resolved()
    made = Parts.of(given)
    hardware = IdealHardware(given=given)
    hardware.v[3] = 0.3  # rad/s, by the other controller
    hardware.hear()
    for name in hardware.team.names:
        hardware.plant.enable(name)
    controller = build_controller(given, made)
    solver = build_stack_solver(given, made)
    run = lexstack.control.Lockstep(made.team, controller, solver, hardware)
    limits, before = made.team.limits, hardware.plant.state().command
    assert before[3] == pytest.approx(0.3)
    for tick in range(200):
        chi = run.step().chi
        assert (np.abs(chi - before) <= limits.acceleration * hardware.dt * (1 + 1e-9)).all()
        if tick == 0:
            assert chi[3] > 0.1
        before = chi
        assert not hardware.plant.reason
    assert hardware.plant.status == PlantStatus.FOLLOWING
    assert abs(before[3]) < 0.05


@pytest.mark.parametrize("speed", [0.3, -0.3])
def test_what_a_robot_at_rest_measures_is_no_velocity(hardware, speed):
    hardware.v[3] = 0.01 * np.sign(speed)  # noise
    hardware.v[4] = speed
    state = hardware.enable()
    assert state.command[3] == 0.0
    assert state.command[4] == pytest.approx(speed)
