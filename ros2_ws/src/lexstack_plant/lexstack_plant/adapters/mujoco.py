"""The bridge: the plant as a ROS node. State out, command in, step; no mathematics here."""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Callable
from functools import partial
from time import monotonic
from typing import TypeVar

import numpy as np
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from std_srvs.srv import SetBool, Trigger

from lexstack.errors import InputError, LexstackError
from lexstack.types import RobotState
from lexstack_config.parts import build_team
from lexstack_interfaces.msg import Chi
from lexstack_interfaces.srv import ApplyWrench
from lexstack_plant.options import BridgeOptions
from lexstack_plant.pacing import Pacer
from lexstack_plant.tick_cycle import TickCycle
from lexstack_plant.topics import PlantTopics
from lexstack_ros.intake.drain import waiting
from lexstack_ros.messages.conversions import check_robots, to_vector
from lexstack_ros.messages.names import relative
from lexstack_ros.messages.qos import STREAM
from lexstack_ros.node.diagnostics import Diagnostics, Health, first
from lexstack_ros.node.options import FROM_COMMAND_LINE, NodeOptions
from lexstack_ros.node.parameters import scenario_parameter
from lexstack_ros.node.readiness import Readiness
from lexstack_ros.node.sole_sender import SoleSender
from lexstack_ros.node.spin import run_node
from lexstack_sim.plant import Plant
from lexstack_sim.plant_state import Status

_COMMAND = "/robot_a/chi"
_EARLY = 1e-4  # s, by which a timer may come too early
# A timer without a period would fire all the time while something else takes long, and its events
# be queued faster than they are taken.
_SOONEST = 100_000  # ns
Answer = TypeVar("Answer", ApplyWrench.Response, SetBool.Response, Trigger.Response)


class SimBridge(Node):
    """Topics and services around a Cycle, which one timer wakes at its deadline."""

    def __init__(self, options: NodeOptions = FROM_COMMAND_LINE) -> None:
        """Build the plant of the scenario; raises LexstackError for a wrong parameter."""
        super().__init__(**options.arguments("sim_bridge"))
        resolved = scenario_parameter(self)
        scenario = resolved.scenario
        self._options = BridgeOptions.declare(self)
        self._team = build_team(resolved)
        self._plant = Plant(resolved, self._team, scenario.seed)
        for note in self._plant.notes:
            self.get_logger().warning(note)
        self._pacer = Pacer(scenario.mode, self._plant.period, scenario.timeouts.command_wall)
        last = round(scenario.duration * scenario.rate)
        self._tick_cycle = TickCycle(self._plant, self._pacer, last, self._publish, monotonic)
        self._commander = SoleSender(_COMMAND)
        self._refused = 0
        self._rejection = ""  # the last one since the last report
        self._finished = False
        self._topics = PlantTopics(self, self._team, scenario.rate)
        self._commands = self.create_subscription(Chi, relative(_COMMAND), self._on_command, STREAM)
        self.create_service(SetBool, "~/pause", self._on_pause)
        self.create_service(Trigger, "~/step", self._on_step)
        self.create_service(Trigger, "~/reset", self._on_reset)
        self.create_service(ApplyWrench, "~/apply_wrench", self._on_wrench)
        self._diagnostics = Diagnostics(self, self._health)
        wall = Clock(clock_type=ClockType.STEADY_TIME)
        self._timer = self.create_timer(1.0, self._on_timer, clock=wall)
        self._wake = 0.0
        if self._options.start_paused:
            self._tick_cycle.start()
        else:
            self._tick_cycle.resume()
        self._arm()
        self._readiness = Readiness(self, hears_plant=True)

    # ---- the tick

    def _publish(self, state: RobotState, status: Status) -> None:
        """Send a state; tools get theirs while the others compute."""
        missing = self._plant.counters.missing
        if status in (Status.BRAKING, Status.PAUSED):
            self._commander.release()  # it is silent: whoever speaks first may command
        self._topics.publish(state, status, self._pacer.late_ticks, missing, self._commander.name)
        self._topics.publish_for_tools(state, self._plant.effort)
        if self._tick_cycle.ended and not self._finished:
            self.get_logger().info(f"finished: {state.tick} ticks")
            if self._options.exit_at_end:
                self.context.shutdown()
        self._finished = self._tick_cycle.ended

    def _on_command(self, message: Chi) -> None:
        """Take a command, and what waits behind it."""
        for command in (message, *(other for other, _ in waiting(self._commands))):
            self._take(command)
        self._wake_up()

    def _take(self, message: Chi) -> None:
        """Take a command, or refuse it and say why."""
        try:
            check_robots(message.robots, self._team, _COMMAND)
            if message.status == Chi.FAILED:
                raise InputError(f"{_COMMAND}: its solver failed: {message.reason}")
            chi = to_vector(message.chi, self._team.n, f"{_COMMAND}: chi")
            with self._commander.believing(message.sender):
                self._tick_cycle.take(message.tick, chi)
        except InputError as error:
            self._refused += 1
            self._rejection = f"refused: {error}"
            self.get_logger().warning(f"refused: {error}", throttle_duration_sec=1.0)

    def _on_timer(self) -> None:
        """Wake the cycle when its deadline is there; deadlines may have moved meanwhile."""
        if monotonic() >= self._tick_cycle.deadline - _EARLY:
            self._tick_cycle.expire()
        self._arm()
        self._diagnostics.catch_up()

    def _wake_up(self) -> None:
        """Set the timer anew, but only where it would come too late: that takes 24 us."""
        if self._tick_cycle.deadline < self._wake:
            self._arm()

    def _arm(self) -> None:
        """Let the timer come at the deadline."""
        self._wake = self._tick_cycle.deadline
        self._timer.timer_period_ns = max(_SOONEST, round(1e9 * (self._wake - monotonic())))
        self._timer.reset()

    # ---- services

    def _on_pause(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        """Pause after the present tick, or go on."""
        if request.data:
            return self._answer(self._tick_cycle.pause, response)
        return self._answer(self._tick_cycle.resume, response)

    def _on_step(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        """Run one tick of a paused plant."""
        return self._answer(partial(self._tick_cycle.resume, 1), response)

    def _on_reset(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        """Put the robots where the scenario starts; paused or running, as before."""
        self._topics.count_reset()
        self._commander.release()
        return self._answer(self._tick_cycle.reset, response)

    def _on_wrench(
        self, request: ApplyWrench.Request, response: ApplyWrench.Response
    ) -> ApplyWrench.Response:
        """Push a link from now on."""
        force, torque = request.wrench.force, request.wrench.torque
        push = partial(
            self._plant.apply_wrench,
            request.robot,
            request.link,
            np.array([force.x, force.y, force.z]),
            np.array([torque.x, torque.y, torque.z]),
            request.duration,
        )
        return self._answer(push, response)

    def _answer(self, action: Callable[[], None], response: Answer) -> Answer:
        """Do what a service asks; say why where it cannot be done."""
        try:
            action()
            response.success = True
        except LexstackError as error:
            response.message = str(error)
        self._wake_up()
        return response

    # ---- the rest

    def _health(self) -> Health:
        """Return how the plant is."""
        status, counters = self._plant.status, dataclasses.asdict(self._plant.counters)
        rejection, self._rejection = self._rejection, ""
        waits = "" if status == Status.FOLLOWING else f"{status.name.lower()}: no command comes"
        braking = status == Status.BRAKING
        return Health(
            rejection if braking else first(waits, rejection),
            {
                "tick": str(self._tick_cycle.state.tick),
                "late ticks": str(self._pacer.late_ticks),
                "schedule restarts": str(self._pacer.restarts),
                "refused commands": str(self._refused),
                "commander": self._commander.name or "nobody",
                "contact force [N]": f"{self._plant.contact_force:.1f}",
                **{f"{name.replace('_', ' ')} ticks": str(n) for name, n in counters.items()},
            },
            error=waits if braking else "",
        )


def main() -> int:
    """Run the bridge; returns the exit code."""
    return run_node(SimBridge)


if __name__ == "__main__":
    sys.exit(main())
