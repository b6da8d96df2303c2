"""Carries out what the page asks for, by the topics, services and actions that anybody may use."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Any

import numpy as np
from geometry_msgs.msg import PoseStamped
from rclpy.action import ActionClient
from rclpy.node import Node
from rclpy.publisher import Publisher
from std_msgs.msg import String
from std_srvs.srv import SetBool, Trigger

from lexstack.errors import LexstackError
from lexstack.mpc import tasks_of
from lexstack.references import TOOL, Frame
from lexstack.robots import Pose, Team, from_rpy, to_quaternion
from lexstack_config.scenario import ScenarioConfig
from lexstack_interfaces.action import ExecuteSequence
from lexstack_interfaces.srv import ApplyWrench, SwitchStack
from lexstack_ros.controller.target_topics import topic_name
from lexstack_ros.messages.conversions import pose_message
from lexstack_ros.messages.names import relative
from lexstack_ros.messages.plans import task_message
from lexstack_ros.messages.qos import STREAM
from lexstack_ros.view import orders
from lexstack_ros.view.page.controls import ENABLE, PLANT, PUSH, SEQUENCES, SWITCH


class RefusedError(LexstackError):
    """An order could not be carried out; the text says why."""


class Actions:
    """Publishers and clients of a node that is a user of the run."""

    def __init__(
        self,
        node: Node,
        team: Team,
        scenario: ScenarioConfig,
        tell: Callable[[str], None],
        refuse: Callable[[str], None],
    ) -> None:
        """Make them.

        Args:
            node: whose they are.
            team: the robots.
            scenario: with its sequences.
            tell: takes what became of an order.
            refuse: takes why one was not carried out.
        """
        self._scenario, self._tell, self._refuse = scenario, tell, refuse
        self._node, self._team = node, team
        self._targets: dict[str, Publisher] = {}
        for name in team.names:
            for kind in ("ee_target", "base_target"):
                self._add_target(f"{name}/{kind}")
        self._switch = node.create_client(SwitchStack, "robot_a/switch_stack")
        self._cancel = node.create_client(Trigger, "robot_a/cancel_transition")
        self._push = node.create_client(ApplyWrench, "sim_bridge/apply_wrench")
        self._pause = node.create_client(SetBool, "sim_bridge/pause")
        self._step = node.create_client(Trigger, "sim_bridge/step")
        self._reset = node.create_client(Trigger, "sim_bridge/reset")
        self._enable = {name: node.create_client(SetBool, f"{name}/enable") for name in team.names}
        self._sequences: ActionClient | None = None
        if scenario.sequences:
            self._sequences = ActionClient(node, ExecuteSequence, "htmpc/execute_sequence")
            self._release = node.create_publisher(String, "htmpc/release", STREAM)
        self._goal: Any = None

    def offered(self) -> Iterator[str]:
        """Yield what is served now, by the names of ``controls``."""
        clients = {
            SWITCH: (self._switch, self._cancel),
            PUSH: (self._push,),
            PLANT: (self._pause, self._step, self._reset),
            **{f"{ENABLE} {name}": (client,) for name, client in self._enable.items()},
        }
        for name, needed in clients.items():
            if all(client.service_is_ready() for client in needed):
                yield name
        if self._sequences is not None and self._sequences.server_is_ready():
            yield SEQUENCES

    def expect(self, frames: Iterable[Frame]) -> None:
        """Be ready for targets of further frames: the first one would come before discovery."""
        for robot, frame in frames:
            self._add_target(_topic_of(self._team.names[robot], frame))

    def _add_target(self, topic: str) -> None:
        """Create the publisher of a topic, once."""
        if topic not in self._targets:
            self._targets[topic] = self._node.create_publisher(PoseStamped, relative(topic), STREAM)

    def carry_out(self, order: orders.Order) -> None:
        """Do what was asked; the answer is told now, or when the service has answered."""
        try:
            self._carry_out(order)
        except RefusedError as error:
            self._refuse(str(error))

    def _carry_out(self, order: orders.Order) -> None:
        """Do what was asked; raises RefusedError."""
        match order:
            case orders.ToolTarget() | orders.BaseTarget():
                self._send_target(order)
            case orders.Execute():
                self._execute(order.sequence)
            case orders.Stop():
                self._stop()
            case orders.Release():
                self._release_held()
            case _:
                self._call(*self._request(order))

    def _request(self, order: orders.Order) -> tuple[Any, Any]:
        """Return the client and the request of an order that is a service's."""
        found: dict[type, tuple[Any, Callable[[Any], Any]]] = {
            orders.Switch: (
                self._switch,
                lambda o: SwitchStack.Request(stack=o.stack, duration=o.duration),
            ),
            orders.SwitchToText: (
                self._switch,
                lambda o: SwitchStack.Request(stack_yaml=o.text, duration=o.duration),
            ),
            orders.Cancel: (self._cancel, lambda _: Trigger.Request()),
            orders.Push: (self._push, _wrench),
            orders.Pause: (self._pause, lambda o: SetBool.Request(data=o.paused)),
            orders.Step: (self._step, lambda _: Trigger.Request()),
            orders.Reset: (self._reset, lambda _: Trigger.Request()),
        }
        if isinstance(order, orders.Enable):
            return self._enable[order.robot], SetBool.Request(data=order.enabled)
        client, request = found[type(order)]
        return client, request(order)

    def _send_target(self, order: orders.ToolTarget | orders.BaseTarget) -> None:
        """Publish a reference from now on."""
        if isinstance(order, orders.ToolTarget):
            topic, turn = _topic_of(order.robot, order.frame), np.array(order.quaternion)
            what = "ee" if order.frame == TOOL else order.frame
            pose = Pose(np.array(order.position), np.eye(3))
        else:
            x, y, yaw = order.place
            topic, turn = f"{order.robot}/base_target", to_quaternion(from_rpy((0.0, 0.0, yaw)))
            what = "base"
            pose = Pose(np.array([x, y, 0.0]), np.eye(3))
        self._add_target(topic)
        self._targets[topic].publish(pose_message(pose, 0.0, turn))
        place = ", ".join(f"{value:.3f}" for value in pose.position)
        self._tell(f"target sent: {order.robot}, {what}: {place} m")

    def _call(self, client: Any, request: Any) -> None:
        """Call a service; its message is told, or the reason of a refusal."""
        if not client.service_is_ready():
            raise RefusedError(f"{client.srv_name} is not there")

        def done(future: Any) -> None:
            said = future.result()
            agreed = said.accepted if hasattr(said, "accepted") else said.success
            (self._tell if agreed else self._refuse)(
                said.message or ("done" if agreed else "refused")
            )

        client.call_async(request).add_done_callback(done)

    def _execute(self, name: str) -> None:
        """Send a sequence of the scenario as a goal."""
        if self._sequences is None or not self._sequences.server_is_ready():
            raise RefusedError("/htmpc/execute_sequence is not there")
        config = self._scenario.sequences[name]
        goal = ExecuteSequence.Goal(robot=config.robot, architecture=config.architecture)
        goal.tasks = [task_message(task) for task in tasks_of(config)]

        def answered(future: Any) -> None:
            handle = future.result()
            if not handle.accepted:
                self._refuse(f"sequence {name}: refused; the log of htmpc says why")
                return
            self._goal = handle
            self._tell(f"sequence {name} begins")
            handle.get_result_async().add_done_callback(finished)

        def finished(future: Any) -> None:
            result = future.result().result
            word = "all tasks are done" if result.success else result.message
            self._tell(f"sequence {name}: {result.done} done: {word}")

        self._sequences.send_goal_async(goal).add_done_callback(answered)

    def _stop(self) -> None:
        """Cancel the goal that was sent last."""
        if self._goal is None:
            raise RefusedError("this page has begun no sequence")
        self._goal.cancel_goal_async()
        self._tell("the sequence is cancelled")

    def _release_held(self) -> None:
        """Release every task that a sequence of the scenario holds."""
        held = {
            f"{config.robot}/{task.name}"
            for config in self._scenario.sequences.values()
            for task in tasks_of(config)
            if task.held
        }
        if not held:
            raise RefusedError("no task of these sequences is held")
        for name in sorted(held):
            self._release.publish(String(data=name))
        self._tell(f"released: {', '.join(sorted(held))}")


def _topic_of(robot: str, frame: str) -> str:
    """Return the topic of the targets of a robot's frame."""
    return f"{robot}/ee_target" if frame == TOOL else f"{robot}/{topic_name(frame)}/ee_target"


def _wrench(order: orders.Push) -> ApplyWrench.Request:
    """Return the service's request."""
    request = ApplyWrench.Request(robot=order.robot, link=order.link, duration=order.duration)
    force = request.wrench.force
    force.x, force.y, force.z = order.force
    return request
