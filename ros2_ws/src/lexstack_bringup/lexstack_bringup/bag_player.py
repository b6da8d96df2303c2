"""Plays a bag to live nodes: one node is debugged against the recorded others."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import yaml
from rclpy.duration import Duration
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.serialization import deserialize_message
from rosgraph_msgs.msg import Clock
from std_srvs.srv import Trigger

from lexstack_bag.errors import BagError
from lexstack_bag.replay.outcome import Outcome, joints_of
from lexstack_bag.replay.requests import Ask, Cancel
from lexstack_bag.run.run import Run
from lexstack_bag.storage.container import Container, RawMessage
from lexstack_bag.storage.decoder import Decoder
from lexstack_bag.storage.definitions import type_hash
from lexstack_bag.storage.selection import Selection
from lexstack_bag.topics import COMMAND, PLANT_STATE, REQUEST, SCENARIO, SOLUTION, TRANSITION
from lexstack_interfaces.msg import Chi, PlantState
from lexstack_interfaces.srv import SwitchStack
from lexstack_ros.messages.qos import LATCHED, STREAM
from lexstack_ros.node.calls import NoAnswerError, answer_of
from lexstack_ros.node.readiness import is_connected
from lexstack_ros.recorder.topics import message_class

NAME = "replay"
_SETTLED = 1.0  # s for which all connections must have been there
_ALONE = 5.0  # s, after which it plays for nobody: discovery may take 3 s, a period of DDS
_NS = 1e9
_UNANSWERED = 0.002  # s after a state that nobody answers: a live node shall keep up
_OWN = ("/rosout", "/parameter_events")  # of the recorded nodes, not for live ones


@dataclass(frozen=True, slots=True)
class LiveNode:
    """A node that can be debugged.

    Attributes:
        node: its name in ROS.
        topics: what it publishes: never played while it is live.
        command: how it is started.
    """

    node: str
    topics: tuple[str, ...]
    command: str


LIVE: dict[str, LiveNode] = {
    "robot_a": LiveNode(
        "hqp_controller",
        (COMMAND, TRANSITION, REQUEST, SCENARIO),
        "lexstack_ros.controller.node",
    ),
    "robot_b": LiveNode("stack_solver", (SOLUTION,), "lexstack_ros.solver.node"),
}
"""By the name in the node's topic, as in lexstack_bag.replay.nodes.REPLAYERS."""


class BagPlayer(Node):
    """Publishes recorded messages, waits for a live node tick by tick, and keeps its chi."""

    def __init__(
        self,
        executor: Executor,
        container: Container,
        selection: Selection,
        live: str,
        patience: float,
    ) -> None:
        """Offer the topics of a bag.

        Args:
            executor: runs this node alone.
            container: the bag, read once, so that its topics are known.
            selection: which topics are played.
            live: a key of LIVE, or empty: nobody is waited for.
            patience: how long to wait for a live node [s of wall time].

        Raises:
            BagError: the bag has a topic whose type is not installed, or another one now.
        """
        super().__init__(NAME)
        executor.add_node(self)
        self._executor = executor
        self._live = LIVE.get(live)
        self._patience = patience
        self._answers: dict[int, Any] = {}  # chi by tick
        self._sender = ""  # the live robot A's name in messages
        leave = (*_OWN, *(self._live.topics if self._live else ()))
        self._publishers_by_topic: dict[str, Publisher] = {
            topic: self._offer(topic, kind, metadata)
            for topic, (kind, metadata) in container.topics.items()
            if topic not in leave and selection.takes(topic, kind)
        }
        self._clock = None
        if "/clock" not in container.topics and PLANT_STATE in self._publishers_by_topic:
            self._clock = self.create_publisher(Clock, "/clock", STREAM)
        if self._live is not None:
            self.create_subscription(Chi, self._live.topics[0], self._on_chi, STREAM)
        self._switch = self.create_client(SwitchStack, "/robot_a/switch_stack")
        self._cancel = self.create_client(Trigger, "/robot_a/cancel_transition")

    @property
    def topics(self) -> tuple[str, ...]:
        """What is played."""
        return tuple(self._publishers_by_topic)

    def wait_connected(self) -> None:
        """Wait until the live node is there and connected; raises BagError.

        Without one, wait for whoever listens: until nobody has joined for a while.
        """
        if self._live is None:
            self._wait_settled()
            return
        peers, since = [self._live.node], time.monotonic()
        end = since + self._patience
        while time.monotonic() - since < _SETTLED:
            self._executor.spin_once(timeout_sec=0.1)
            if not is_connected(self, peers):
                since = time.monotonic()
            if time.monotonic() > end:
                raise BagError(f"{self._live.node} is not there after {self._patience:g} s")

    def play(
        self,
        messages: Any,
        pace: Callable[[int], float],
        user: list[Ask | Cancel],
        expected: set[int],
    ) -> int:
        """Publish messages; return how many.

        Args:
            messages: of the bag, in its order.
            pace: from a log time [ns] to the wall time until it is due [s]; not positive: now.
            user: what is asked of a live robot A by service.
            expected: ticks that the live node must answer before the next state is sent.

        Raises:
            BagError: a live node does not answer.
        """
        decode, played, served = Decoder(), 0, -1
        for message in messages:
            publisher = self._publishers_by_topic.get(message.topic)
            if publisher is None:
                continue
            due = pace(message.log_time)
            if due > 0.0:
                self._spin(due)
            if message.topic == PLANT_STATE:
                state = decode(message)
                self._await(served, expected)
                if state.status != PlantState.PAUSED and state.tick > served:
                    self._speak(user, state.tick)
                    served = state.tick
                self._tell_time(state)
            publisher.publish(self._altered(message))
            played += 1
        self._await(served, expected)
        self._wait_taken()
        return played

    def outcome(self, live: str, run: Run) -> Outcome:
        """Return the live node's chi beside the recorded one."""
        chi, team = run.chi[live], run.team()
        rows = [row for row, tick in enumerate(chi.tick) if int(tick) in self._answers]
        heard = np.full((len(rows), team.n), np.nan)
        for place, row in enumerate(rows):
            answer = self._answers[int(chi.tick[row])]
            if len(answer) == team.n:
                heard[place] = answer
        return Outcome(live, joints_of(team), chi.tick[rows], chi.stamp[rows], chi.chi[rows], heard)

    def _offer(self, topic: str, kind: str, metadata: dict[str, str]) -> Publisher:
        """Return the publisher of a recorded topic."""
        recorded = metadata.get("topic_type_hash", "")
        if recorded and recorded != type_hash(kind):
            raise BagError(f"{topic}: {kind} is another type now than when it was recorded")
        return self.create_publisher(message_class(kind), topic, _qos(metadata))

    def _tell_time(self, state: Any) -> None:
        """Publish /clock where the bag has none."""
        if self._clock is not None:
            stamp = state.header.stamp
            time_message = Clock()
            time_message.clock.sec, time_message.clock.nanosec = stamp.sec, stamp.nanosec
            self._clock.publish(time_message)

    def _altered(self, message: RawMessage) -> Any:
        """Return a message as it is played.

        The plant follows the live robot A as it followed the recorded one: the name of the
        commander in its state is the live node's.
        """
        if message.topic != PLANT_STATE or not self._sender:
            return bytes(message.data)
        state = deserialize_message(bytes(message.data), PlantState)
        if state.commander:
            state.commander = self._sender
        return state

    def _await(self, tick: int, expected: set[int]) -> None:
        """Wait for the live node's answer to a tick; without one, not longer than it takes."""
        if self._live is None:
            return
        if tick not in expected:
            self._spin(_UNANSWERED)
            return
        end = time.monotonic() + self._patience
        while tick not in self._answers:
            self._executor.spin_once(timeout_sec=0.02)
            if time.monotonic() > end:
                raise BagError(
                    f"{self._live.node} did not answer tick {tick} in {self._patience:g} s"
                )

    def _speak(self, user: list[Ask | Cancel], tick: int) -> None:
        """Ask by service what was asked before this tick."""
        while user and user[0].after < tick:
            wish = user.pop(0)
            if isinstance(wish, Cancel):
                self._call(self._cancel, Trigger.Request())
                continue
            request = SwitchStack.Request(
                stack=wish.stack,
                duration=wish.duration,
                method=wish.method,
                at_tick=wish.at_tick,
                robots=list(wish.robots),
            )
            answer = self._call(self._switch, request)
            if not answer.accepted:
                raise BagError(f"switch to {wish.stack!r} refused: {answer.message}")

    def _call(self, client: Any, request: Any) -> Any:
        """Return a service's answer; raises BagError when none comes in time."""
        try:
            return answer_of(self._executor, client, request, self._patience)
        except NoAnswerError as error:
            raise BagError(str(error)) from error

    def _wait_settled(self) -> None:
        """Wait until somebody listens, and nobody else has joined for a while."""
        since = time.monotonic()
        end, listeners = since + self._patience, 0
        while (now := time.monotonic()) - since < (_SETTLED if listeners else _ALONE) and now < end:
            self._executor.spin_once(timeout_sec=0.1)
            present = sum(p.get_subscription_count() for p in self._publishers_by_topic.values())
            if present != listeners:
                since, listeners = now, present

    def _wait_taken(self) -> None:
        """Wait until every listener has what was sent: with this node what is on its way is lost.

        A listener that died takes nothing more, so this is for a while only.
        """
        end = time.monotonic() + self._patience
        clock = [] if self._clock is None else [self._clock]
        for publisher in (*self._publishers_by_topic.values(), *clock):
            left = max(end - time.monotonic(), 0.0)
            if not publisher.wait_for_all_acked(Duration(seconds=left)):
                topic = publisher.topic_name
                self.get_logger().warning(f"{topic}: not taken by all listeners")

    def _spin(self, seconds: float) -> None:
        """Take what comes for some time."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0.0:
            self._executor.spin_once(timeout_sec=left)

    def _on_chi(self, message: Chi) -> None:
        """Keep what the live node says."""
        if self._live is LIVE["robot_a"]:
            self._sender = message.sender
        self._answers[message.tick] = message.chi


def _qos(metadata: dict[str, str]) -> Any:
    """Return the house's profile that fits what was offered when it was recorded."""
    offered = yaml.safe_load(metadata.get("offered_qos_profiles", "")) or []
    latched = any(profile.get("durability") == "transient_local" for profile in offered)
    return LATCHED if latched else STREAM


def paced(rate: float) -> Callable[[int], float]:
    """Return when a message is due at a multiple of the recorded pace; 0: at once."""
    begun: list[tuple[int, float]] = []

    def due(log_time: int) -> float:
        if not rate:
            return 0.0
        if not begun:
            begun.append((log_time, time.monotonic()))
        first, wall = begun[0]
        return wall + (log_time - first) / _NS / rate - time.monotonic()

    return due
