"""A live node among recorded others: it is waited for, asked, and its chi is kept."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import Any

import numpy as np
from rclpy.executors import Executor
from rclpy.node import Node
from std_srvs.srv import Trigger

from lexstack_bag.errors import BagError
from lexstack_bag.replay.outcome import Outcome, joints_of
from lexstack_bag.replay.requests import Ask, Cancel
from lexstack_bag.run.run import Run
from lexstack_bag.topics import COMMAND, REQUEST, SCENARIO, SOLUTION, TRANSITION
from lexstack_interfaces.msg import Chi
from lexstack_interfaces.srv import SwitchStack
from lexstack_ros.messages.names import relative
from lexstack_ros.messages.qos import STREAM
from lexstack_ros.node.calls import answer_of, lasting, wait_until
from lexstack_ros.node.readiness import is_connected

_SETTLED = 1.0  # s for which all connections must have been there
_UNANSWERED = 0.002  # s after a state that nobody answers: a live node shall keep up


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


class LivePeer:
    """The live node, as the player of a bag meets it.

    Attributes:
        live: which one.
        sender: its name in messages, where it is the controller; empty until it has sent one.
    """

    def __init__(self, name: str, node: Node, executor: Executor, patience: float) -> None:
        """Listen to it.

        Args:
            name: a key of LIVE.
            node: the player's.
            executor: of that node.
            patience: how long to wait for anything [s of wall time].
        """
        self.live = LIVE[name]
        self.sender = ""
        self._name = name
        self._node = node
        self._executor = executor
        self._patience = patience
        self._answers: dict[int, Any] = {}  # chi by tick
        node.create_subscription(Chi, relative(self.live.topics[0]), self._on_chi, STREAM)
        self._switch = node.create_client(SwitchStack, "robot_a/switch_stack")
        self._cancel = node.create_client(Trigger, "robot_a/cancel_transition")

    def wait_connected(self) -> None:
        """Wait until it is there and connected for a while; raises BagError."""
        there = lasting(lambda: is_connected(self._node, [self.live.node]), _SETTLED)
        if not wait_until(self._executor, there, self._patience):
            raise BagError(f"{self.live.node} is not there after {self._patience:g} s")

    def wait_answered(self, tick: int, expected: Collection[int]) -> None:
        """Wait for its answer to a tick; to one that is not ``expected`` not longer than it takes.

        Raises:
            BagError: it does not answer.
        """
        if tick not in expected:
            wait_until(self._executor, lambda: False, _UNANSWERED)
        elif not wait_until(self._executor, lambda: tick in self._answers, self._patience):
            raise BagError(f"{self.live.node} did not answer tick {tick} in {self._patience:g} s")

    def ask(self, user: list[Ask | Cancel], tick: int) -> None:
        """Ask by service what was asked before this tick; raises BagError, NoAnswerError."""
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
                stack_yaml=wish.text,
            )
            answer = self._call(self._switch, request)
            if not answer.accepted:
                raise BagError(f"switch to {wish.stack!r} refused: {answer.message}")

    def outcome(self, run: Run) -> Outcome:
        """Return its chi beside the recorded one."""
        chi, team = run.chi[self._name], run.team()
        rows = [row for row, tick in enumerate(chi.tick) if int(tick) in self._answers]
        heard = np.full((len(rows), team.n), np.nan)
        for place, row in enumerate(rows):
            answer = self._answers[int(chi.tick[row])]
            if len(answer) == team.n:
                heard[place] = answer
        found = chi.tick[rows], chi.stamp[rows], chi.chi[rows], heard
        return Outcome(self._name, joints_of(team), *found)

    def _call(self, client: Any, request: Any) -> Any:
        """Return a service's answer."""
        return answer_of(self._executor, client, request, self._patience)

    def _on_chi(self, message: Chi) -> None:
        """Keep what it says."""
        if self._name == "robot_a":
            self.sender = message.sender
        self._answers[message.tick] = message.chi
