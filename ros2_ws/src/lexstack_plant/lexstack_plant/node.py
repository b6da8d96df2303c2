"""The ROS side of every plant: state out, command in, pause, step, reset; one timer."""

from __future__ import annotations

import dataclasses
from abc import abstractmethod
from collections.abc import Callable
from functools import partial
from time import monotonic
from typing import Any, TypeVar

from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from std_srvs.srv import SetBool, Trigger

from lexstack.errors import InputError, LexstackError
from lexstack.robots import Team
from lexstack.types import PlantStatus as Status
from lexstack.types import RobotState
from lexstack_interfaces.msg import Chi
from lexstack_plant.pacing import Pacer
from lexstack_plant.tick_cycle import TickCycle
from lexstack_plant.topics import PlantTopics
from lexstack_ros.intake.drain import waiting
from lexstack_ros.messages.cdr import Reader
from lexstack_ros.messages.conversions import check_robots, to_vector
from lexstack_ros.messages.names import relative
from lexstack_ros.messages.qos import STREAM
from lexstack_ros.node.diagnostics import Diagnostics, Health, first
from lexstack_ros.node.options import NodeOptions
from lexstack_ros.node.readiness import Readiness
from lexstack_ros.node.sole_sender import SoleSender

_COMMAND = "/robot_a/chi"
_OF_COMMAND = ("tick", "sender", "robots", "chi", "status", "reason")
EARLY = 1e-4
"""s, by which a timer may come too early."""
# A timer without a period would fire all the time while something else takes long, and its events
# be queued faster than they are taken.
_SOONEST = 100_000  # ns
Answer = TypeVar("Answer", bound=Any)


class PlantNode(Node):
    """Topics and services around a cycle, which one timer wakes at its deadline.

    A plant of its own makes the cycle, then calls ``begin``.
    """

    def __init__(self, name: str, options: NodeOptions) -> None:
        """Make the node; nothing is published before ``begin``."""
        super().__init__(**options.arguments(name))
        self._commander = SoleSender(_COMMAND)
        self._refused = 0
        self._rejection = ""  # the last one since the last report
        self._began = False

    def begin(
        self,
        team: Team,
        pacer: Pacer,
        tick_cycle: TickCycle,
        topics: PlantTopics,
        *,
        run: bool,
        now: Callable[[], float] = monotonic,
    ) -> None:
        """Create topics and services, and start the cycle: running, or paused.

        ``now`` [s] is the clock of the cycle; who gives another than the monotonic one calls
        ``look_at_clock`` whenever it has changed.
        """
        self._now = now
        self._team, self._pacer, self._tick_cycle, self._topics = team, pacer, tick_cycle, topics
        self._read = Reader(Chi, _COMMAND, _OF_COMMAND)
        self._commands = self.create_subscription(
            Chi, relative(_COMMAND), self._on_command, STREAM, raw=True
        )
        self.create_service(SetBool, "~/pause", self._on_pause)
        self.create_service(Trigger, "~/step", self._on_step)
        self.create_service(Trigger, "~/reset", self._on_reset)
        self._diagnostics = Diagnostics(self, self._health)
        wall = Clock(clock_type=ClockType.STEADY_TIME)
        self._timer = self.create_timer(1.0, self._on_timer, clock=wall)
        self._wake = 0.0
        if run:
            tick_cycle.resume()
        else:
            tick_cycle.start()
        self._began = True
        self._arm()
        self._readiness = Readiness(self, hears_plant=True)

    # ---- what a plant adds

    @abstractmethod
    def counters(self) -> Any:
        """Return the plant's counters, a dataclass with ``missing``."""

    @abstractmethod
    def complaint(self) -> str:
        """Return what is wrong with the plant, or ''."""

    def alarm(self) -> str:
        """Return why the plant does not do what it is there for, or ''."""
        return ""

    def figures(self) -> dict[str, str]:
        """Return more figures for diagnostics."""
        return {}

    def publish_more(self, state: RobotState) -> None:
        """Publish what goes with a state, after it."""

    # ---- the tick

    def publish(self, state: RobotState, status: Status) -> None:
        """Send a state; tools get theirs while the others compute."""
        if status in (Status.BRAKING, Status.PAUSED):
            self._commander.release()  # it is silent: whoever speaks first may command
        missing = self.counters().missing
        self._topics.publish(state, status, self._pacer.late_ticks, missing, self._commander.name)
        self.publish_more(state)

    def _on_command(self, data: bytes) -> None:
        """Take a command, and what waits behind it."""
        for command in (data, *(other for other, _ in waiting(self._commands))):
            self._take(command)
        self.wake_up()

    def _take(self, data: bytes) -> None:
        """Take a command, or refuse it and say why."""
        try:
            message = self._read(data)
            check_robots(message.robots, self._team, _COMMAND)
            if message.status == Chi.FAILED:
                raise InputError(f"{_COMMAND}: its solver failed: {message.reason}")
            chi = to_vector(message.chi, self._team.n, f"{_COMMAND}: chi")
            with self._commander.believing(message.sender):
                self._tick_cycle.take(message.tick, chi)
        except InputError as error:
            self.refuse(error)

    def refuse(self, error: InputError) -> None:
        """Count a message that does not fit, and say why; no flood of lines."""
        self._refused += 1
        self._rejection = f"refused: {error}"
        self.get_logger().warning(f"refused: {error}", throttle_duration_sec=1.0)

    def _on_timer(self) -> None:
        """Wake the cycle when its deadline is there; deadlines may have moved meanwhile."""
        self.look_at_clock()
        self._arm()
        self._diagnostics.catch_up()

    def look_at_clock(self) -> None:
        """Wake the cycle when its deadline is there."""
        if self._began and self._now() >= self._tick_cycle.deadline - EARLY:
            self._tick_cycle.expire()

    def wake_up(self) -> None:
        """Set the timer anew, but only where it would come too late: that takes 24 us."""
        if self._tick_cycle.deadline < self._wake:
            self._arm()

    def _arm(self) -> None:
        """Let the timer come at the deadline."""
        self._wake = self._tick_cycle.deadline
        self._timer.timer_period_ns = max(_SOONEST, round(1e9 * (self._wake - self._now())))
        self._timer.reset()

    # ---- services

    def _on_pause(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        """Pause after the present tick, or go on."""
        if request.data:
            return self.answer(self._tick_cycle.pause, response)
        return self.answer(self._tick_cycle.resume, response)

    def _on_step(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        """Run one tick of a paused plant."""
        return self.answer(partial(self._tick_cycle.resume, 1), response)

    def _on_reset(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        """Put the robots where the scenario starts; paused or running, as before."""
        return self.answer(self._reset, response)

    def _reset(self) -> None:
        """Begin anew at tick 0, and say so in the first state of it."""
        self._topics.count_reset()
        self._commander.release()
        self._tick_cycle.reset()

    def answer(self, action: Callable[[], str | None], response: Answer) -> Answer:
        """Do what a service asks; say why where it cannot be done."""
        try:
            response.message = action() or ""
            response.success = True
        except LexstackError as error:
            response.message = str(error)
        self.wake_up()
        return response

    # ---- the rest

    def _health(self) -> Health:
        """Return how the plant is."""
        counters = dataclasses.asdict(self.counters())
        rejection, self._rejection = self._rejection, ""
        alarm = self.alarm()
        return Health(
            rejection if alarm else first(self.complaint(), rejection),
            {
                "tick": str(self._tick_cycle.state.tick),
                "late ticks": str(self._pacer.late_ticks),
                "schedule restarts": str(self._pacer.restarts),
                "refused commands": str(self._refused),
                "commander": self._commander.name or "nobody",
                **self.figures(),
                **{f"{name.replace('_', ' ')} ticks": str(n) for name, n in counters.items()},
            },
            error=alarm,
        )
