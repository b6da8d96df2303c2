"""The sequences of a scenario, sent to the HTMPC as any user would."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from rclpy.action import ActionClient
from rclpy.node import Node
from rclpy.task import Future

from lexstack.errors import InputError
from lexstack.mpc import SequenceConfig, SequenceTask, tasks_of
from lexstack_config.scenario import EventConfig, ScenarioConfig, SequenceChangeConfig
from lexstack_interfaces.action import ExecuteSequence
from lexstack_interfaces.msg import SequenceTask as TaskMessage
from lexstack_interfaces.srv import ChangeSequence
from lexstack_ros.messages.plans import task_message

_CHANGES = {
    "release": ChangeSequence.Request.RELEASE,
    "retarget": ChangeSequence.Request.RETARGET,
    "cancel": ChangeSequence.Request.CANCEL,
}


class SequenceClient:
    """Sends goals and changes, each for the tick of its event.

    Attributes:
        results: what has come back, by the name of the sequence.
    """

    def __init__(self, node: Node, scenario: ScenarioConfig) -> None:
        """Connect to the HTMPC; raises InputError for a task that cannot be."""
        self.results: dict[str, ExecuteSequence.Result] = {}
        self._node = node
        self._scenario = scenario
        self._tasks = {name: tasks_of(entry) for name, entry in scenario.sequences.items()}
        self._action = ActionClient(node, ExecuteSequence, "htmpc/execute_sequence")
        self._change = node.create_client(ChangeSequence, "htmpc/change_sequence")

    @property
    def ready(self) -> bool:
        """Whether the HTMPC serves."""
        return bool(self._action.server_is_ready() and self._change.service_is_ready())

    def send(self, event: EventConfig, call: Callable[[Any, Any], Any]) -> None:
        """Send what an event says of sequences; ``call`` waits for a service's answer."""
        tick = round(event.at * self._scenario.rate)
        for name in event.execute:
            self._execute(name, self._scenario.sequences[name], tick)
        for change in event.changes:
            answer = call(self._change, self._request(change, tick))
            if not answer.accepted:
                raise InputError(f"{change.change} {change.task!r} refused: {answer.message}")

    def _execute(self, name: str, config: SequenceConfig, tick: int) -> None:
        """Send a sequence as a goal."""
        goal = ExecuteSequence.Goal(
            robot=config.robot, architecture=config.architecture, at_tick=tick
        )
        goal.tasks = [task_message(task) for task in self._tasks[name]]

        def answered(future: Future) -> None:
            if future.result().accepted:
                future.result().get_result_async().add_done_callback(finished)
            else:
                keep(ExecuteSequence.Result(message="refused; the log of htmpc says why"))

        def finished(future: Future) -> None:
            keep(future.result().result)

        def keep(result: ExecuteSequence.Result) -> None:
            self.results[name] = result
            word = "all tasks are done" if result.success else result.message
            self._node.get_logger().info(f"sequence {name}: {result.done} done: {word}")

        self._action.send_goal_async(goal).add_done_callback(answered)

    def _request(self, change: SequenceChangeConfig, tick: int) -> ChangeSequence.Request:
        """Return a change as a request."""
        message = TaskMessage(name=change.task)
        if change.change == "retarget":
            task = self._task(change.robot, change.task)
            message = task_message(replace(task, points=change.points))
        return ChangeSequence.Request(
            robot=change.robot, change=_CHANGES[change.change], task=message, at_tick=tick
        )

    def _task(self, robot: str, name: str) -> SequenceTask:
        """Return a task of the scenario's sequences of a robot; raises InputError."""
        tasks = [
            task
            for key, entry in self._scenario.sequences.items()
            if entry.robot == robot
            for task in self._tasks[key]
        ]
        for task in tasks:
            if task.name == name:
                return task
        known = ", ".join(task.name for task in tasks) or "none"
        raise InputError(f"events: changes: {robot}: unknown task {name!r}; known: {known}")
