"""The ticks of real robots: from the last one that is enabled until all are at rest."""

from __future__ import annotations

import numpy as np
import pytest

from lexstack.errors import InputError
from lexstack.types import PlantStatus
from lexstack_plant.hardware.cycle import HardwareCycle
from lexstack_plant.pacing import Pacer
from support.ideal_hardware import IdealHardware

LAST = 30


class Bench:
    """A cycle around ideal robots, with a clock that the test moves."""

    def __init__(self):
        self.hardware = IdealHardware()
        self.sent = []
        pacer = Pacer("realtime", self.hardware.dt, 2.0)
        self.cycle = HardwareCycle(
            self.hardware.plant, pacer, LAST, self.publish, lambda: self.hardware.now
        )
        self.cycle.start()

    def publish(self, state, status):
        self.sent.append((state.tick, status))

    def enable(self):
        self.hardware.hear()
        return [self.cycle.enable(name) for name in self.hardware.team.names]

    def tick(self, chi=None):
        if chi is not None:
            self.cycle.take(self.cycle.state.tick, chi)
        self.hardware.now = self.cycle.deadline
        self.hardware.q[:] = self.hardware.plant.state().q
        self.hardware.hear()
        self.cycle.expire()


def test_it_is_paused_until_all_are_enabled_and_shows_where_the_robots_are():
    bench = Bench()
    bench.hardware.q[3] = 0.1
    bench.hardware.hear()
    bench.cycle.expire()
    assert bench.cycle.state.q[3] == 0.1
    assert bench.sent[-1] == (0, PlantStatus.PAUSED)
    first, second = bench.enable()
    assert first == "robot_a is enabled; motion begins when robot_b is enabled too"
    assert second == "all robots are enabled"
    assert bench.sent[-1] == (0, PlantStatus.FOLLOWING)


def test_it_ends_at_rest_after_the_scenario():
    bench = Bench()
    bench.enable()
    chi = np.zeros(bench.hardware.team.n)
    for _ in range(LAST):
        chi = chi + 0.001
        bench.tick(chi)
    while not bench.cycle.paused:
        bench.tick()
    statuses = [status for _, status in bench.sent]
    assert statuses[-1] == PlantStatus.PAUSED
    assert PlantStatus.BRAKING in statuses
    assert bench.hardware.plant.reason == "the scenario has ended"
    assert not bench.cycle.state.command.any()


def test_commands_are_refused_while_it_brakes():
    bench = Bench()
    bench.enable()
    chi = np.full(bench.hardware.team.n, 0.001)
    bench.tick(chi)
    bench.cycle.pause()
    with pytest.raises(InputError, match="braked: paused"):
        bench.cycle.take(bench.cycle.state.tick, chi)


def test_it_begins_again_at_tick_0():
    bench = Bench()
    bench.enable()
    for _ in range(5):
        bench.tick(np.zeros(bench.hardware.team.n))
    bench.cycle.pause()
    while not bench.cycle.paused:
        bench.tick()
    bench.enable()
    assert bench.cycle.state.tick == 0
    assert bench.cycle.runs == 2


@pytest.mark.parametrize("ask", ["resume", "reset"])
def test_robots_neither_resume_nor_jump_back(ask):
    with pytest.raises(InputError, match="robots"):
        getattr(Bench().cycle, ask)()


def test_a_simulator_that_begins_again_stops_the_robots_at_once():
    """Its time goes back: the deadline of the present tick would come 40 s later."""
    bench = Bench()
    bench.enable()
    chi = np.zeros(bench.hardware.team.n)
    for _ in range(10):
        chi = chi + 0.001
        bench.tick(chi)
    states = len(bench.sent)
    bench.hardware.now -= 40.0
    bench.cycle.rewind(40.0)
    assert len(bench.sent) == states, "the tick was published already"
    ticks = 0
    while not bench.cycle.paused:
        assert bench.cycle.deadline - bench.hardware.now <= 1.01 * bench.hardware.dt
        bench.tick()
        ticks += 1
        assert ticks < 100
    assert bench.hardware.plant.reason == "time went back by 40 s"
    assert not bench.cycle.state.command.any()
    assert {status for _, status in bench.sent[states:]} == {
        PlantStatus.BRAKING,
        PlantStatus.PAUSED,
    }


def test_a_simulator_that_begins_again_while_nothing_moves_is_shown_again():
    bench = Bench()
    bench.hardware.now -= 40.0
    bench.cycle.rewind(40.0)
    assert bench.cycle.deadline <= bench.hardware.now + 0.1
    bench.hardware.now = bench.cycle.deadline
    bench.hardware.hear()
    bench.cycle.expire()
    assert bench.sent[-1] == (0, PlantStatus.PAUSED)
    bench.enable()
    assert bench.sent[-1] == (0, PlantStatus.FOLLOWING)
