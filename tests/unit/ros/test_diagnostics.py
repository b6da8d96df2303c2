"""Diagnostics: levels by their meaning in diagnostic_msgs, and ROS time as users set it."""

from __future__ import annotations

import time
from dataclasses import replace

import pytest
import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.executors import SingleThreadedExecutor
from rosgraph_msgs.msg import Clock

from lexstack.control import Command
from lexstack_ros.intake.delays import Delays
from lexstack_ros.messages.conversions import to_time
from lexstack_ros.messages.qos import STREAM
from lexstack_ros.node.diagnostics import Diagnostics, Health
from lexstack_ros.node.options import NodeOptions
from lexstack_testing.ros_session import ros_session


@pytest.mark.parametrize(
    ("health", "level"),
    [
        (Health(), DiagnosticStatus.OK),
        (Health("refused: x"), DiagnosticStatus.WARN),
        (Health("/plant/state is silent", stale=True), DiagnosticStatus.STALE),
        (Health("refused: x", error="braking: no command comes"), DiagnosticStatus.ERROR),
        (Health(error="not solved", stale=True), DiagnosticStatus.ERROR),
    ],
)
def test_a_level_says_what_diagnostic_msgs_means_by_it(health, level):
    assert health.level == level


def test_figures_are_stale_once_nothing_has_come_for_a_while():
    now = [0.0]
    delays = Delays("/plant/state", lambda: now[0])
    delays.report()
    assert delays.silent, "nothing has come at all"
    delays.add({"received_timestamp": 1, "source_timestamp": 0})
    delays.report()
    assert not delays.silent
    now[0] = 3.0
    assert delays.report()[0] == "/plant/state is silent"
    assert delays.silent


def test_a_controller_without_a_solution_brakes_and_one_with_another_solvers_does_not():
    fields = dict.fromkeys(Command.__dataclass_fields__)
    command = Command(**{**fields, "fallback": "braking: level 1 failed; held a command"})
    assert command.brakes
    assert not replace(command, fallback="proxqp stood in").brakes
    assert not replace(command, fallback="").brakes


@pytest.mark.parametrize("namespace", ["", "cell1"])
def test_a_status_has_simulated_time_where_a_node_is_told_to_use_it(namespace):
    heard: list[DiagnosticArray] = []
    with ros_session(children=False) as context:
        given = NodeOptions(context, namespace, {"use_sim_time": True}).arguments("some_node")
        if namespace:
            given["cli_args"] = ["--ros-args", "-r", "/clock:=clock"]  # as Naming has it
        node = rclpy.create_node(given.pop("node_name"), **given)
        told = Health("late", error="broken")
        diagnostics = Diagnostics(node, lambda: told, period=1000.0)
        clock = node.create_publisher(Clock, "clock", STREAM)
        node.create_subscription(DiagnosticArray, "diagnostics", heard.append, STREAM)
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(node)
        end = time.monotonic() + 10.0
        while not (heard and heard[-1].header.stamp.sec == 12) and time.monotonic() < end:
            clock.publish(Clock(clock=to_time(12.5)))
            executor.spin_once(timeout_sec=0.05)
            diagnostics._publish()
        executor.shutdown()
        node.destroy_node()
    (status,) = heard[-1].status
    assert (heard[-1].header.stamp.sec, heard[-1].header.stamp.nanosec) == (12, 500_000_000)
    assert status.name == f"{namespace}/some_node".removeprefix("/")
    assert status.message == "broken; late"
    assert status.level == DiagnosticStatus.ERROR
