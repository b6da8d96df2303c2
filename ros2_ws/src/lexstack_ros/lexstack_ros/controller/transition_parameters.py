"""The parameters that a user changes while the controller runs."""

from __future__ import annotations

from collections.abc import Callable

from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter

from lexstack.options import unknown
from lexstack.transition import MAX_DURATION, METHODS, TransitionConfig

DURATION = "transition_duration"
METHOD = "transition_method"
LEAD_IN = "lead_in"
_SHORTEST = 0.01  # s


class TransitionParameters:
    """``transition_duration`` [s] and ``transition_method``: what an empty request stands for."""

    def __init__(
        self, node: Node, config: TransitionConfig, apply: Callable[[float, str], None]
    ) -> None:
        """Declare both with the configured values; ``apply`` takes every valid change."""
        self._node = node
        self._apply = apply
        span = FloatingPointRange(from_value=_SHORTEST, to_value=MAX_DURATION, step=0.0)
        node.declare_parameter(
            DURATION,
            config.duration,
            ParameterDescriptor(
                description="time of a blend [s], where a request gives none",
                floating_point_range=[span],
            ),
        )
        node.declare_parameter(
            METHOD,
            config.method,
            ParameterDescriptor(
                description="method of a transition, where a request gives none",
                additional_constraints=f"one of: {', '.join(METHODS)}",
            ),
        )
        node.add_on_set_parameters_callback(self._check)
        node.add_post_set_parameters_callback(lambda _parameters: self.hand_on())

    def _check(self, parameters: list[Parameter]) -> SetParametersResult:
        """Refuse a method that is not known; ROS itself keeps types and ranges."""
        for parameter in parameters:
            if parameter.name == METHOD and parameter.value not in METHODS:
                reason = unknown("method", parameter.value, METHODS)
                return SetParametersResult(successful=False, reason=reason)
        return SetParametersResult(successful=True)

    def hand_on(self) -> None:
        """Apply the present values."""
        duration = float(self._node.get_parameter(DURATION).value)
        self._apply(duration, str(self._node.get_parameter(METHOD).value))


class LeadInParameter:
    """``lead_in`` [s]: the time in which a reference moves to a new target; 0: it steps."""

    def __init__(self, node: Node, configured: float, apply: Callable[[float], None]) -> None:
        """Declare it with the configured value; ``apply`` takes every valid change."""
        self._node = node
        self._apply = apply
        span = FloatingPointRange(from_value=0.0, to_value=MAX_DURATION, step=0.0)
        described = ParameterDescriptor(
            description="time in which a reference moves to a new target [s]; 0: it steps",
            floating_point_range=[span],
        )
        node.declare_parameter(LEAD_IN, configured, described)
        node.add_post_set_parameters_callback(lambda _parameters: self.hand_on())

    def hand_on(self) -> None:
        """Apply the present value."""
        self._apply(float(self._node.get_parameter(LEAD_IN).value))
