"""The node of the live page: hears what anybody may hear, asks what anybody may ask.

Its streams are best effort and read raw: a slow browser holds nobody up, and only what is shown
is decoded.
"""

from __future__ import annotations

import sys
from collections import deque
from functools import partial

from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message

from lexstack.errors import InputError
from lexstack.references import References, measured
from lexstack_config.parts import build_team, home_of
from lexstack_interfaces.msg import Chi, PlantState, TransitionStatus
from lexstack_ros.controller.references import HeardReferences
from lexstack_ros.messages.conversions import to_seconds, to_vector
from lexstack_ros.messages.names import PAGE, URL
from lexstack_ros.node.options import FROM_COMMAND_LINE, NodeOptions
from lexstack_ros.node.parameters import scenario_parameter
from lexstack_ros.node.readiness import READY
from lexstack_ros.node.spin import LAST, run_node
from lexstack_ros.view.actions import Actions
from lexstack_ros.view.hub import Hub
from lexstack_ros.view.news import COMMANDER, SOURCE, news
from lexstack_ros.view.orders import read_order
from lexstack_ros.view.page import live_page
from lexstack_ros.view.server import ViewServer

_PERIOD = 0.05  # s of wall time between two news


class ViewNode(Node):
    """A user of the run with a page."""

    def __init__(self, options: NodeOptions = FROM_COMMAND_LINE) -> None:
        """Serve the page; raises LexstackError for a wrong parameter."""
        super().__init__(**options.arguments(PAGE))
        self.niceness = LAST
        self._resolved = scenario_parameter(self)
        self._team = team = build_team(self._resolved)
        self._state: bytes | None = None
        self._chi: dict[str, bytes] = {}
        # Of two ticks, and of every robot at most one at a tick.
        most = 2 * len(team.names)
        self._statuses: deque[bytes] = deque(maxlen=most)
        self._references = HeardReferences(self, team)
        self._shown_at = 0.0
        self._hub = Hub()
        read = partial(read_order, robots=team.names, stacks=tuple(sorted(self._resolved.stacks)))
        self._server = ViewServer(live_page(self._resolved, team), self._hub, read)
        newest, many = _newest(1), _newest(most)
        self.create_subscription(PlantState, "plant/state", self._hear, newest, raw=True)
        of_a, of_b = (partial(self._hear_chi, name) for name in (COMMANDER, SOURCE))
        self.create_subscription(Chi, "robot_a/chi", of_a, newest, raw=True)
        self.create_subscription(Chi, "robot_b/chi", of_b, newest, raw=True)
        self.create_subscription(
            TransitionStatus, "robot_a/transition", self._hear_status, many, raw=True
        )
        self._actions = Actions(self, team, self._in_effect)
        wall = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(_PERIOD, self._look, clock=wall)
        print(f"{URL}{self._server.url}\n{READY}", flush=True)

    def close(self) -> None:
        """Send the browsers away."""
        self._hub.close()
        self._server.close()

    # ---- what the run says

    def _hear(self, data: bytes) -> None:
        """Keep the newest state of the plant."""
        self._state = data

    def _hear_status(self, data: bytes) -> None:
        """Keep the newest statuses of transitions."""
        self._statuses.append(data)

    def _hear_chi(self, controller: str, data: bytes) -> None:
        """Keep the newest solution of a controller."""
        self._chi[controller] = data

    def _look(self) -> None:
        """Carry orders out, and tell the page what is new, if somebody looks."""
        while (entry := self._hub.take()) is not None:
            self._actions.carry_out(*entry)
        if not self._hub.is_watched or self._state is None:
            return
        state = deserialize_message(self._state, PlantState)
        try:
            to_vector(state.q, self._team.nq, "/plant/state: q")
        except InputError:
            return
        now = to_seconds(state.header.stamp)
        self._shown_at = now
        chi = {name: deserialize_message(data, Chi) for name, data in sorted(self._chi.items())}
        self._hub.publish(news(self._team, state, self._transitions(), chi, self._in_effect()))

    def _in_effect(self) -> References:
        """Return the references in effect; before the first decision, where the robots start."""
        timeline = self._references.timeline
        if timeline.newest is None:
            return measured(self._team, home_of(self._team, self._resolved))
        return timeline.at(self._shown_at)

    def _transitions(self) -> list[TransitionStatus]:
        """Return the statuses of the last tick that is whole: those of one tick come one by one."""
        heard = [deserialize_message(data, TransitionStatus) for data in self._statuses]
        if not heard:
            return []
        last = heard[-1].tick
        before = [status.tick for status in heard if status.tick != last]
        whole = before[-1] if before else last
        return [status for status in heard if status.tick == whole]


def _newest(depth: int) -> QoSProfile:
    """Return the quality of a stream of which only the last messages count."""
    best_effort = ReliabilityPolicy.BEST_EFFORT
    return QoSProfile(history=HistoryPolicy.KEEP_LAST, depth=depth, reliability=best_effort)


def main() -> int:
    """Run the live page's node; returns the exit code."""
    return run_node(ViewNode)


if __name__ == "__main__":
    sys.exit(main())
