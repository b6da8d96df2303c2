"""No command: the plant keeps the last one for 0.1 s, brakes within its limits, and recovers."""

from __future__ import annotations

import numpy as np
import pytest

from lexstack_sim.plant_state import Status
from support.plants import make_plant

WATCHDOG = 10  # ticks at 100 Hz
DRIVING = np.tile([0.6, -0.3, 0.4, 0.3, 0.2, -0.3, 0.2, 0.4, 0.2, -0.5], 2)


def drive(plant):
    """Reach DRIVING within the acceleration limits."""
    limit = plant.team.limits.acceleration * plant.period
    command = np.zeros(plant.team.n)
    while (command != DRIVING).any():
        command = command + np.clip(DRIVING - command, -limit, limit)
        plant.step(command)


def test_it_holds_then_brakes_within_the_limits_then_stands():
    plant = make_plant()
    drive(plant)
    limit = plant.team.limits.acceleration * plant.period
    for _ in range(WATCHDOG):
        state = plant.step(None)
        assert plant.status == Status.HOLDING
        np.testing.assert_array_equal(state.command, DRIVING)
    before = state
    ticks = 0
    while state.command.any():
        state = plant.step(None)
        ticks += 1
        assert plant.status == Status.BRAKING
        assert (np.abs(state.command - before.command) <= limit * (1 + 1e-12)).all()
        assert (np.abs(state.command) <= np.abs(before.command)).all()
        before = state
    assert ticks == pytest.approx(np.max(np.abs(DRIVING) / limit), abs=1.0)
    for _ in range(80):
        state = plant.step(None)
    assert np.abs(state.v).max() < 2e-3
    at = state.q
    for _ in range(40):
        state = plant.step(None)
    np.testing.assert_allclose(state.q, at, atol=1e-3)  # the arms hold against their weight
    assert plant.counters.missing == WATCHDOG + ticks + 120
    assert plant.counters.over_acceleration == 0


def test_it_recovers_when_commands_return_while_it_brakes():
    plant = make_plant()
    drive(plant)
    for _ in range(WATCHDOG + 3):
        state = plant.step(None)
    assert plant.status == Status.BRAKING
    # What is in force is told, so that a controller goes on from there without a jump.
    limit = plant.team.limits.acceleration * plant.period
    state = plant.step(state.command + np.clip(DRIVING - state.command, -limit, limit))
    assert plant.status == Status.FOLLOWING
    assert plant.counters.over_acceleration == 0
    for _ in range(WATCHDOG):
        plant.step(None)
    assert plant.status == Status.HOLDING  # the watchdog's time counts anew


def test_a_single_missing_command_does_not_disturb():
    plant, other = make_plant(), make_plant()
    for tick in range(40):
        chi = 0.1 * np.sin(0.05 * tick) * np.ones(plant.team.n)
        reference = other.step(chi)
        state = plant.step(None if tick == 20 else chi)
    assert plant.counters.missing == 1
    assert np.abs(state.q - reference.q).max() < 1.5e-3


@pytest.mark.parametrize("rate", [50.0, 200.0])
def test_the_time_is_simulated_seconds_at_any_rate(rate):
    plant = make_plant(rate=rate)
    plant.step(0.01 * np.ones(plant.team.n))
    held = 0
    while plant.step(None) and plant.status == Status.HOLDING:
        held += 1
    assert held * plant.period == pytest.approx(0.1)
