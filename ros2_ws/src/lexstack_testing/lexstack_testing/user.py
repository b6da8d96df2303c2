"""Somebody who uses a run: one node that hears what is told, calls services and publishes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import rclpy
from rclpy.node import Node
from rclpy.publisher import Publisher

from lexstack.errors import LexstackError
from lexstack_interfaces.msg import Chi, PlantState, TransitionStatus
from lexstack_ros.messages.qos import STREAM
from lexstack_ros.node.calls import call, wait_until
from lexstack_testing.played_run import PlayedRun

PATIENCE = 30.0  # s of wall time for anything
_SETTLED = 0.5  # s for the other side to know a publisher, too


class InVainError(LexstackError):
    """What was waited for did not come."""


class Bystander:
    """A node beside a run's own, that waits, calls and publishes with a deadline.

    Attributes:
        run: that is looked at: of it ``context``, ``executor`` and ``check``.
        node: its own, or one that the executor has already.
        patience: how long it waits for anything [s of wall time].
    """

    patience = PATIENCE

    def __init__(self, run: PlayedRun, node: Node | None = None) -> None:
        """Stand beside a run with a node that its executor has already, or with a new one."""
        self.run = run
        self.node = node or rclpy.create_node("user", context=run.context)
        if node is None:
            run.executor.add_node(self.node)

    def hear(self, kind: type, topic: str, heard: list[Any], qos: Any = STREAM) -> list[Any]:
        """Append what comes of a topic to a list; return the list."""
        self.node.create_subscription(kind, topic, heard.append, qos)
        return heard

    def wait(self, condition: Callable[[], Any], seconds: float) -> bool:
        """Return whether a condition came true in time; raises what ends the run."""
        return wait_until(self.run.executor, condition, seconds, self.run.check)

    def until(self, condition: Callable[[], Any], what: str = "a condition") -> None:
        """Wait for a condition; raises InVainError, and what ends the run."""
        if not self.wait(condition, self.patience):
            raise InVainError(f"waited in vain for {what}{self.place()}")

    def place(self) -> str:
        """Return where the run stands, in words behind those of an error."""
        return ""

    def spin(self, seconds: float) -> None:
        """Let time pass [s of the wall's], and take what comes: queues end."""
        self.wait(lambda: False, seconds)

    def call(self, kind: Any, name: str, **request: Any) -> Any:
        """Return a service's answer; raises NoAnswerError where none comes."""
        asked = (kind, name, kind.Request(**request))
        return call(self.node, self.run.executor, *asked, self.patience, watch=self.run.check)

    def publisher(self, kind: type, topic: str, qos: Any = STREAM, listeners: int = 1) -> Publisher:
        """Return a publisher that is known to its listeners, as they are to it."""
        publisher = self.node.create_publisher(kind, topic, qos)
        self.until(lambda: publisher.get_subscription_count() >= listeners, f"{topic} to be heard")
        self.spin(_SETTLED)
        return publisher


class User(Bystander):
    """A bystander who keeps all that is told of the motion.

    Attributes:
        states: of the plant; commands: of the controller; statuses: of transitions; all heard.
    """

    def __init__(self, run: PlayedRun, node: Node | None = None) -> None:
        """Use a run by a node that its executor has already, or by a new one."""
        super().__init__(run, node)
        self.states: list[PlantState] = self.hear(PlantState, "/plant/state", [])
        self.commands: list[Chi] = self.hear(Chi, "/robot_a/chi", [])
        self.statuses: list[TransitionStatus] = self.hear(
            TransitionStatus, "/robot_a/transition", []
        )

    def place(self) -> str:
        """Return the last transition, in words."""
        return f"; the last transition: {self.statuses[-1]}" if self.statuses else ""

    def status(self) -> TransitionStatus:
        """Return the last status of a transition that was heard, or an empty one."""
        return self.statuses[-1] if self.statuses else TransitionStatus()

    def until_told(
        self, condition: Callable[[TransitionStatus], bool], what: str = "a transition"
    ) -> TransitionStatus:
        """Return the first status from now on for which a condition holds, and wait for it."""
        begun = max(0, len(self.statuses) - 1)

        def found() -> TransitionStatus | None:
            return next((status for status in self.statuses[begun:] if condition(status)), None)

        self.until(found, what)
        status = found()
        assert status is not None
        return status
