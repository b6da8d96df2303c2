"""A plant that is not as its model says: each flaw does what its number says, and repeats."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from lexstack.errors import ConfigurationError, LexstackError
from lexstack.options import build
from lexstack_config.plant import PlantConfig, PushConfig
from lexstack_sim.plant import Plant
from support.plants import make_plant, sine
from support.scenario import changed, team

ARMS = np.concatenate([np.arange(part.start + 3, part.stop) for part in team().slices])
BASES = np.concatenate([np.arange(part.start, part.start + 3) for part in team().slices])
EVERYTHING = PlantConfig(
    encoder_step=1e-3,
    velocity_noise=1e-2,
    latency=0.013,
    payload=2.0,
    friction=0.3,
    base_slip=0.1,
    pushes=(PushConfig(0.1, "robot_b", "tool", (10.0, 0.0, 5.0), 0.1),),
)


def flawed(seed=0, rate=100.0, **flaws):
    return Plant(changed(plant=PlantConfig(**flaws), rate=rate), team(), seed)


def play(plant, ticks=60):
    return [plant.step(sine(plant, tick)) for tick in range(ticks)]


def bits(states):
    return [(s.q.tobytes(), s.v.tobytes(), s.q_star.tobytes()) for s in states]


def test_encoders_tell_whole_steps_of_arms_and_exact_bases():
    step = 1e-3
    true, coarse = play(make_plant()), play(flawed(encoder_step=step))
    for a, b in zip(true, coarse, strict=True):
        assert np.allclose(b.q[ARMS] / step, np.round(b.q[ARMS] / step), atol=1e-6)
        assert np.max(np.abs(a.q[ARMS] - b.q[ARMS])) <= 0.5 * step + 1e-12
        assert np.array_equal(a.q[BASES], b.q[BASES])
    assert any(not np.array_equal(a.q, b.q) for a, b in zip(true, coarse, strict=True))


def test_noise_is_on_velocities_alone_with_the_spread_that_was_asked_for():
    true, noisy = play(make_plant()), play(flawed(velocity_noise=0.02))
    off = np.array([b.v - a.v for a, b in zip(true, noisy, strict=True)])
    assert np.array_equal([s.q for s in true], [s.q for s in noisy])
    assert np.std(off) == pytest.approx(0.02, rel=0.1)
    assert abs(np.mean(off)) < 0.002


def test_measurements_are_as_old_as_the_latency():
    late = flawed(latency=0.005)
    twice = make_plant(rate=200.0)  # the same physics, looked at every 5 ms
    for tick in range(40):
        chi = sine(late, tick)
        told = late.step(chi)
        before = twice.step(chi)
        now = twice.step(chi)
        assert np.array_equal(told.q, before.q)
        assert np.array_equal(told.v, before.v)
        assert np.array_equal(told.q_star, now.q_star)  # what was commanded is known at once


def test_latency_may_be_longer_than_a_tick():
    late, true = flawed(latency=0.030), make_plant()
    told, at_once = play(late), play(true)
    for tick in range(3, 60):
        assert np.array_equal(told[tick].q, at_once[tick - 3].q)
    assert np.array_equal(told[0].q, late.reset().q)


def test_a_payload_pulls_the_arm_down_as_its_weight_says():
    mass, plant = 2.0, flawed(payload=2.0)
    for _ in range(400):
        state = plant.step(np.zeros(plant.team.n))
    for robot, part in zip(plant.team.robots, plant.team.slices, strict=True):
        q = state.q[part]
        data = robot.pinocchio.createData()
        frame = robot.pinocchio.getFrameId("tool")
        jacobian = pin.computeFrameJacobian(
            robot.pinocchio, data, q, frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        )
        weight = jacobian[2, robot.arm] * mass * 9.81
        held = np.array(robot.config.arm.stiffness) * (state.q_star[part] - q)[robot.arm]
        assert np.allclose(held, weight, rtol=0.01, atol=0.02)


def test_friction_holds_a_joint_against_a_small_push():
    push = PushConfig(0.0, "robot_a", "tool", (3.0, 0.0, 0.0), 1.0)
    free, rough = flawed(pushes=(push,)), flawed(pushes=(push,), friction=4.0)
    moved = []
    for plant in (free, rough):
        start = plant.state().q
        for _ in range(90):
            state = plant.step(np.zeros(plant.team.n))
        moved.append(np.abs(state.q - start)[plant.team.robots[0].arm].max())
    assert moved[1] < 0.3 * moved[0]


def test_wheels_lose_the_part_that_they_slip():
    plant = flawed(base_slip=0.1)
    chi = np.zeros(plant.team.n)
    for tick in range(300):
        chi[0] = min(0.3, 0.005 * tick)
        before = plant.state()
        after = plant.step(chi)
        if tick == 100:
            start = before
    went = after.q[0] - start.q[0]
    assert went / (0.3 * 2.0) == pytest.approx(0.9, abs=0.02)
    assert plant.counters.clamped > 0  # q* does not run away from a base that slips


def test_a_push_of_the_scenario_is_a_push_by_call():
    force = np.array([10.0, 0.0, 5.0])
    told = flawed(pushes=(PushConfig(0.1, "robot_b", "tool", tuple(force), 0.1),))
    called = make_plant()
    for tick in range(40):
        if tick == 10:
            called.apply_wrench("robot_b", "tool", force, np.zeros(3), 0.1)
        a, b = told.step(sine(told, tick)), called.step(sine(called, tick))
        assert np.array_equal(a.q, b.q)


@pytest.mark.parametrize("seed", [0, 5])
def test_the_same_seed_gives_the_same_bits_and_a_restored_plant_too(seed):
    resolved = changed(plant=EVERYTHING)
    plant = Plant(resolved, team(), seed)
    once = play(plant)
    assert bits(once) == bits(play(Plant(resolved, team(), seed)))
    plant.reset(seed)
    assert bits(play(plant)) == bits(once)
    plant.reset(seed)
    for tick in range(20):
        plant.step(sine(plant, tick))
    saved = plant.save()
    rest = [plant.step(sine(plant, tick)) for tick in range(20, 60)]
    plant.restore(saved)
    assert bits([plant.step(sine(plant, tick)) for tick in range(20, 60)]) == bits(rest)
    assert bits(rest) == bits(once[20:])


def test_another_seed_gives_other_noise():
    resolved = changed(plant=EVERYTHING)
    one, other = (play(Plant(resolved, team(), seed), 5) for seed in (0, 1))
    assert not np.array_equal(one[-1].v, other[-1].v)


@pytest.mark.parametrize(
    ("flaws", "message"),
    [
        ({"encoder_step": -1.0}, "plant: encoder_step"),
        ({"velocity_noise": float("nan")}, "plant: velocity_noise"),
        ({"base_slip": 0.6}, "plant: base_slip: must be at most 0.5"),
        ({"latency": 2.0}, "plant: latency: must be at most 1"),
    ],
)
def test_numbers_out_of_range_are_refused(flaws, message):
    with pytest.raises(ConfigurationError, match=message):
        build(PlantConfig, PlantConfig(**flaws), "plant")


@pytest.mark.parametrize(("robot", "link"), [("robot_c", "tool"), ("robot_a", "tail")])
def test_a_push_on_what_is_not_there_is_refused(robot, link):
    with pytest.raises(LexstackError, match=r"robot_c|tail"):
        flawed(pushes=(PushConfig(0.0, robot, link, (1.0, 0.0, 0.0), 0.1),))
