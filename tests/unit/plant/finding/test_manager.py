"""The controller manager of ros2_control, with a module that stands for its messages.

It was written by the documents of controller_manager_msgs of Jazzy; no controller manager was here.
"""

from __future__ import annotations

import sys
from types import ModuleType, SimpleNamespace

import pytest

from lexstack_plant.finding import manager
from lexstack_plant.finding.endpoints import Controller
from lexstack_ros.node.calls import NoAnswerError

LIST = "controller_manager_msgs/srv/ListControllers"
SERVICE = "/cell/controller_manager/list_controllers"


def entry(name, state, claimed=(), required=()):
    return SimpleNamespace(
        name=name,
        state=state,
        type="joint_trajectory_controller/JointTrajectoryController",
        claimed_interfaces=list(claimed),
        required_command_interfaces=list(required),
    )


@pytest.fixture
def node():
    services = {SERVICE: [LIST], "/other": ["std_srvs/srv/Trigger"]}
    return SimpleNamespace(get_service_names_and_types=lambda: list(services.items()))


@pytest.fixture
def messages(monkeypatch):
    """Install a module in place of controller_manager_msgs."""
    kind = SimpleNamespace(Request=SimpleNamespace)
    module = ModuleType("controller_manager_msgs.srv")
    module.ListControllers = kind
    monkeypatch.setitem(
        sys.modules, "controller_manager_msgs", ModuleType("controller_manager_msgs")
    )
    monkeypatch.setitem(sys.modules, "controller_manager_msgs.srv", module)
    return kind


def test_controllers_are_in_the_namespace_of_their_manager(node, messages, monkeypatch):
    asked = []

    def call(_node, _executor, kind, name, _request, _seconds):
        asked.append((kind, name))
        arm = entry("arm", "active", ["j1/position", "j2/position"])
        return SimpleNamespace(controller=[arm, entry("base", "inactive", (), ["w/velocity"])])

    monkeypatch.setattr(manager, "call", call)
    found, notes = manager.find_controllers(node, None)
    assert asked == [(messages, SERVICE)]
    assert notes == []
    assert found == [
        Controller("/cell/arm", active=True, joints=("j1", "j2"), interface="position"),
        Controller("/cell/base", active=False, joints=("w",), interface="velocity"),
    ]


def test_a_manager_that_does_not_answer_is_named(node, messages, monkeypatch):
    def call(*_):
        raise NoAnswerError(f"{SERVICE}: nobody serves it within 5 s")

    monkeypatch.setattr(manager, "call", call)
    assert manager.find_controllers(node, None) == (
        [],
        [f"{SERVICE}: nobody serves it within 5 s"],
    )


def test_without_its_messages_a_note_says_so(node, monkeypatch):
    monkeypatch.setitem(sys.modules, "controller_manager_msgs.srv", None)
    found, notes = manager.find_controllers(node, None)
    assert found == []
    assert "controller_manager_msgs is not installed" in notes[0]


def test_without_a_manager_nothing_is_said():
    node = SimpleNamespace(get_service_names_and_types=list)
    assert manager.find_controllers(node, None) == ([], [])


def test_a_manager_in_the_root_and_mixed_interfaces():
    mixed = entry("arm", "active", ["j1/position", "j1/velocity"])
    assert manager.controller_of(mixed, "") == Controller("/arm", True, ("j1",), "")
