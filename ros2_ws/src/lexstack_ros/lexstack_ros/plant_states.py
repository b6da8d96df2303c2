"""The plant's states as the controllers hear them: checked, in order, each tick once."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.node import Node

from lexstack_core.errors import InputError
from lexstack_core.model import Team
from lexstack_core.state import RobotState
from lexstack_interfaces.msg import PlantState
from lexstack_ros.conversions import to_state
from lexstack_ros.qos import STREAM
from lexstack_ros.readiness import Readiness


class PlantStates:
    """A subscription to /plant/state; also says when the node is ready.

    Attributes:
        refused: messages that did not fit, whoever of the node refused them.
    """

    def __init__(
        self,
        node: Node,
        team: Team,
        on_state: Callable[[RobotState], None],
        on_reset: Callable[[], None],
    ) -> None:
        """Call ``on_state`` for every new tick, and before it ``on_reset`` if the plant was reset.

        Create this after the node's other topics: readiness looks at all of them.
        """
        self.refused = 0
        self._node = node
        self._team = team
        self._on_state = on_state
        self._on_reset = on_reset
        self._last = -1
        node.create_subscription(PlantState, "/plant/state", self._take, STREAM)
        self._readiness = Readiness(node, hears_plant=False)

    def refuse(self, error: InputError) -> None:
        """Count and tell of a message that does not fit."""
        self.refused += 1
        self._node.get_logger().warning(f"refused: {error}", throttle_duration_sec=1.0)

    def _take(self, message: PlantState) -> None:
        """Hand on a state that is new; a paused plant repeats its last one."""
        self._readiness.hears_plant = True
        if message.status == PlantState.PAUSED:
            return
        try:
            state = to_state(message, self._team)
        except InputError as error:
            self.refuse(error)
            return
        if state.tick == 0 < self._last:
            self._node.get_logger().info("the plant was reset: starting anew")
            self._on_reset()
            self._last = -1
        if state.tick > self._last:
            self._last = state.tick
            self._on_state(state)
