"""The quality of service of our topics: as the page says, and as the sources create it."""

from __future__ import annotations

import ast
import importlib
import re
from collections.abc import Iterator
from pathlib import Path

from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from support.scenario import ROOT

Qos = tuple[str, str, int]
"""Reliability, durability, depth."""

_SOURCES = [ROOT / "ros2_ws/src" / name / name for name in ("lexstack_ros", "lexstack_plant")]
_USERS = ("view/",)  # no node of a run


def documented_qos() -> dict[str, Qos]:
    """Return what docs/deployment.md says of each topic; NAME stands for a robot's."""
    text = (ROOT / "docs" / "deployment.md").read_text(encoding="utf-8")
    form = r"^\| (`/[^|]+) \| (reliable|best effort), (volatile|transient local) \| (\d+) \|"
    return {
        topic: (reliability, durability, int(depth))
        for topics, reliability, durability, depth in re.findall(form, text, re.M)
        for topic in re.findall(r"`([^`]+)`", topics)
    }


def created_qos(what: str) -> Iterator[tuple[str, Qos]]:
    """Yield topic and quality of service of every publisher or subscription of the nodes.

    Args:
        what: ``publisher`` or ``subscription``. Those whose topic is worked out are left out.
    """
    place = {"publisher": 2, "subscription": 3}[what]
    for folder in _SOURCES:
        for path in sorted(folder.rglob("*.py")):
            name = path.relative_to(folder).as_posix()
            if name.startswith(_USERS):
                continue
            module = ".".join([folder.name, *path.relative_to(folder).with_suffix("").parts])
            for call in _calls(path, f"create_{what}"):
                topic = _topic(call.args[1], module)
                if topic:
                    yield topic, _qos(call.args[place], module)


def _calls(path: Path, name: str) -> Iterator[ast.Call]:
    """Yield the calls of a method of some name."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Call) and getattr(node.func, "attr", "") == name:
            yield node


def _topic(node: ast.expr, module: str) -> str:
    """Return a topic with NAME in place of what a robot's name is put into, or ''."""
    if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "relative":
        node = node.args[0]
    if isinstance(node, ast.JoinedStr):
        value: object = "".join(
            str(part.value) if isinstance(part, ast.Constant) else "NAME" for part in node.values
        )
    else:
        value = _value(node, module)
    return "/" + value.removeprefix("/") if isinstance(value, str) else ""


def _qos(node: ast.expr, module: str) -> Qos:
    """Return a quality of service; a number alone is the depth of ROS' default."""
    value = _value(node, module)
    profile = value if isinstance(value, QoSProfile) else QoSProfile(depth=value)
    return (
        "reliable" if profile.reliability == ReliabilityPolicy.RELIABLE else "best effort",
        "volatile" if profile.durability == DurabilityPolicy.VOLATILE else "transient local",
        profile.depth,
    )


def _value(node: ast.expr, module: str) -> object:
    """Return a constant, or what a name means in a module, or None."""
    if isinstance(node, ast.Constant):
        return node.value
    if isinstance(node, ast.Name):
        return getattr(importlib.import_module(module), node.id, None)
    return None
