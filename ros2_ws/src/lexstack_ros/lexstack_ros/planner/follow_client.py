"""The HTMPC as a user of the controller: asks it to follow plans, and to go back."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from functools import partial

from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.serialization import deserialize_message
from rclpy.task import Future

from lexstack.errors import InputError
from lexstack.robots import Team
from lexstack.tasks import AT_REST, plan_stack
from lexstack_bag.topics import REQUEST
from lexstack_config.resolved import ResolvedScenario
from lexstack_interfaces.msg import StackRequest, TransitionStatus
from lexstack_interfaces.srv import SwitchStack
from lexstack_ros.messages.names import relative
from lexstack_ros.messages.qos import LATCHED, STREAM
from lexstack_ros.planner.goals import Job

_ANSWER = 5.0  # s of wall time to wait for the controller's answer
_LOOK = 0.5  # s of wall time between two looks at that
_AHEAD = 2  # plans between the answer and the tick at which the controller goes back

OnAnswer = Callable[[Job, bool, str], None]
"""Called with the job, whether it was asked to go back, and why it was refused, or ''."""


class FollowClient:
    """Asks the controller by the service that all users have, and hears what became of it."""

    def __init__(
        self, node: Node, team: Team, resolved: ResolvedScenario, on_answer: OnAnswer
    ) -> None:
        """Listen to the controller; ``on_answer`` hears its answers."""
        self._node = node
        self._team = team
        self._known = set(resolved.stacks)
        self._unfit = resolved.unfit
        self._initial = resolved.scenario.initial_stack
        self._blend = resolved.scenario.transition.duration
        self._on_answer = on_answer
        self._requested: dict[Future, tuple[Job, bool, float]] = {}
        # Looked at where a plan or a goal asks: kept as they came. Of two ticks at which they came,
        # and of every robot at most one at a tick.
        self._statuses: deque[bytes] = deque(maxlen=2 * len(team.names))
        self._client = node.create_client(SwitchStack, "robot_a/switch_stack")
        node.create_subscription(
            TransitionStatus, "robot_a/transition", self._hear, STREAM, raw=True
        )
        # Of these the stacks that users sent: the way back may lead to one of them.
        node.create_subscription(StackRequest, relative(REQUEST), self._on_announced, LATCHED)
        wall = Clock(clock_type=ClockType.STEADY_TIME)
        self._timer = node.create_timer(_LOOK, self._on_look, clock=wall)
        self._timer.cancel()  # until an answer is awaited

    @property
    def pending(self) -> bool:
        """Whether an answer of the controller is awaited."""
        return bool(self._requested)

    def stack(self, robot: int) -> str:
        """Return the stack that a robot is on, or goes to; '' before the controller was heard."""
        name = self._team.names[robot]
        for data in reversed(self._statuses):
            try:
                status = deserialize_message(data, TransitionStatus)
            except RuntimeError:  # bytes that are no message
                continue
            if name in status.robots:
                active = status.phase not in (
                    TransitionStatus.REQUESTED,
                    TransitionStatus.PREPARING,
                )
                return str(status.to_stack if active else status.from_stack)
        return ""

    def check(self, robot: str) -> None:
        """Raise InputError where a robot has no stack to follow a plan on."""
        stack = plan_stack(robot)
        if stack not in self._known:
            why = self._unfit.get(stack, "there is no such stack")
            raise InputError(f"robot: {robot} has no stack {stack!r} to follow a plan on: {why}")

    def begin(self, job: Job) -> None:
        """Ask the controller to follow the plan from the job's tick on; note the way back."""
        name = self._team.names[job.robot]
        now = self.stack(job.robot).removesuffix(AT_REST)
        if not job.origin:
            own = now in self._known and now != plan_stack(name)
            job.origin = now if own else self._initial
        self._ask(job, plan_stack(name), job.at_tick, back=False)

    def go_back(self, job: Job, tick: int, every: int) -> None:
        """Ask the controller to go back to its own stack, a few plans after ``tick``."""
        self._ask(job, job.origin, tick + _AHEAD * every, back=True)

    def _ask(self, job: Job, stack: str, at_tick: int, *, back: bool) -> None:
        """Send a request for the job's robot."""
        # The duration is given: plans know until when the controller is still on its way to them.
        request = SwitchStack.Request(
            stack=stack,
            duration=self._blend,
            at_tick=at_tick,
            robots=[self._team.names[job.robot]],
        )
        future = self._client.call_async(request)
        self._requested[future] = job, back, time.monotonic() + _ANSWER
        future.add_done_callback(partial(self._on_done))
        if self._timer.is_canceled():
            self._timer.reset()

    def _on_done(self, future: Future) -> None:
        """Hand an answer on."""
        job, back, _ = self._requested.pop(future, (None, False, 0.0))
        if job is not None:
            answer = future.result()
            self._on_answer(job, back, "" if answer.accepted else answer.message)

    def _on_look(self) -> None:
        """Take an answer that does not come for a refusal."""
        if not self._requested:
            self._timer.cancel()
        for future, (job, back, end) in list(self._requested.items()):
            if time.monotonic() > end:
                del self._requested[future]
                self._client.remove_pending_request(future)
                self._on_answer(job, back, f"the controller did not answer in {_ANSWER:g} s")

    def _hear(self, data: bytes) -> None:
        """Keep a status of the controller's transitions."""
        self._statuses.append(data)

    def _on_announced(self, message: StackRequest) -> None:
        """Note the name of a stack that a user sent."""
        if message.stack_yaml:
            self._known.add(message.stack)
