"""The cycle of a tick: state out, command in, step; pause, single steps, the end."""

from __future__ import annotations

import numpy as np
import pytest

from lexstack.errors import InputError
from lexstack_plant.pacing import Pacer
from lexstack_plant.tick_cycle import TickCycle
from lexstack_sim.plant_state import Status
from support.plants import make_plant

LAST = 5


class Bench:
    """A cycle with a clock that the test moves and a list of what was published."""

    def __init__(self, mode):
        self.now = 100.0
        self.sent = []
        plant = make_plant()
        self.chi = np.zeros(plant.team.n)
        pacer = Pacer(mode, plant.period, 2.0)
        self.cycle = TickCycle(plant, pacer, LAST, self.publish, lambda: self.now)

    def publish(self, state, status):
        self.sent.append((state.tick, status))

    def expire(self):
        self.now = self.cycle.deadline
        self.cycle.expire()


@pytest.fixture
def lockstep():
    return Bench("lockstep")


@pytest.fixture
def realtime():
    return Bench("realtime")


def test_it_starts_paused_and_repeats_its_state(lockstep):
    lockstep.cycle.start()
    lockstep.expire()
    assert lockstep.sent == [(0, Status.PAUSED)] * 2
    assert lockstep.now == pytest.approx(100.1)
    with pytest.raises(InputError, match="paused"):
        lockstep.cycle.take(0, lockstep.chi)


def test_lockstep_steps_with_each_command_and_ends_paused(lockstep):
    lockstep.cycle.resume()
    for tick in range(LAST):
        lockstep.cycle.take(tick, lockstep.chi)
    assert lockstep.sent == [*((t, Status.FOLLOWING) for t in range(LAST)), (LAST, Status.PAUSED)]
    assert lockstep.cycle.ended
    with pytest.raises(InputError, match="ended"):
        lockstep.cycle.resume()


def test_realtime_steps_at_the_deadline_only(realtime):
    realtime.cycle.resume()
    realtime.cycle.take(0, realtime.chi)
    assert realtime.cycle.state.tick == 0
    realtime.expire()
    assert realtime.sent[-1] == (1, Status.FOLLOWING)
    realtime.expire()
    assert realtime.sent[-1] == (2, Status.HOLDING)
    assert realtime.cycle.plant.counters.missing == 1


def test_a_command_for_another_tick_is_refused(lockstep):
    lockstep.cycle.resume()
    for tick in (1, 7):
        with pytest.raises(InputError, match=f"tick {tick}"):
            lockstep.cycle.take(tick, lockstep.chi)
    assert lockstep.cycle.state.tick == 0


def test_a_lost_controller_is_waited_for_once_and_awaited_again_after_it_spoke(lockstep):
    lockstep.cycle.resume()
    lockstep.expire()
    assert lockstep.now == pytest.approx(102.0)
    assert lockstep.cycle.deadline == pytest.approx(102.01)
    with pytest.raises(InputError):
        lockstep.cycle.take(0, lockstep.chi)  # too late for its tick, but a sign of life
    assert lockstep.cycle.deadline == pytest.approx(104.0)


def test_a_pause_lets_the_present_tick_finish(lockstep):
    lockstep.cycle.resume()
    lockstep.cycle.pause()
    assert not lockstep.cycle.paused
    lockstep.cycle.take(0, lockstep.chi)
    assert lockstep.cycle.paused
    assert lockstep.sent[-1] == (1, Status.PAUSED)
    lockstep.cycle.resume()
    assert lockstep.sent[-1] == (1, Status.FOLLOWING)


def test_single_steps(lockstep):
    lockstep.cycle.start()
    lockstep.cycle.resume(1)
    lockstep.cycle.take(0, lockstep.chi)
    assert lockstep.cycle.paused
    assert lockstep.cycle.state.tick == 1
    lockstep.cycle.resume()
    with pytest.raises(InputError, match="pause first"):
        lockstep.cycle.resume(1)


def test_reset_goes_back_and_keeps_running(lockstep):
    lockstep.cycle.resume()
    lockstep.cycle.take(0, lockstep.chi + 0.01)
    lockstep.cycle.reset()
    assert lockstep.sent[-1] == (0, Status.FOLLOWING)
    assert not lockstep.cycle.state.command.any()
