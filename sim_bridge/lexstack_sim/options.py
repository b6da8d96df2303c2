"""The bridge's ROS parameters."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self, cast, get_args

from rcl_interfaces.msg import IntegerRange, ParameterDescriptor
from rclpy.node import Node

from lexstack_core.config.scenario import Mode, ScenarioConfig
from lexstack_core.errors import ConfigurationError
from lexstack_ros.parameters import text_parameter

_SEEDS = IntegerRange(from_value=0, to_value=2**31 - 1, step=1)


@dataclass(frozen=True, slots=True)
class BridgeOptions:
    """What a user chooses when the bridge starts, beside the scenario."""

    mode: Mode  # lockstep: waits for every command; realtime: paced by the wall clock
    seed: int  # of everything random in the plant
    start_paused: bool  # wait for the service ~/pause
    exit_at_end: bool  # end the process with the scenario

    @classmethod
    def declare(cls, node: Node, scenario: ScenarioConfig) -> Self:
        """Declare the parameters; mode and seed default to the scenario's.

        Raises:
            ConfigurationError: the mode is unknown.
        """
        mode = text_parameter(node, "mode", " or ".join(get_args(Mode)), scenario.mode)
        if mode not in get_args(Mode):
            known = ", ".join(get_args(Mode))
            raise ConfigurationError(f"sim_bridge: mode: {mode!r} is not one of: {known}")
        about_seed = ParameterDescriptor(
            description="seed of everything random in the plant",
            read_only=True,
            integer_range=[_SEEDS],
        )
        return cls(
            mode=cast("Mode", mode),
            seed=int(node.declare_parameter("seed", scenario.seed, about_seed).value),
            start_paused=_flag(node, "start_paused", "wait for the service ~/pause", default=True),
            exit_at_end=_flag(node, "exit_at_end", "end with the scenario", default=False),
        )


def _flag(node: Node, name: str, description: str, *, default: bool) -> bool:
    """Declare a switch and return it."""
    descriptor = ParameterDescriptor(description=description, read_only=True)
    return bool(node.declare_parameter(name, default, descriptor).value)
