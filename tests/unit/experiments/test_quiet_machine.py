"""Whether a bench notices that others use the machine."""

import numpy as np
import pytest

from lexstack_experiments.quiet import Counters, Quiet, Watch, judged, loop_times, machine_times

LOOP = np.full(40, 1e-3)
BEFORE = Counters(clock=100.0, busy=50.0, steal=1.0, own=10.0, switches=5)


def after(seconds=10.0, others=0.0, steal=0.0, switches=0):
    """Return the counters after a bench that used one core."""
    busy = BEFORE.busy + seconds + others + steal
    own, count = BEFORE.own + seconds, BEFORE.switches + switches
    return Counters(BEFORE.clock + seconds, busy, BEFORE.steal + steal, own, count)


def test_a_machine_of_ones_own_is_quiet():
    found = judged(0.2, (BEFORE, after()), (LOOP, LOOP), 2)
    assert found == Quiet(0.2, 0.0, 0.0, 0.0, 1.0, 1.0)
    assert found.text == "The machine was quiet."


@pytest.mark.parametrize(
    ("load", "ended", "loops", "word"),
    [
        (1.5, after(), (LOOP, LOOP), "load 1.5 on 2 cores"),
        (0.0, after(others=5.0), (LOOP, LOOP), "others had 0.50 cores"),
        (0.0, after(steal=1.0), (LOOP, LOOP), "the host kept 0.10 cores"),
        (0.0, after(switches=1000), (LOOP, LOOP), "100 involuntary switches"),
        (0.0, after(), (LOOP, LOOP * np.linspace(1.0, 1.05, 40) ** 4), "varied by 1.1"),
        (0.0, after(), (LOOP, 1.12 * LOOP), "1.12 times as long after"),
        (0.0, after(), (1.12 * LOOP, LOOP), "0.89 times as long after"),
    ],
)
def test_what_disturbs_is_named(load, ended, loops, word):
    found = judged(load, (BEFORE, ended), loops, 2)
    assert len(found.reasons) >= 1
    assert word in found.text
    assert found.text.startswith("The machine was not quiet: ")


def test_what_the_host_keeps_is_not_what_other_programs_had():
    found = judged(0.0, (BEFORE, after(others=1.0, steal=2.0)), (LOOP, LOOP), 2)
    assert found.others == pytest.approx(0.1)
    assert found.steal == pytest.approx(0.2)


def test_busy_time_leaves_out_idle_and_waiting():
    busy, steal = machine_times("cpu  100 20 30 4000 500 6 7 80 0 0\ncpu0 1 2 3 4 5 6 7 8 0 0\n")
    assert (busy, steal) == pytest.approx((2.43, 0.8))


def test_a_watch_looks_at_this_machine():
    watch = Watch()
    assert (loop_times(3) > 0.0).all()
    found = watch.seen()
    assert found.spread >= 1.0
    assert found.steal >= 0.0
