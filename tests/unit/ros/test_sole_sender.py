"""Who is believed, which tick is new, how old messages are: without ROS around."""

import pytest

from lexstack.errors import InputError
from lexstack_ros.intake.delays import Delays
from lexstack_ros.intake.tick_order import TickOrder
from lexstack_ros.node.diagnostics import Meter, first
from lexstack_ros.node.sole_sender import SoleSender


class Clock:
    """A clock that the test moves."""

    def __init__(self):
        self.now = 100.0

    def __call__(self):
        return self.now


def test_the_first_sender_is_believed_and_named_to_the_second():
    sole = SoleSender("/robot_a/chi")
    with sole.believing("a@host/1/0"):
        assert sole.name == "a@host/1/0"
    sole.check("a@host/1/0")
    with pytest.raises(InputError, match="b@host/2/0 is not a@host/1/0, which was there first"):
        sole.check("b@host/2/0")
    sole.release()
    sole.check("b@host/2/0")


def test_a_sender_whose_message_is_refused_does_not_get_the_place():
    sole = SoleSender("/robot_a/chi")

    def refuse():
        with sole.believing("b@host/2/0"):
            raise InputError("too late")

    with pytest.raises(InputError, match="too late"):
        refuse()
    assert sole.name == ""
    sole.follow("a@host/1/0")
    with pytest.raises(InputError, match="was there first"), sole.believing("b@host/2/0"):
        pytest.fail("never here")
    assert sole.name == "a@host/1/0"


def test_silence_frees_the_place():
    clock = Clock()
    sole = SoleSender("/plant/state", silence=5.0, clock=clock)
    sole.follow("a")
    clock.now += 4.9
    with pytest.raises(InputError):
        sole.check("b")
    clock.now += 0.2
    sole.check("b")


@pytest.mark.parametrize("name", ["", "x" * 201, "a\nb", "\x00"])
def test_a_sender_without_a_proper_name_is_refused(name):
    with pytest.raises(InputError, match="sender: expected 1 to 200 printable characters"):
        SoleSender("/robot_a/chi").check(name)


def test_each_tick_is_new_once():
    order = TickOrder("/plant/state", Clock())
    assert [order.is_new("p", 0, tick) for tick in (7, 8, 8, 7, 0, 9)] == [
        *(True, True, False, False, False, True)
    ]
    assert not order.begins_anew


def test_a_reset_and_another_plant_begin_anew():
    order = TickOrder("/plant/state", Clock())
    assert order.is_new("p", 0, 90)
    assert not order.begins_anew
    assert order.is_new("p", 1, 0)
    assert order.begins_anew
    assert not order.is_new("p", 0, 91), "from before the reset"
    assert order.is_new("q", 0, 5)
    assert order.begins_anew
    assert order.is_new("q", 0, 6)
    assert not order.begins_anew


def test_a_tick_of_the_future_is_refused_until_time_has_passed():
    clock = Clock()
    order = TickOrder("/plant/state", clock)
    order.is_new("p", 0, 10)
    clock.now += 0.01
    for tick in (5000, 5001, 2**64 - 1):
        with pytest.raises(InputError, match=f"tick: {tick} cannot follow 10 so soon"):
            order.is_new("p", 0, tick)
    assert order.is_new("p", 0, 11), "the present goes on"
    clock.now += 5.0  # this process was stopped meanwhile
    assert order.is_new("p", 0, 511)


def test_what_waited_for_a_process_that_was_stopped_is_not_of_the_future():
    order = TickOrder("/plant/state", Clock())
    assert order.is_new("p", 0, 10, sent=50.0)
    with pytest.raises(InputError, match="so soon"):
        order.is_new("p", 0, 400, sent=50.01)
    assert order.is_new("p", 0, 400, sent=53.9), "sent 3.9 s later, taken at the same time"
    assert order.is_new("p", 0, 401, sent=53.91)


def info(sent, received):
    return {"source_timestamp": round(1e9 * sent), "received_timestamp": round(1e9 * received)}


@pytest.mark.parametrize(
    ("offset", "told"),
    [
        (0.0, ""),
        (0.05, "this host's clock is 50 ms ahead of that of the sender of /plant/state"),
        (-0.05, "this host's clock is 50 ms behind that of the sender of /plant/state"),
    ],
)
def test_a_clock_that_is_off_is_told(offset, told):
    clock = Clock()
    delays = Delays("/plant/state", clock)
    for sent, travel in ((1.0, 0.2), (1.1, 0.0003), (1.2, 0.03)):
        delays.add(info(sent, sent + travel + offset))
    complaint, values = delays.report()
    assert complaint == told
    least = values["least delay of /plant/state [ms]"]
    assert float(least) == pytest.approx(1e3 * offset + 0.3, abs=0.06)


@pytest.mark.parametrize(
    ("period", "delay", "told"),
    [
        (1.0, 0.03, ""),
        (1.0, 0.2, "this host's clock is 200 ms ahead of that of the sender of /plant/state"),
        (1.0, -0.03, "this host's clock is 30 ms behind that of the sender of /plant/state"),
        (0.01, 0.03, "this host's clock is 30 ms ahead of that of the sender of /plant/state"),
    ],
)
def test_a_delay_is_judged_by_the_period_that_the_plant_really_keeps(period, delay, told):
    """At one tick per second every delay of a slow host was taken for a clock that is off."""
    clock = Clock()
    delays = Delays("/plant/state", clock)
    complaints = []
    for _ in range(3):
        for _ in range(round(1.0 / period)):
            clock.now += period
            delays.add(info(clock.now, clock.now + delay))
        complaints.append(delays.report()[0])
    assert complaints[1:] == [told, told]
    if period == 1.0 and delay > 0.0:
        assert not complaints[0], "one message alone says nothing"


def test_silence_is_told():
    clock = Clock()
    delays = Delays("/plant/state", clock)
    assert delays.report() == (
        "/plant/state is silent",
        {"age of the last /plant/state [ms]": "inf"},
    )
    delays.add(info(1.0, 1.0))
    clock.now += 1.0
    assert delays.report()[0] == ""
    clock.now += 2.0
    complaint, values = delays.report()
    assert complaint == "/plant/state is silent"
    assert values["age of the last /plant/state [ms]"] == "3000"


def test_rate_and_times_are_of_the_last_period():
    clock = Clock()
    meter = Meter(clock)
    for microseconds in (100, 900, 200):
        meter.add(1e-6 * microseconds)
    clock.now += 2.0
    assert meter.report() == {
        "rate [Hz]": "1.5",
        "solve time, median [us]": "200",
        "solve time, longest [us]": "900",
    }
    clock.now += 1.0
    assert meter.report() == {"rate [Hz]": "0.0"}
    assert first("", "second", "third") == "second"
