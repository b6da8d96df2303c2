"""How a user changes a sequence under way: a service, and a topic for releases."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

from rclpy.node import Node
from std_msgs.msg import String

from lexstack.errors import InputError
from lexstack.mpc import Change
from lexstack.options import shown
from lexstack.robots import Team
from lexstack_interfaces.srv import ChangeSequence
from lexstack_ros.messages.names import relative
from lexstack_ros.messages.plans import to_task
from lexstack_ros.messages.qos import STREAM

_WHERE = "/htmpc/change_sequence"
_KINDS: tuple[Literal["release", "retarget", "insert", "cancel"], ...] = (
    "release",
    "retarget",
    "insert",
    "cancel",
)  # in the order of the service's constants


@dataclass(frozen=True, slots=True)
class Wish:
    """A change that somebody asks for.

    Attributes:
        robot: its place in the team; None: the one with a sequence under way.
        change: see there; without the points of a retarget.
        task: of a retarget, the message that has its points.
        at_tick: from which on it holds; 0: now.
    """

    robot: int | None
    change: Change
    task: Any = None
    at_tick: int = 0


Apply = Callable[[Wish], str]
"""Changes a sequence, now or later; returns what was done, or raises InputError."""


class SequenceChanges:
    """Serves /htmpc/change_sequence, and hears /htmpc/release: NAME or ROBOT/NAME."""

    def __init__(self, node: Node, team: Team, apply: Apply) -> None:
        """Hand changes to ``apply``."""
        self._node = node
        self._team = team
        self._apply = apply
        node.create_service(ChangeSequence, relative(_WHERE), self._on_change)
        node.create_subscription(String, "htmpc/release", self._on_release, STREAM)

    def _on_change(
        self, request: ChangeSequence.Request, response: ChangeSequence.Response
    ) -> ChangeSequence.Response:
        """Change, or refuse with the reason."""
        try:
            robot = None if not request.robot else self._robot(request.robot)
            wish = Wish(robot, _change(request), request.task, int(request.at_tick))
            response.message = self._apply(wish)
            response.accepted = True
        except InputError as error:
            response.message = str(error)
        return response

    def _on_release(self, message: String) -> None:
        """Release a held task."""
        robot, _, name = message.data.rpartition("/")
        try:
            self._apply(Wish(self._robot(robot) if robot else None, Change("release", name)))
        except InputError as error:
            self._node.get_logger().warning(
                f"refused: /htmpc/release: {error}", throttle_duration_sec=1.0
            )

    def _robot(self, name: str) -> int:
        """Return a robot's place; raises InputError for an unknown one."""
        if name not in self._team.names:
            known = ", ".join(self._team.names)
            raise InputError(f"{_WHERE}: robot: unknown {shown(name)}; known: {known}")
        return self._team.names.index(name)


def _change(request: ChangeSequence.Request) -> Change:
    """Return what a request asks for; raises InputError."""
    if request.change >= len(_KINDS):
        raise InputError(f"{_WHERE}: change: {request.change} is not one of 0 to {len(_KINDS) - 1}")
    kind, task = _KINDS[request.change], request.task
    if kind != "insert":
        return Change(kind, task.name)
    made = to_task(task, f"{_WHERE}: task")
    return Change(kind, task.name, task=made, before=request.before)
