"""The bridge's ROS parameters. Mode and seed are the scenario's: one truth."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

from rclpy.node import Node

from lexstack_ros.node.parameters import flag_parameter


@dataclass(frozen=True, slots=True)
class BridgeOptions:
    """What a user chooses when the bridge starts, beside the scenario."""

    start_paused: bool  # wait for the service ~/pause
    exit_at_end: bool  # end the process with the scenario

    @classmethod
    def declare(cls, node: Node) -> Self:
        """Declare the parameters, read-only."""
        return cls(
            start_paused=flag_parameter(
                node, "start_paused", "wait for the service ~/pause", default=True
            ),
            exit_at_end=flag_parameter(node, "exit_at_end", "end with the scenario", default=False),
        )
