"""What a node of ours is made with where it is not a process of its own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from rclpy.context import Context
from rclpy.parameter import Parameter


@dataclass(frozen=True, slots=True)
class NodeOptions:
    """Where a node lives, and its parameters; by default both come from the command line.

    Attributes:
        context: of ROS; None: the process's own.
        namespace: of the node and of all its topics and services.
        parameters: by name; with them the command line counts for nothing.
        name: in place of the node's own, or ''.
    """

    context: Context | None = None
    namespace: str = ""
    parameters: Mapping[str, Any] = field(default_factory=dict)
    name: str = ""

    def arguments(self, name: str) -> dict[str, Any]:
        """Return the arguments of ``rclpy.node.Node`` for a node that is called ``name``."""
        return {
            "node_name": self.name or name,
            "context": self.context,
            "namespace": self.namespace or None,
            "parameter_overrides": [
                Parameter(key, value=value) for key, value in self.parameters.items()
            ],
            "use_global_arguments": not self.parameters,
        }


FROM_COMMAND_LINE = NodeOptions()
