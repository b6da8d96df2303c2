"""What every node reads at its start: the resolved scenario."""

from __future__ import annotations

from pathlib import Path

from rcl_interfaces.msg import ParameterDescriptor
from rclpy.node import Node

from lexstack_core.config.resolved import ResolvedScenario
from lexstack_core.errors import ConfigurationError


def text_parameter(node: Node, name: str, description: str, default: str | None = None) -> str:
    """Declare a read-only text and return it; raises ConfigurationError where it must be given."""
    descriptor = ParameterDescriptor(description=description, read_only=True)
    value = str(node.declare_parameter(name, default or "", descriptor).value)
    if not value and default is None:
        raise ConfigurationError(
            f"{node.get_name()}: parameter {name!r} ({description}) is missing; "
            f"give it by --ros-args -p {name}:=..."
        )
    return value


def flag_parameter(node: Node, name: str, description: str, *, default: bool) -> bool:
    """Declare a read-only switch and return it."""
    descriptor = ParameterDescriptor(description=description, read_only=True)
    return bool(node.declare_parameter(name, default, descriptor).value)


def scenario_parameter(node: Node) -> ResolvedScenario:
    """Return the resolved scenario whose file the parameter ``scenario`` names."""
    path = Path(text_parameter(node, "scenario", "file of the resolved scenario"))
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigurationError(f"{path}: cannot be read: {error}") from error
    return ResolvedScenario.from_yaml(text, str(path))
