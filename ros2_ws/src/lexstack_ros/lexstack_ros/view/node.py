"""The node of the live page: hears what anybody may hear, asks what anybody may ask.

Its streams are best effort and read raw: a slow browser holds nobody up, and only what is shown
is decoded.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from concurrent.futures import Future
from functools import partial
from typing import Any

import numpy as np
from geometry_msgs.msg import PoseStamped
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message
from std_srvs.srv import Trigger

from lexstack_core.build import build_references
from lexstack_core.errors import InputError
from lexstack_core.model import Pose, Team
from lexstack_core.rotation import from_rpy, to_quaternion
from lexstack_interfaces.msg import Chi, PlantState, TransitionStatus
from lexstack_interfaces.srv import ApplyWrench, SwitchStack
from lexstack_ros.conversions import pose_message, to_seconds, to_vector
from lexstack_ros.parameters import scenario_parameter
from lexstack_ros.qos import STREAM
from lexstack_ros.readiness import READY
from lexstack_ros.references import TargetTopics
from lexstack_ros.spin import run_node
from lexstack_ros.view.hub import Hub
from lexstack_ros.view.news import news
from lexstack_ros.view.orders import Cancel, NewTarget, Order, Push, Switch, read_order
from lexstack_ros.view.page import live_page
from lexstack_ros.view.server import ViewError, ViewServer
from lexstack_ros.view.start import NAME, URL

_PERIOD = 0.05  # s of wall time between two news
_NEWEST = QoSProfile(
    history=HistoryPolicy.KEEP_LAST, depth=1, reliability=ReliabilityPolicy.BEST_EFFORT
)


class ViewNode(Node):
    """A user of the run with a page."""

    def __init__(self) -> None:
        """Serve the page; raises LexstackError for a wrong parameter."""
        super().__init__(NAME)
        self._resolved = scenario_parameter(self)
        self._team = team = Team.from_scenario(self._resolved)
        self._raw: dict[str, tuple[type, bytes]] = {}
        self._targets = TargetTopics(self, team, build_references(self._resolved, team))
        self._shown_at = 0.0
        self._hub = Hub()
        read = partial(read_order, robots=team.names, stacks=tuple(sorted(self._resolved.stacks)))
        self._server = ViewServer(live_page(self._resolved, team), self._hub, read)
        streams = {"/plant/state": PlantState, "/robot_a/transition": TransitionStatus}
        streams |= {f"/{name}/chi": Chi for name in team.names}
        for topic, kind in streams.items():
            hear = partial(self._hear, topic, kind)
            self.create_subscription(kind, topic, hear, _NEWEST, raw=True)
        self._out = {
            (name, kind): self.create_publisher(PoseStamped, f"/{name}/{kind}_target", STREAM)
            for name in team.names
            for kind in ("ee", "base")
        }
        self._switch = self.create_client(SwitchStack, "/robot_a/switch_stack")
        self._cancel = self.create_client(Trigger, "/robot_a/cancel_transition")
        self._push = self.create_client(ApplyWrench, "/sim_bridge/apply_wrench")
        wall = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(_PERIOD, self._look, clock=wall)
        print(f"{URL}{self._server.url}\n{READY}", flush=True)

    def close(self) -> None:
        """Send the browsers away."""
        self._hub.close()
        self._server.close()

    # ---- what the run says

    def _hear(self, topic: str, kind: type, data: bytes) -> None:
        """Keep the newest."""
        self._raw[topic] = (kind, data)

    def _newest(self, topic: str) -> Any:
        """Return the newest message of a topic, or None."""
        kind, data = self._raw.get(topic, (None, b""))
        return None if kind is None else deserialize_message(data, kind)

    def _look(self) -> None:
        """Carry orders out, and tell the page what is new, if somebody looks."""
        while (entry := self._hub.take()) is not None:
            self._carry_out(*entry)
        if not self._hub.is_watched:
            return
        state = self._newest("/plant/state")
        if state is None or len(state.q) != self._team.n:
            return
        try:
            to_vector(state.q, self._team.n, "/plant/state: q")
        except InputError:
            return
        now = to_seconds(state.header.stamp)
        if now < self._shown_at:  # the plant was reset
            self._targets.schedule = build_references(self._resolved, self._team)
        self._shown_at = now
        chi = {name: self._newest(f"/{name}/chi") for name in self._team.names}
        known = {name: message for name, message in chi.items() if message is not None}
        references = self._targets.schedule.at(now)
        status = self._newest("/robot_a/transition")
        self._hub.publish(news(self._team, state, status, known, references))

    # ---- what the page asks

    def _carry_out(self, order: Order, answer: Future[str]) -> None:
        """Do what was asked; the answer comes now or when the service has answered."""
        try:
            match order:
                case Switch():
                    request = SwitchStack.Request(stack=order.stack, duration=order.duration)
                    self._call(self._switch, request, answer, lambda a: (a.accepted, a.message))
                case Cancel():
                    request = Trigger.Request()
                    self._call(self._cancel, request, answer, lambda a: (a.success, a.message))
                case Push():
                    request = _wrench(order)
                    self._call(self._push, request, answer, lambda a: (a.success, a.message))
                case NewTarget():
                    answer.set_result(self._send_target(order))
        except ViewError as error:
            answer.set_exception(error)

    def _call(
        self,
        client: Any,
        request: Any,
        answer: Future[str],
        read: Callable[[Any], tuple[bool, str]],
    ) -> None:
        """Call a service; ``read`` says whether its answer is a yes, and its words."""
        if not client.service_is_ready():
            raise ViewError(f"{client.srv_name} is not there")

        def done(future: Any) -> None:
            accepted, text = read(future.result())
            if accepted:
                answer.set_result(text or "done")
            else:
                answer.set_exception(ViewError(text or "refused"))

        client.call_async(request).add_done_callback(done)

    def _send_target(self, order: NewTarget) -> str:
        """Publish a reference from now on; an end effector keeps its direction."""
        robot = self._team.index(order.robot)
        if order.kind == "ee":
            state = self._newest("/plant/state")
            now = 0.0 if state is None else to_seconds(state.header.stamp)
            pose = Pose(np.array(order.values), self._targets.schedule.at(now).ee[robot].rotation)
        else:
            x, y, yaw = order.values
            pose = Pose(np.array([x, y, 0.0]), from_rpy((0.0, 0.0, yaw)))
        message = pose_message(pose, 0.0, to_quaternion(pose.rotation))
        self._out[order.robot, order.kind].publish(message)
        return f"target sent: {order.robot}, {order.kind}"


def _wrench(order: Push) -> ApplyWrench.Request:
    """Return the service's request."""
    request = ApplyWrench.Request(robot=order.robot, link=order.link, duration=order.duration)
    force = request.wrench.force
    force.x, force.y, force.z = order.force
    return request


def main() -> int:
    """Run the live page's node; returns the exit code."""
    return run_node(ViewNode)


if __name__ == "__main__":
    sys.exit(main())
