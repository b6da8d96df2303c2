"""The controllers of ros2_control, by its controller manager, where its messages are installed."""

from __future__ import annotations

import importlib
from typing import Any

from rclpy.executors import Executor
from rclpy.node import Node

from lexstack_plant.finding.endpoints import Controller
from lexstack_ros.node.calls import NoAnswerError, call

_LIST = "controller_manager_msgs/srv/ListControllers"
_ANSWER = 5.0  # s of wall time


def find_controllers(node: Node, executor: Executor) -> tuple[list[Controller], list[str]]:
    """Ask every controller manager; return controllers, and notes on what could not be asked."""
    services = [name for name, kinds in node.get_service_names_and_types() if _LIST in kinds]
    found: list[Controller] = []
    notes: list[str] = []
    if not services:
        return found, notes
    try:
        kind = importlib.import_module("controller_manager_msgs.srv").ListControllers
    except ModuleNotFoundError:
        absent = "controller_manager_msgs is not installed: which controllers are active is unknown"
        return found, [f"{services[0]} is there, but {absent}"]
    for service in services:
        try:
            answer = call(node, executor, kind, service, kind.Request(), _ANSWER)
        except NoAnswerError as error:
            notes.append(str(error))
            continue
        namespace = service.rsplit("/", 2)[0]
        found += [controller_of(entry, namespace) for entry in answer.controller]
    return found, notes


def controller_of(entry: Any, namespace: str) -> Controller:
    """Return a controller as values.

    Args:
        entry: controller_manager_msgs/ControllerState. Its interfaces have names like
            ``joint_1/velocity``; an inactive controller claims none, but says what it requires.
        namespace: of the controller manager, in which its controllers are; '' is the root.
    """
    claimed = [*entry.claimed_interfaces] or [*entry.required_command_interfaces]
    pairs = [each.rpartition("/") for each in claimed]
    joints = tuple(dict.fromkeys(joint for joint, _, _ in pairs))
    kinds = {kind for _, _, kind in pairs}
    interface = kinds.pop() if len(kinds) == 1 else ""
    return Controller(f"{namespace}/{entry.name}", entry.state == "active", joints, interface)
