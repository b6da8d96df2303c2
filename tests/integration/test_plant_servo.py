"""The velocity servos of the bases: at rest after any motion, they do not hunt."""

import numpy as np
import pytest

from lexstack_sim.plant import Plant
from support.scenario import resolved, team


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("part", [0.1, 0.2, 0.35, 0.7, 1.0])
def test_a_base_that_stops_uses_no_force(axis, part):
    """Sped up and slowed down at a part of the acceleration limit, then stopped, for 0.5 s."""
    plant = Plant(resolved(), team())
    rate = part * team().limits.acceleration[axis]
    command = np.zeros(20)
    for tick in range(200):
        command[axis] = rate * 0.01 * max(0, min(tick, 100 - tick))
        plant.step(command)
    limit = (*team().robots[0].config.base.servo_force,)[axis]
    efforts = [abs(plant.effort[axis]) for _ in range(20) if plant.step(np.zeros(20))]
    assert max(efforts) < 0.1 * limit
    assert abs(plant.state().v[axis]) < 1e-3
