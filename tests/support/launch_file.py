"""The launch file as a module, also where launch is missing: then a stand-in takes its place."""

from __future__ import annotations

import importlib.util
import sys
import types
from types import SimpleNamespace

import yaml

from lexstack_bringup.processes import MODULES
from lexstack_ros.messages.names import base_of
from support.scenario import ROOT

LAUNCH = ROOT / "ros2_ws/src/lexstack_bringup/launch/run.launch.py"
IS_HERE = bool(importlib.util.find_spec("launch") and importlib.util.find_spec("launch_ros"))


class Made(SimpleNamespace):
    """An action of launch as it was made."""

    def __init__(self, *arguments, **given):
        super().__init__(arguments=arguments, **given)


def stand_in(monkeypatch):
    """Put a stand-in for launch among the modules."""
    configuration = type(
        "LaunchConfiguration",
        (),
        {
            "__init__": lambda self, name: setattr(self, "name", name),
            "perform": lambda self, context: context[self.name],
        },
    )
    actions = ("DeclareLaunchArgument", "OpaqueFunction", "Shutdown")
    for name, content in {
        "launch": {"LaunchContext": dict, "LaunchDescription": Made},
        "launch.actions": dict.fromkeys(actions, Made),
        "launch.substitutions": {"LaunchConfiguration": configuration},
        "launch_ros": {},
        "launch_ros.actions": {"Node": Made},
    }.items():
        module = types.ModuleType(name)
        vars(module).update(content)
        monkeypatch.setitem(sys.modules, name, module)


def loaded():
    """Return the launch file as a module."""
    spec = importlib.util.spec_from_file_location("run_launch", LAUNCH)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def command_line(node, folder):
    """Return module and arguments with which launch would start a node, by its documents.

    It writes the parameters into a file, and gives name, namespace and remappings as rules.
    """
    file = folder / f"{node.name}.yaml"
    (parameters,) = node.parameters
    file.write_text(yaml.safe_dump({"/**": {"ros__parameters": parameters}}), encoding="utf-8")
    rules = [f"__node:={node.name}", f"__ns:=/{node.namespace.strip('/')}"]
    rules += [f"{old}:={new}" for old, new in node.remappings]
    words = [word for rule in rules for word in ("-r", rule)]
    return MODULES[base_of(node.name)], ["--ros-args", *words, "--params-file", str(file)]
