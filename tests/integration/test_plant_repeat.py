"""The same seed and commands give the same bits: again, in another process, and after restore."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
from pathlib import Path

import numpy as np

from support.plants import make_plant, sine

# Contact and pushes make it the hardest case.
BASES = [(0.0, 0.0, 0.0), (0.9, 0.05, np.pi)]


def digest(ticks: int = 150) -> str:
    """Return a fingerprint of a run with contact, a push and missing commands."""
    plant = make_plant(bases=BASES)
    plant.apply_wrench("robot_a", "tool", np.array([5.0, -5.0, 3.0]), np.ones(3), 0.4)
    sha = hashlib.sha256()
    for tick in range(ticks):
        state = plant.step(None if 60 < tick < 75 else toward(plant, tick))
        for part in (state.q, state.v, state.q_star, state.command, plant.effort):
            sha.update(part.tobytes())
    assert plant.counters.contact > 0
    return sha.hexdigest()


def toward(plant, tick):
    """Return a chi that drives the robots into each other while all joints swing."""
    chi = 0.5 * sine(plant, tick)
    chi[0] += min(0.2, 0.01 * tick)
    return chi


def test_two_runs_and_two_processes_agree_to_the_bit():
    here = digest()
    assert here == digest()
    code = "import runpy, sys; print(runpy.run_path(sys.argv[1])['digest']())"
    tests = str(Path(__file__).parents[1])
    paths = os.pathsep.join([tests, os.environ.get("PYTHONPATH", "")])
    done = subprocess.run(
        [sys.executable, "-c", code, __file__],
        env=os.environ | {"PYTHONPATH": paths},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.strip() == here


def test_a_reset_plant_repeats_its_run():
    plant = make_plant(bases=BASES)
    runs = []
    for _ in range(2):
        states = [plant.step(toward(plant, tick)) for tick in range(60)]
        runs.append(np.array([state.q for state in states]))
        plant.reset(plant.seed)
    np.testing.assert_array_equal(runs[0], runs[1])


def test_a_restored_plant_goes_on_exactly_as_before():
    plant = make_plant(bases=BASES)
    plant.apply_wrench("robot_b", "tool", np.array([5.0, 5.0, -3.0]), np.zeros(3), 0.8)
    for tick in range(50):
        plant.step(toward(plant, tick))
    plant.step(None)
    saved = plant.save()
    futures = []
    for _ in range(2):
        states = [plant.step(toward(plant, tick)) for tick in range(51, 120)]
        path = np.array([state.q for state in states])
        futures.append((path, plant.effort, plant.counters, plant.contacts))
        at = plant.restore(saved)
        assert at.tick == 51
    np.testing.assert_array_equal(futures[0][0], futures[1][0])
    np.testing.assert_array_equal(futures[0][1], futures[1][1])
    assert futures[0][2:] == futures[1][2:]
    assert futures[0][2].contact > 0


def test_states_are_values():
    plant = make_plant()
    state = plant.state()
    before = state.q.copy()
    plant.step(np.ones(plant.team.n) * 0.05)
    np.testing.assert_array_equal(state.q, before)
    assert not state.q.flags.writeable
