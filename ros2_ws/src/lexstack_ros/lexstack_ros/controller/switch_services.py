"""How a user asks the controller to switch its stack: services, a topic, parameters."""

from __future__ import annotations

from rclpy.node import Node
from std_msgs.msg import String
from std_srvs.srv import Trigger

from lexstack.robots import Team
from lexstack.transition import Answer, Transition
from lexstack_config.scenario import ScenarioConfig
from lexstack_interfaces.msg import StackRequest
from lexstack_interfaces.srv import SwitchStack
from lexstack_ros.controller.transition_parameters import TransitionParameters
from lexstack_ros.messages.conversions import stack_request
from lexstack_ros.messages.qos import LATCHED, SERVICE, STREAM

_THROTTLE = 0.05  # s: a flood of requests is no flood of lines


class Requests:
    """Hands requests to a transition, and what follows from them to the source.

    Attributes:
        transition: whom to ask.
    """

    def __init__(
        self, node: Node, transition: Transition, scenario: ScenarioConfig, team: Team
    ) -> None:
        """Serve requests from now on."""
        self.transition = transition
        self._node = node
        self._team = team
        self._stamp = 0.0
        self._out = node.create_publisher(StackRequest, "/robot_a/stack_request", LATCHED)
        node.create_service(
            SwitchStack, "/robot_a/switch_stack", self._on_switch, qos_profile=SERVICE
        )
        node.create_service(Trigger, "/robot_a/cancel_transition", self._on_cancel)
        node.create_subscription(String, "/robot_a/request_stack", self._on_request, STREAM)
        self._parameters = TransitionParameters(node, scenario.transition, self._on_parameters)

    def restart(self, transition: Transition) -> None:
        """Ask another transition from now on; the source shall forget what the old one asked."""
        self.transition.end()
        self.announce(0.0)
        self.transition = transition
        self._parameters.hand_on()

    def announce(self, stamp: float | None = None) -> None:
        """Tell the source what it shall solve; ``stamp`` is the present time [s]."""
        self._stamp = self._stamp if stamp is None else stamp
        for announcement in self.transition.take_announcements():
            self._out.publish(stack_request(announcement, self._stamp, self._team))

    def _on_switch(
        self, request: SwitchStack.Request, response: SwitchStack.Response
    ) -> SwitchStack.Response:
        """Answer at once: accepted with an id, or refused with the reason."""
        answer = self.transition.ask(
            request.stack, request.duration, request.method, request.at_tick, request.robots
        )
        self._tell(answer)
        response.accepted = answer.accepted
        response.id = 0 if answer.request is None else answer.request.id
        response.message = answer.message
        return response

    def _on_request(self, message: String) -> None:
        """Do as the service, with the values of the configuration."""
        self._tell(self.transition.request(message.data))

    def _on_cancel(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        """Give up the transition and go back."""
        answer = self.transition.cancel()
        self._tell(answer)
        response.success, response.message = answer.accepted, answer.message
        return response

    def _tell(self, answer: Answer) -> None:
        """Tell the source what follows, and the log what was answered; no flood of refusals."""
        self.announce()
        log = self._node.get_logger()
        if answer.accepted:
            log.info(answer.message, throttle_duration_sec=_THROTTLE)
        else:
            log.warning(f"refused: {answer.message}", throttle_duration_sec=1.0)

    def _on_parameters(self, duration: float, method: str) -> None:
        """Take changed parameters."""
        self.transition.set_defaults(duration, method)
