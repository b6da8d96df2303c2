"""The node of the page: hears what anybody may hear, asks what anybody may ask.

Its streams are best effort and read raw: a slow browser holds nobody up, and only what is shown
is decoded.
"""

from __future__ import annotations

import sys
from collections import deque
from functools import partial
from queue import Empty, SimpleQueue
from typing import Any

from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message
from trajectory_msgs.msg import JointTrajectory
from visualization_msgs.msg import MarkerArray

from lexstack.errors import InputError
from lexstack.references import References, measured
from lexstack.types import Matrix
from lexstack_bag.topics import PLAN, PLANT_STATE, PROGRESS, REQUEST
from lexstack_config.parts import build_team, home_of
from lexstack_interfaces.msg import Chi, PlantState, SequenceStatus, StackRequest
from lexstack_ros.controller.references import HeardReferences
from lexstack_ros.messages.conversions import to_seconds
from lexstack_ros.messages.names import FOXGLOVE, PAGE, URL, relative
from lexstack_ros.messages.qos import LATCHED
from lexstack_ros.node.options import FROM_COMMAND_LINE, NodeOptions
from lexstack_ros.node.parameters import port_parameter, scenario_parameter
from lexstack_ros.node.readiness import READY
from lexstack_ros.node.spin import LAST, run_node
from lexstack_ros.view.actions import Actions
from lexstack_ros.view.foxglove import Foxglove
from lexstack_ros.view.heard import COMMANDER, SOURCE, Heard, horizon_of, picture_of
from lexstack_ros.view.markers import MARKERS, Markers
from lexstack_ros.view.meshes import meshes_of
from lexstack_ros.view.orders import Known, Order
from lexstack_ros.view.page.live import LivePage
from lexstack_ros.view.stacks import Stacks

_PERIOD = 0.05  # s of wall time between two pictures
_OFFERED = 1.0  # s of wall time between two looks at what is served
_LATER = 1e6  # s after a decision: its references are at their goals
_OLD = 1.0  # s of simulated time after which a plan is no longer followed


class ViewNode(Node):
    """A user of the run with a page."""

    def __init__(self, options: NodeOptions = FROM_COMMAND_LINE) -> None:
        """Serve the page; raises LexstackError for a wrong parameter."""
        super().__init__(**options.arguments(PAGE))
        self.niceness = LAST
        self._resolved = resolved = scenario_parameter(self)
        self._team = team = build_team(resolved)
        # Of two ticks, and of every robot at most one at a tick.
        self._most = 2 * len(team.names)
        self._bytes: dict[str, deque[bytes]] = {}
        self._references = HeardReferences(self, team)
        self._orders: SimpleQueue[Order] = SimpleQueue()
        home = home_of(team, resolved)
        self._home = measured(team, home)
        scenario = resolved.scenario
        self._stacks = Stacks(team, resolved.stacks)
        known = Known(team.names, self._stacks.names, tuple(sorted(scenario.sequences)))
        self._page = LivePage(f"lexstack: {scenario.name}", team, home, known, self._orders.put)
        self._listen(PlantState, PLANT_STATE, 1)
        for name in (COMMANDER, SOURCE):
            self._listen(Chi, f"/{name}/chi", 1)
        self._listen(JointTrajectory, PLAN, self._most)
        self._listen(SequenceStatus, PROGRESS, self._most)
        self.create_subscription(StackRequest, relative(REQUEST), self._on_request, LATCHED)
        self._markers = Markers(team)
        self._markers_out = self.create_publisher(MarkerArray, relative(MARKERS), _newest(1))
        self._actions = Actions(self, team, scenario, self._page.say, self._page.refuse)
        wall = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(_PERIOD, self._look, clock=wall)
        self.create_timer(_OFFERED, self._offer, clock=wall)
        port = port_parameter(self, "foxglove", "port for Foxglove; -1: not served, 0: any free")
        self._foxglove = None if port is None else Foxglove(self, port, meshes_of(team))
        served = "" if self._foxglove is None else f"{FOXGLOVE}{self._foxglove.url}\n"
        print(f"{served}{URL}{self._page.url}\n{READY}", flush=True)

    def close(self) -> None:
        """Send the browsers away."""
        self._page.close()
        if self._foxglove is not None:
            self._foxglove.close()

    def _listen(self, kind: type, topic: str, depth: int) -> None:
        """Keep the last messages of a topic, as bytes."""
        self._bytes[topic] = deque(maxlen=depth)
        hear = partial(self._hear, topic)
        self.create_subscription(kind, relative(topic), hear, _newest(depth), raw=True)

    def _hear(self, topic: str, data: bytes) -> None:
        """Keep a message."""
        self._bytes[topic].append(data)

    def _on_request(self, message: StackRequest) -> None:
        """Learn a stack that a user has sent."""
        if message.stack_yaml:
            self._stacks.learn(message.stack_yaml)
            self._page.know_stacks(self._stacks.names)

    def _last(self, kind: type, topic: str) -> list[Any]:
        """Return the last messages of a topic; bytes that are none are left out."""
        found = []
        for data in self._bytes[topic]:
            try:
                found.append(deserialize_message(data, kind))
            except RuntimeError:
                continue
        return found

    def _offer(self) -> None:
        """Tell the page what is served."""
        if self._page.is_watched:
            self._page.offer(set(self._actions.offered()))

    def _look(self) -> None:
        """Carry orders out, and show what is new, if somebody looks, here or in RViz."""
        while True:
            try:
                self._actions.carry_out(self._orders.get_nowait())
            except Empty:
                break
        drawn = self._markers_out.get_subscription_count() > 0
        if not (drawn or self._page.is_watched) or not self._bytes[PLANT_STATE]:
            return
        states = self._last(PlantState, PLANT_STATE)
        if not states:
            return
        state = states[-1]
        chi = {
            name: message
            for name in (COMMANDER, SOURCE)
            for message in self._last(Chi, f"/{name}/chi")
        }
        now = to_seconds(state.header.stamp)
        try:
            statuses = chi[COMMANDER].transitions if COMMANDER in chi else ()
            frames = self._stacks.frames(statuses)
            heard = Heard(state, statuses, chi, self._horizons(now), self._work(state.tick), frames)
            picture = picture_of(self._team, heard, *self._in_effect(now))
        except InputError:
            return  # of another team: its controller says so
        if self._page.is_watched:
            self._actions.expect(frames)
            self._page.show(picture)
        if drawn:
            self._markers_out.publish(self._markers.message(picture))

    def _in_effect(self, now: float) -> tuple[References, References]:
        """Return the references in effect and their goals; first, where the robots start."""
        timeline = self._references.timeline
        if timeline.newest is None:
            return self._home, self._home
        return timeline.at(now), timeline.newest.references(timeline.newest.at + _LATER)

    def _horizons(self, now: float) -> dict[int, Matrix]:
        """Return the newest plan of each robot; none of before, and none of another team."""
        found = {}
        for plan in self._last(JointTrajectory, PLAN):
            if abs(now - to_seconds(plan.header.stamp)) <= _OLD:
                try:
                    robot, points = horizon_of(plan, self._team)
                except InputError:
                    continue
                found[robot] = points
        return found

    def _work(self, tick: int) -> list[SequenceStatus]:
        """Return the newest status of each robot's sequence that goes on."""
        heard = self._last(SequenceStatus, PROGRESS)
        ticks = _OLD * self._resolved.scenario.rate
        found = {one.robot: one for one in heard if abs(tick - one.tick) <= ticks}
        return list(found.values())


def _newest(depth: int) -> QoSProfile:
    """Return the quality of a stream of which only the last messages count."""
    best_effort = ReliabilityPolicy.BEST_EFFORT
    return QoSProfile(history=HistoryPolicy.KEEP_LAST, depth=depth, reliability=best_effort)


def main() -> int:
    """Run the page's node; returns the exit code."""
    return run_node(ViewNode)


if __name__ == "__main__":
    sys.exit(main())
