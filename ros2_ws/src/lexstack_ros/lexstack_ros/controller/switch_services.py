"""How a user asks the controller to switch its stack: services, a topic, parameters."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.node import Node
from std_msgs.msg import String
from std_srvs.srv import Trigger

from lexstack.errors import ConfigurationError
from lexstack.robots import Team
from lexstack.tasks import StackConfig
from lexstack.transition import Answer, Transition
from lexstack_config.resolved import ResolvedScenario
from lexstack_config.sent_stacks import SentStacks
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
        self,
        node: Node,
        transition: Transition,
        resolved: ResolvedScenario,
        team: Team,
        on_stack: Callable[[StackConfig], None],
    ) -> None:
        """Serve requests from now on; ``on_stack`` is called with every stack that was sent."""
        self.transition = transition
        self._on_stack = on_stack
        self._node = node
        self._team = team
        self._sent = SentStacks(team, resolved.stacks, resolved.unfit)
        self._stamp = 0.0
        self._out = node.create_publisher(StackRequest, "robot_a/stack_request", LATCHED)
        node.create_service(
            SwitchStack, "robot_a/switch_stack", self._on_switch, qos_profile=SERVICE
        )
        node.create_service(Trigger, "robot_a/cancel_transition", self._on_cancel)
        node.create_subscription(String, "robot_a/request_stack", self._on_request, STREAM)
        self._parameters = TransitionParameters(
            node, resolved.scenario.transition, self._on_parameters
        )

    def restart(self, transition: Transition) -> None:
        """Ask another transition from now on; the source shall forget what the old one asked."""
        self.transition.end()
        self.announce(0.0)
        self.transition = transition
        self._sent.forget()
        self._parameters.hand_on()

    def announce(self, stamp: float | None = None) -> None:
        """Tell the source what it shall solve; ``stamp`` is the present time [s]."""
        self._stamp = self._stamp if stamp is None else stamp
        for announcement in self.transition.take_announcements():
            # With every request: a solver that starts again knows no stack that was sent before.
            text = self._sent.texts.get(announcement.stack, "")
            self._out.publish(stack_request(announcement, self._stamp, self._team, text))

    def _on_switch(
        self, request: SwitchStack.Request, response: SwitchStack.Response
    ) -> SwitchStack.Response:
        """Answer at once: accepted with an id, or refused with the reason."""
        answer = self._ask(request)
        self._tell(answer)
        response.accepted = answer.accepted
        response.id = 0 if answer.request is None else answer.request.id
        response.message = answer.message
        return response

    def _ask(self, request: SwitchStack.Request) -> Answer:
        """Ask for a stack that is known, or for the one that the request brings."""
        how = request.duration, request.method, request.at_tick, request.robots
        if not request.stack_yaml:
            return self.transition.ask(request.stack, *how)
        try:
            config = self._sent.read(request.stack, request.stack_yaml)
            if not self._sent.is_new(config):
                return self.transition.ask(config.name, *how)
            answer = self.transition.ask_new(self._sent.fit(config), *how)
        except ConfigurationError as error:
            return Answer(False, str(error))
        if answer.accepted:
            self._sent.keep(config, request.stack_yaml)
            self._on_stack(config)
        return answer

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
