"""The plant's states as the controllers hear them: checked, in order, each tick once.

They come as bytes (``messages.cdr``). What is not to be served is looked at only as far as its
sender, tick and robots.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.node import Node

from lexstack.errors import InputError
from lexstack.robots import Team
from lexstack.types import RobotState
from lexstack_interfaces.msg import PlantState
from lexstack_ros.intake.delays import Delays, with_info
from lexstack_ros.intake.drain import waiting
from lexstack_ros.intake.tick_order import TickOrder
from lexstack_ros.messages.cdr import Reader
from lexstack_ros.messages.conversions import check_robots, to_state
from lexstack_ros.messages.names import relative
from lexstack_ros.messages.qos import STREAM
from lexstack_ros.node.diagnostics import first
from lexstack_ros.node.readiness import Readiness
from lexstack_ros.node.sole_sender import SoleSender

_TOPIC = "/plant/state"
# A bridge that waits for a command is silent for `command_wall`, 2 s by default.
_SILENCE = 5.0  # s of wall time


class PlantStates:
    """A subscription to /plant/state; also says when the node is ready.

    Attributes:
        refused: messages that did not fit, whoever of the node refused them.
        skipped: states that were left out for newer ones.
        delays: how old states are when they come, by the clocks of both hosts.
    """

    def __init__(
        self,
        node: Node,
        team: Team,
        on_state: Callable[[RobotState], None],
        on_reset: Callable[[], None],
        on_commander: Callable[[str, bool], bool] = lambda _name, _follows: True,
        *,
        newest: int = 0,
        wanted: Callable[[int], bool] = lambda _tick: True,
    ) -> None:
        """Call ``on_state`` for every new tick, and before it ``on_reset`` if the plant was reset.

        Only for the ticks that are ``wanted``; ``newest_state`` gives the others' to whom asks.

        With ``newest`` states are skipped while newer ones wait, except for the newest one whose
        tick is a multiple of ``newest``: 1 leaves the very newest alone. Where the plant does not
        wait for it, a node that has fallen behind would else answer every state of its queue too
        late, for as long as it has no time to catch up.

        ``on_commander`` is told whose commands the plant takes, and whether it has one for the
        last tick; the state is left out where it returns False.

        Create this after the node's other topics: readiness looks at all of them.
        """
        self.refused = self.skipped = 0
        self._rejection = ""  # the last one since the last report
        self.delays = Delays(_TOPIC)
        self._node = node
        self._team = team
        self._on_state = on_state
        self._on_reset = on_reset
        self._on_commander = on_commander
        self._sender = SoleSender(_TOPIC, _SILENCE)
        self._order = TickOrder(_TOPIC)
        self._newest = newest
        self._wanted = wanted
        self._unserved: list[RobotState] = []
        self._last: RobotState | None = None
        self._unchecked: Any = None  # a newer message whose vectors nobody has looked at
        self._read = Reader(PlantState, _TOPIC)
        self._subscription = node.create_subscription(
            PlantState, relative(_TOPIC), with_info(self._take), STREAM, raw=True
        )
        self._readiness = Readiness(node, hears_plant=False)

    def refuse(self, error: InputError) -> None:
        """Count and tell of a message that does not fit; no flood of lines."""
        self.note_rejection(error)
        self._node.get_logger().warning(f"refused: {error}", throttle_duration_sec=1.0)

    def note_rejection(self, error: InputError) -> None:
        """Count a message that does not fit, for the next report."""
        self.refused += 1
        self._rejection = f"refused: {error}"

    def report(self) -> tuple[str, dict[str, str]]:
        """Return a complaint (or '') and the figures since the last report."""
        complaint, values = self.delays.report()
        rejection, self._rejection = self._rejection, ""
        return first(complaint, rejection), values

    @property
    def newest_state(self) -> RobotState | None:
        """The newest state, whether its tick was wanted or not; None before the first."""
        message, self._unchecked = self._unchecked, None
        if message is not None:
            try:
                self._last = to_state(message, self._team)
            except InputError as error:
                self.refuse(error)
        return self._last

    def _hear(self, message: Any, info: dict[str, int]) -> None:
        """Take note of a message that is the plant's."""
        self._sender.follow(message.sender)
        self.delays.add(info)

    def _take(self, data: bytes, info: dict[str, int]) -> None:
        """Hand on the states that wait and are to be served, all in order or the newest."""
        for entry in ((data, info), *waiting(self._subscription)):
            state = self._checked(*entry)
            if state is not None:
                self._unserved.append(state)
        served = self._worth_serving(self._unserved)
        self.skipped += len(self._unserved) - len(served)
        self._unserved = []
        for state in served:
            self._on_state(state)

    def _worth_serving(self, states: list[RobotState]) -> list[RobotState]:
        """Return all states, or the newest one that is due and the newest one of all."""
        if not self._newest:
            return states
        due = [state for state in states if not state.tick % self._newest][-1:]
        return due if due and due[0] is states[-1] else [*due, *states[-1:]]

    def _checked(self, data: bytes, info: dict[str, int]) -> RobotState | None:
        """Return a state that is new and to be served; a paused plant repeats its last one."""
        self._readiness.hears_plant = True
        state: RobotState | None = None
        try:
            message = self._read(data)
            self._sender.check(message.sender)
            if message.status == PlantState.PAUSED:
                self._hear(message, info)
                return None
            if self._wanted(message.tick):
                state = to_state(message, self._team)
            else:
                check_robots(message.robots, self._team, _TOPIC)
            sent = 1e-9 * info["source_timestamp"]
            if not self._order.is_new(message.sender, message.resets, message.tick, sent):
                return None
        except InputError as error:
            self.refuse(error)
            return None
        self._hear(message, info)
        if self._order.begins_anew:
            self._node.get_logger().info("the plant was reset: starting anew")
            self._unserved.clear()  # of before it
            self._on_reset()
            self._last = self._unchecked = None
        follows = message.status == PlantState.FOLLOWING
        if message.commander and not self._on_commander(message.commander, follows):
            return None
        if state is None:
            self._unchecked = message
        else:
            self._last, self._unchecked = state, None
        return state
