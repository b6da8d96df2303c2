"""What the controller tells of its absence, and who of the others is silent."""

import time

import pytest
import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus

from lexstack.transition import Phase, Source, TransitionState
from lexstack_ros.node.absence import Absence
from lexstack_ros.node.diagnostics import Diagnostics, Health, brief
from lexstack_ros.node.peer_watch import PeerWatch


def told(reason):
    return TransitionState(
        1, "a", "b", Source.SOLVER, "bridge", Phase.BLENDING, 0.5, 1.0, 0.0, reason
    )


def test_robot_a_tells_when_it_was_away():
    absence = Absence(10)
    assert [absence.arrive(tick) for tick in (0, 1, 2, 12)] == [""] * 4
    assert absence.arrive(23) == "the controller was away from tick 13 to 22"
    assert Absence(10).arrive(500) == "the controller began at tick 500"
    assert Absence(10).arrive(3) == ""
    absence.begin_anew()
    assert absence.arrive(0) == "the plant began anew, the controller at tick 0"
    assert absence.arrive(1) == ""


def test_a_reason_is_reported_once_even_if_it_has_gone_again():
    absence = Absence(10)
    for reason in ("", "the solver lost", "the solver lost", ""):
        absence.see([told(reason), told(reason)])
    assert absence.report() == "the solver lost"
    assert absence.report() == ""
    absence.see([told("the solver lost")])
    assert absence.report() == "the solver lost"
    absence.see([told("the solver lost")])
    assert absence.report() == "", "it only stands there still"


@pytest.fixture
def node():
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=204)
    node = rclpy.create_node("hqp_controller", context=context)
    yield node
    node.destroy_node()
    rclpy.shutdown(context=context)


def test_who_is_silent_is_named_until_it_speaks_or_is_gone(node):
    now = [0.0]
    watch = PeerWatch(node, lambda: now[0])

    def speak(name, hardware="lexstack"):
        status = DiagnosticStatus(name=name, hardware_id=hardware)
        watch.hear(DiagnosticArray(status=[status]))

    for name in ("recorder", "stack_solver", "hqp_controller"):
        speak(name)
    speak("camera", "other")
    now[0] = 2.0
    assert watch.report() == ""
    speak("recorder")
    now[0] = 3.0
    assert watch.report() == "stack_solver is silent for 3 s"
    speak("stack_solver")
    assert watch.report() == ""
    now[0] = 10.0
    assert watch.report() == "recorder is silent for 8 s, stack_solver is silent for 7 s"
    now[0] = 100.0
    assert watch.report() == ""


def test_diagnostics_that_are_overdue_are_caught_up(node):
    asked = []

    def health():
        asked.append(time.monotonic())
        return Health()

    diagnostics = Diagnostics(node, health, period=0.1)
    diagnostics.catch_up()
    assert not asked, "not yet"
    time.sleep(0.16)
    diagnostics.catch_up()
    diagnostics.catch_up()
    assert len(asked) == 1


def test_a_long_word_in_a_status_is_cut_and_says_how_long_it_was():
    assert brief("short") == "short"
    cut = brief("x" * 2000)
    assert len(cut) == 500
    assert cut.endswith("x… (2000 characters)")
