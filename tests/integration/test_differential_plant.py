"""TIAGo on its differential base in MuJoCo, alone and beside a robot on a holonomic one."""

import math

import numpy as np
import pytest

import lexstack
from lexstack.robots import wrap
from lexstack_config.parts import Parts, build_controller, build_stack_solver
from lexstack_config.resolved import load_scenario
from lexstack_sim.plant import Plant
from lexstack_sim.plant_state import Counters
from support.scenario import CONFIG

SCENARIO = """
name: park
description: "A differential base beside a holonomic one."
robots:
  left: {model: tiago, base: [0.5, 0.2, 0.4]}
  right: {model: panda_summit, base: [0.0, -3.0, 0.0]}
rate: 100.0
duration: 20.0
initial_stack: reach_base
transition: {duration: 1.0}
base_target:
  left: [-0.6, 0.9, 1.2]
  right: [0.3, -3.2, 0.5]
plant: {PLANT}
"""


@pytest.fixture
def parts(tmp_path, request):
    """Return the scenario, its parts and its plant; a parameter is the section ``plant``."""
    path = tmp_path / "park.yaml"
    path.write_text(SCENARIO.replace("{PLANT}", getattr(request, "param", "{}")))
    resolved = load_scenario(path, CONFIG)
    made = Parts.of(resolved)
    return resolved, made, Plant(resolved, made.team)


def test_the_base_follows_v_and_w_along_its_arc_and_never_goes_sideways(parts):
    _, made, plant = parts
    team, expected, chi = made.team, plant.state().q[:3], np.zeros(made.team.n)
    assert plant.state().q.shape == (made.team.nq,)
    assert plant.state().v.shape == (made.team.n,)
    for tick in range(400):
        chi[0] = 0.4 * math.sin(0.02 * tick)
        chi[1] = 0.6 * math.sin(0.025 * tick)
        before = plant.state().q[:3]
        state = plant.step(chi)
        expected = arc_of(expected, chi)
        np.testing.assert_allclose(state.q_star[:3], expected, atol=1e-9)
        moved, middle = state.q[:3] - before, 0.5 * (state.q[2] + before[2])
        side = moved[1] * math.cos(middle) - moved[0] * math.sin(middle)
        # The servos give way by m v w / kv, about 1 mm/s. Were they driven at the yaw of the tick's
        # beginning, v w dt / 2 = 1.4 mm/s would come on top.
        assert abs(side) < 1.2e-3 * team.dt
    np.testing.assert_allclose(state.v[:2], chi[:2], atol=5e-3)
    np.testing.assert_allclose(state.q[:3], state.q_star[:3], atol=2e-3)
    assert plant.counters == Counters()
    assert plant.effort.shape == (team.nq,)


def arc_of(pose, chi):
    """Return the end of a tick's arc by many small steps."""
    x, y, yaw = pose
    turns = yaw + chi[1] * 0.01 * (np.arange(200) + 0.5) / 200
    step = chi[0] * 0.01
    return np.array([x + step * np.cos(turns).mean(), y + step * np.sin(turns).mean(),
                     yaw + 0.01 * chi[1]])  # fmt: skip


def test_it_parks_in_the_simulation_and_switches_on_the_way(parts):
    resolved, made, plant = parts
    controller = build_controller(resolved, made)
    run = lexstack.Lockstep(made.team, controller, build_stack_solver(resolved, made), plant)
    there = made.team.home({"left": (-0.6, 0.9, 1.2), "right": (0.3, -3.2, 0.5)})
    for robot, tool in enumerate(made.team.tools(there)):  # where the arms can have them then
        controller.references.add(lexstack.Target(at=0.0, robot=robot, ee=tool))
    controller.transition.ask("posture", duration=1.0, method="bridge", at_tick=60)
    controller.transition.ask("reach_base", duration=1.0, method="bridge", at_tick=300)
    limits, before = made.team.limits, np.zeros(made.team.n)
    for _ in range(2000):
        command = run.step()
        assert not command.fallback
        assert (np.abs(command.chi) <= limits.velocity + 1e-9).all()
        change = np.abs(command.chi - before)
        assert (change <= limits.acceleration * made.team.dt + 1e-9).all()
        before = command.chi
    assert plant.counters.over_acceleration == plant.counters.over_velocity == 0
    state = plant.state()
    x, y, yaw = state.q[:3]
    assert math.hypot(-0.6 - x, 0.9 - y) < 5e-3
    assert abs(wrap(1.2 - yaw)) < 5e-3


@pytest.mark.parametrize(
    "parts", ["{latency: 0.01, encoder_step: 1.0e-4, velocity_noise: 0.01, base_slip: 0.05}"],
    indirect=True,
)  # fmt: skip
def test_late_and_noisy_sensors_and_slip_keep_their_lengths_and_repeat(parts):
    _, made, plant = parts
    chi = np.zeros(made.team.n)
    chi[:2] = 0.3, 0.2
    for _ in range(30):
        plant.step(chi)
    kept = plant.save()
    first = [plant.step(chi) for _ in range(20)]
    plant.restore(kept)
    for one in first:
        again = plant.step(chi)
        for name in ("q", "v", "q_star", "command"):
            np.testing.assert_array_equal(getattr(one, name), getattr(again, name))
    assert 0.5 * 0.3 < again.v[0] < 0.3 + 0.05
