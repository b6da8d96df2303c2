"""The plant moves as it is told: tracking, limits, contact, pushes."""

from __future__ import annotations

from collections import deque

import numpy as np
import pytest

from lexstack.errors import ConfigurationError, InputError
from lexstack_sim import wrench
from lexstack_sim.plant import Plant
from lexstack_sim.plant_state import Counters, PlantError, Status
from support.plants import make_plant, sine
from support.scenario import changed, team

ARMS = np.r_[3:10, 13:20]
BASES = np.r_[0:3, 10:13]


def test_it_stands_still_where_the_scenario_starts():
    plant = make_plant()
    start = plant.state()
    assert start.tick == 0
    for _ in range(50):
        state = plant.step(np.zeros(plant.team.n))
    np.testing.assert_allclose(state.q, start.q, atol=1e-9)
    assert state.tick == 50
    assert state.stamp == pytest.approx(0.5)


def test_it_tracks_a_motion_of_all_joints_to_a_few_milliradians():
    plant = make_plant()
    worst = np.zeros(plant.team.n)
    travel = np.zeros(plant.team.n)
    start = plant.state().q
    for tick in range(700):
        state = plant.step(sine(plant, tick))
        worst = np.maximum(worst, np.abs(state.q_star - state.q))
        travel = np.maximum(travel, np.abs(state.q - start))
    assert (travel > 0.08).all()
    assert worst[ARMS].max() < 5e-3
    assert worst[BASES].max() < 1.5e-3
    assert plant.counters == Counters()


def test_q_star_is_the_euler_integral_of_the_commands():
    plant = make_plant()
    total = plant.state().q.copy()
    for tick in range(100):
        chi = sine(plant, tick)
        state = plant.step(chi)
        total += plant.period * chi
        np.testing.assert_array_equal(state.command, chi)
    np.testing.assert_allclose(state.q_star, total, atol=1e-12)


def test_the_reference_moves_within_a_tick():
    """At 10 Hz a q* that jumped once per tick would shake the arm; along q*' it does not."""
    plant = make_plant(rate=10.0)
    chi = np.zeros(plant.team.n)
    chi[3] = 0.1
    for _ in range(20):
        state = plant.step(chi)
    assert state.v[3] == pytest.approx(0.1, abs=2e-3)
    assert state.q_star[3] - state.q[3] == pytest.approx(0.0, abs=2e-3)


def test_torques_read_back_hold_the_arms_and_stay_within_limits():
    plant = make_plant()
    weight = np.abs(plant.effort[ARMS]).max()
    assert weight > 5.0
    limits = np.tile([800.0, 800.0, 400.0, *[87.0] * 4, *[12.0] * 3], 2)
    for _ in range(30):
        plant.step(10.0 * np.ones(plant.team.n))  # far beyond what the robots can do
        assert (np.abs(plant.effort) <= limits * (1 + 1e-9)).all()
    assert np.abs(plant.effort[BASES]).max() == pytest.approx(800.0)


def test_commands_beyond_the_limits_are_executed_and_counted():
    plant = make_plant()
    limits = plant.team.limits
    plant.step(limits.acceleration * plant.period)
    assert plant.counters.over_acceleration == 0
    plant.step(np.zeros(plant.team.n))
    plant.step(1.01 * limits.acceleration * plant.period)
    assert plant.counters.over_acceleration == 1
    assert plant.counters.over_velocity == 0
    plant.step(1.01 * limits.velocity)
    assert plant.counters.over_velocity == 1


def test_q_star_does_not_run_away_from_a_blocked_arm():
    plant = make_plant()
    chi = np.zeros(plant.team.n)
    chi[6] = -1.0  # the elbow's flexion ends at a stop
    for _ in range(200):
        state = plant.step(chi)
    distance = plant.team.robots[0].config.arm.q_star_distance[3]
    stop = plant.team.limits.position_lower[6]
    assert stop - 0.05 < state.q[6] < stop
    assert np.abs(state.q_star - state.q)[6] <= distance + 1e-12
    assert plant.counters.clamped > 50


def test_robots_that_drive_into_each_other_touch_and_stop():
    plant = make_plant(bases=[(0.0, 0.0, 0.0), (1.0, 0.0, np.pi)])
    chi = np.zeros(plant.team.n)
    peak = 0.0
    for tick in range(250):
        chi[0] = min(0.3, 0.02 * tick)
        state = plant.step(chi)
        peak = max(peak, plant.contact_force)
    assert plant.counters.contact > 10
    assert plant.contacts > 0
    assert peak > 50.0
    length = plant.team.robots[0].config.base.chassis_size[0]
    gap = state.q[10] - state.q[0]
    assert length - 0.03 < gap < length + 0.01  # they touch, and do not pass through each other
    assert state.q[10] > 1.05  # the one that stood still is pushed, against its servo
    assert np.isfinite(state.q).all()


def test_arms_that_reach_for_each_other_touch():
    plant = make_plant(bases=[(0.0, 0.0, 0.0), (0.9, 0.0, np.pi)])
    chi = np.zeros(plant.team.n)
    for tick in range(180):
        chi[[4, 14]] = min(0.7, 0.05 * tick)  # both lean forward
        state = plant.step(chi)
    assert plant.counters.contact > 10
    np.testing.assert_allclose(state.q[[0, 10]], [0.0, 0.9], atol=0.02)  # the platforms stay apart


def test_a_push_moves_the_arm_and_ends():
    plant = make_plant()
    still = np.zeros(plant.team.n)
    start = plant.state().q
    plant.apply_wrench("robot_b", "panda_hand", np.array([0.0, 20.0, 0.0]), np.zeros(3), 0.3)
    for _ in range(30):
        pushed = plant.step(still)
    assert np.abs(pushed.q - start)[13:].max() > 5e-3
    assert np.abs(pushed.q - start)[:10].max() < 1e-6  # the other robot does not feel it
    tools = [plant.team.tools(q)[1].position for q in (start, pushed.q)]
    assert tools[1][1] - tools[0][1] > 5e-3
    for _ in range(200):
        after = plant.step(still)
    assert np.abs(after.q - start)[13:].max() < 1e-3


@pytest.mark.parametrize(
    ("robot", "link", "force", "duration", "error", "message"),
    [
        ("robot_x", "base", [1, 0, 0], 1.0, ConfigurationError, "robot_x"),
        ("robot_a", "elbow", [1, 0, 0], 1.0, InputError, "elbow"),
        ("robot_a", "base", [np.nan, 0, 0], 1.0, InputError, "force"),
        ("robot_a", "base", [1, 0], 1.0, InputError, "force"),
        ("robot_a", "base", [1, 0, 0], 0.0, InputError, "duration"),
    ],
)
def test_a_wrong_push_is_refused(robot, link, force, duration, error, message):
    plant = make_plant()
    with pytest.raises(error, match=message):
        plant.apply_wrench(robot, link, np.array(force), np.zeros(3), duration)


@pytest.mark.parametrize(
    ("chi", "message"),
    [(np.zeros(19), "expected 20"), (np.zeros((20, 1)), "expected 20")]
    + [(np.where(np.arange(20) == 7, bad, 0.0), "7") for bad in (np.nan, np.inf)],
)
def test_a_wrong_command_is_refused_and_nothing_moves(chi, message):
    plant = make_plant()
    with pytest.raises(InputError, match=message):
        plant.step(chi)
    assert plant.state().tick == 0
    assert plant.status == Status.FOLLOWING


def test_a_rate_that_does_not_fit_the_physics_is_refused():
    with pytest.raises(ConfigurationError, match="rate"):
        Plant(changed(rate=300.0), team())


def test_a_simulation_that_diverges_is_reported(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)  # MuJoCo leaves its log where it runs
    plant = make_plant()
    # A push that no servo withstands, and that is refused from outside.
    monkeypatch.setattr(wrench, "_STRONGEST", 1e13)
    plant.apply_wrench("robot_a", "tool", np.array([1e12, 0.0, 0.0]), np.zeros(3), 1.0)
    with pytest.raises(PlantError, match="unstable"):
        deque((plant.step(None) for _ in range(100)), maxlen=0)
