"""What every node reads at its start: the resolved scenario."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from rcl_interfaces.msg import IntegerRange, ParameterDescriptor
from rclpy.exceptions import ParameterException
from rclpy.node import Node
from rclpy.publisher import Publisher
from std_msgs.msg import String

from lexstack.errors import ConfigurationError
from lexstack_bag.topics import SCENARIO
from lexstack_config.resolved import ResolvedScenario
from lexstack_config.yaml_text import read_text
from lexstack_ros.messages.names import relative
from lexstack_ros.messages.qos import LATCHED


def text_parameter(node: Node, name: str, description: str, default: str | None = None) -> str:
    """Declare a read-only text and return it; raises ConfigurationError where it must be given."""
    descriptor = ParameterDescriptor(description=description, read_only=True)
    value = str(declared(node, name, default or "", descriptor))
    if not value and default is None:
        raise ConfigurationError(
            f"{node.get_name()}: parameter {name!r} ({description}) is missing; "
            f"give it by --ros-args -p {name}:=..."
        )
    return value


def flag_parameter(node: Node, name: str, description: str, *, default: bool) -> bool:
    """Declare a read-only switch and return it."""
    descriptor = ParameterDescriptor(description=description, read_only=True)
    return bool(declared(node, name, default, descriptor))


def count_parameter(node: Node, name: str, description: str, most: int) -> int:
    """Declare a read-only whole number from 1 to ``most``, by default 1, and return it."""
    span = IntegerRange(from_value=1, to_value=most, step=1)
    descriptor = ParameterDescriptor(description=description, read_only=True, integer_range=[span])
    return int(declared(node, name, 1, descriptor))


def port_parameter(node: Node, name: str, description: str) -> int | None:
    """Declare a read-only port, 0 meaning any free one, and return it; -1, the default: None."""
    span = IntegerRange(from_value=-1, to_value=65535, step=1)
    descriptor = ParameterDescriptor(description=description, read_only=True, integer_range=[span])
    port = int(declared(node, name, -1, descriptor))
    return None if port < 0 else port


def declared(node: Node, name: str, default: Any, descriptor: ParameterDescriptor) -> Any:
    """Declare a parameter and return its value; raises ConfigurationError for a wrong one."""
    try:
        return node.declare_parameter(name, default, descriptor).value
    except ParameterException as error:
        line = " ".join(str(error).split())
        raise ConfigurationError(f"{node.get_name()}: parameter {name!r}: {line}") from error


def scenario_parameter(node: Node) -> ResolvedScenario:
    """Return the resolved scenario whose file the parameter ``scenario`` names."""
    path = Path(text_parameter(node, "scenario", "file of the resolved scenario"))
    return ResolvedScenario.from_yaml(read_text(path), str(path))


def tell_scenario(node: Node, resolved: ResolvedScenario) -> Publisher:
    """Publish the resolved scenario, latched, so that a bag of any recorder can be analysed."""
    out = node.create_publisher(String, relative(SCENARIO), LATCHED)
    out.publish(String(data=resolved.to_yaml()))
    return out
