"""Plays a scenario: sends its targets and its switches, releases the plant, watches the ticks."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from rclpy.context import Context
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.publisher import Publisher
from std_srvs.srv import SetBool

from lexstack.errors import LexstackError
from lexstack_bringup.event_messages import TYPES, messages_of
from lexstack_bringup.processes import RECORDER, nodes_of
from lexstack_bringup.sequence_client import SequenceClient
from lexstack_bringup.streams import Streams
from lexstack_config.resolved import ResolvedScenario
from lexstack_config.scenario import EventConfig
from lexstack_interfaces.msg import PlantState, TransitionStatus
from lexstack_interfaces.srv import SwitchStack
from lexstack_ros.messages.names import relative
from lexstack_ros.messages.qos import STREAM
from lexstack_ros.node.calls import answer_of, let_be_known, not_taken, wait_until
from lexstack_ros.node.readiness import is_connected

PLAYER = "scenario_player"
_LEAD = 1.0  # s, how long before its time an event is sent in realtime
_BURST = 20  # messages, fewer than a listener's queue holds
_ALWAYS = ("ee_target", "base_target")  # streams go there too
_ANSWER = 10.0  # s of wall time to wait for a service


class ScenarioFailedError(LexstackError):
    """The scenario could not be played; the text says at which step."""


class Player(Node):
    """The user of a run: all it does, anybody can do by topic and service."""

    def __init__(
        self,
        resolved: ResolvedScenario,
        executor: Executor,
        context: Context | None = None,
        *,
        simulated: bool = True,
        enable: bool = True,
    ) -> None:
        """Prepare to play; ``executor``, of the same ``context``, runs this node too.

        Robots that are not ``simulated`` are enabled by the player, or with ``enable=False`` by
        somebody else, for whom it waits.
        """
        super().__init__(PLAYER, context=context)
        self._scenario = resolved.scenario
        self._executor = executor
        executor.add_node(self)
        self.state: PlantState | None = None
        self.transition: TransitionStatus | None = None
        self.adopted: list[str] = []
        self._resolved = resolved
        self._targets: dict[str, Publisher] = {
            f"/{name}/{kind}": self.create_publisher(message, f"{name}/{kind}", STREAM)
            for name in resolved.scenario.robots
            for kind, message in TYPES.items()
            if kind in _ALWAYS or any(getattr(e, kind) for e in resolved.scenario.events)
        }
        self._streams = Streams(resolved, self._targets) if resolved.scenario.streams else None
        self._switch = self.create_client(SwitchStack, "robot_a/switch_stack")
        starts = ["sim_bridge/pause"]
        if not simulated:
            starts = [f"{name}/enable" for name in resolved.scenario.robots]
        self._starts = {name: self.create_client(SetBool, relative(name)) for name in starts}
        self._simulated, self._enable = simulated, enable
        self._ran = False  # whether ticks have begun
        plans = resolved.scenario.plans
        self._sequences = SequenceClient(self, resolved.scenario) if plans else None
        nodes = nodes_of(resolved.scenario, simulated=simulated)
        self._peers = [node for node in nodes if node != RECORDER]
        self.create_subscription(PlantState, "plant/state", self._on_state, STREAM)
        self.create_subscription(TransitionStatus, "robot_a/transition", self._on_status, STREAM)

    def play(self, watch: Callable[[], None], timeout: float) -> None:
        """Play the whole scenario.

        Args:
            watch: called again and again; raises where the run cannot go on.
            timeout: of wall time for the whole [s].

        Raises:
            ScenarioFailedError: a switch was refused, or time ran out.
            NoAnswerError: a service did not answer.
        """
        end = time.monotonic() + timeout
        self._until(self._connected, "all processes to connect", watch, end)
        let_be_known(self._executor, watch)
        events = sorted(self._scenario.events, key=lambda event: event.at)
        # In lockstep simulated time may run faster than a call takes: what is sent goes far ahead
        # of it, and no farther than a stamp may be.
        lead = min(self._scenario.duration, 0.5 * self._scenario.timeouts.target_horizon)
        if self._scenario.mode == "realtime":
            lead = min(lead, _LEAD)
        events = self._send_due(events, lead)
        if self._enable:
            self._release()
        else:
            print("waits for /NAME/enable of every robot", flush=True)

        def go_on() -> None:
            nonlocal events
            watch()
            if self._ran and not self._simulated and self._paused and not self._finished():
                raise ScenarioFailedError(
                    f"the robots were braked and disabled at tick {self.tick}; "
                    "the log of plant_adapter says why"
                )
            events = self._send_due(events, self._now() + lead)

        self._until(self._finished, "the scenario's end", go_on, end)

    @property
    def tick(self) -> int:
        """The last tick heard."""
        return 0 if self.state is None else int(self.state.tick)

    # ---- events

    def _send_due(self, events: list[EventConfig], until: float) -> list[EventConfig]:
        """Send the events up to a time [s]; return the others."""
        due = [event for event in events if event.at <= until]
        for event in due:
            for sent, (topic, message) in enumerate(messages_of(event, self._resolved), start=1):
                self._targets[topic].publish(message)
                if not sent % _BURST:
                    self._see_taken()
        if due:
            self._see_taken()
        for event in due:
            if event.switch:
                self._send_switch(event)
            if self._sequences is not None:
                self._sequences.send(event, self._call)
        return events[len(due) :]

    def _see_taken(self) -> None:
        """Wait until all listeners have what was sent: a lockstep run shall not depend on luck."""
        if self._scenario.mode == "lockstep":
            for topic in not_taken(self._targets.values(), _ANSWER):
                raise ScenarioFailedError(f"{topic}: not taken by all listeners in {_ANSWER:g} s")

    def _send_switch(self, event: EventConfig) -> None:
        """Ask the controller to switch its stack at the event's time."""
        request = SwitchStack.Request(
            stack=event.switch,
            duration=event.duration,
            robots=list(event.robots),
            at_tick=round(event.at * self._scenario.rate),
        )
        answer = self._call(self._switch, request)
        if not answer.accepted:
            raise ScenarioFailedError(f"switch to {event.switch!r} refused: {answer.message}")
        self.get_logger().info(answer.message)

    def _release(self) -> None:
        """Let simulated time run, or enable the robots."""
        for name, client in self._starts.items():
            answer = self._call(client, SetBool.Request(data=not self._simulated))
            if not answer.success:
                raise ScenarioFailedError(f"{name} refused: {answer.message}")

    def _call(self, client: Any, request: Any) -> Any:
        """Return a service's answer; raises NoAnswerError when none comes in time."""
        return answer_of(self._executor, client, request, _ANSWER)

    # ---- waiting

    def _until(
        self, done: Callable[[], bool], what: str, watch: Callable[[], None], end: float
    ) -> None:
        """Wait until ``done``, at most until ``end``; raises ScenarioFailedError."""
        if not wait_until(self._executor, done, end - time.monotonic(), watch):
            raise ScenarioFailedError(f"time ran out while waiting for {what} (tick {self.tick})")

    def _connected(self) -> bool:
        """Return whether all listeners and servers are there."""
        return (
            self.state is not None
            and is_connected(self, self._peers)
            and self._switch.service_is_ready()
            and all(client.service_is_ready() for client in self._starts.values())
            and (self._sequences is None or self._sequences.ready)
        )

    def _finished(self) -> bool:
        """Return whether the plant stands still after the last tick."""
        last = round(self._scenario.duration * self._scenario.rate)
        return self.tick >= last and self._paused

    @property
    def _paused(self) -> bool:
        """Whether the plant stands still."""
        return self.state is not None and self.state.status == PlantState.PAUSED

    def _now(self) -> float:
        """Return simulated time [s]."""
        return self.tick / self._scenario.rate

    def _on_state(self, message: PlantState) -> None:
        self.state = message
        self._ran |= message.status != PlantState.PAUSED
        if self._streams is not None and message.status != PlantState.PAUSED:
            self._streams.publish(self._now())

    def _on_status(self, message: TransitionStatus) -> None:
        self.transition = message
        if message.phase == TransitionStatus.ADOPTING:
            self.adopted.append(message.to_stack)
