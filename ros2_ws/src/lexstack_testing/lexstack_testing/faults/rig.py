"""A user of a running system, who asks until it serves again, and notes what it complains of."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.action import ActionClient
from std_srvs.srv import SetBool

from lexstack.mpc import SequenceTask
from lexstack_config.resolved import ResolvedScenario
from lexstack_interfaces.action import ExecuteSequence
from lexstack_interfaces.msg import PlantState, TransitionStatus
from lexstack_interfaces.srv import SwitchStack
from lexstack_ros.messages.plans import task_message
from lexstack_ros.messages.qos import SERVICE, STREAM
from lexstack_testing.played_run import ApartRun, apart
from lexstack_testing.user import Bystander, InVainError

_ANSWER = 2.0  # s of wall time, after which a service is called again


class Rig(Bystander):
    """A realtime run of processes that may be killed, stopped and restarted, and its user.

    Attributes:
        transitions: the last one of each set of robots.
        complaints: by node, what it complained of last in /diagnostics.
        heard: all complaints, with time [ns since 1970] and node: a recorder that is away, or has
            no room, does not record what is said of it.
        reasons: all reasons in transitions, with time [ns since 1970] and source: the
            recorder may find a controller that starts anew later than its users do.
    """

    run: ApartRun
    patience = 40.0  # s of wall time: what was killed may have to start again

    def __init__(self, run: ApartRun) -> None:
        """Use a run by its player's node, and release the plant."""
        super().__init__(run, run.player)
        self.scenario = run.resolved.scenario
        self.transitions: dict[tuple[str, ...], TransitionStatus] = {}
        self.complaints: dict[str, str] = {}
        self.heard: list[tuple[int, str, str]] = []
        self.reasons: list[tuple[int, str, str]] = []
        self._switch = self.node.create_client(
            SwitchStack, "/robot_a/switch_stack", qos_profile=SERVICE
        )
        self._pause = self.node.create_client(SetBool, "/sim_bridge/pause")
        self._sequences = ActionClient(self.node, ExecuteSequence, "/htmpc/execute_sequence")
        for kind, topic, take in (
            (TransitionStatus, "/robot_a/transition", self._on_transition),
            (DiagnosticArray, "/diagnostics", self._on_diagnostics),
        ):
            self.node.create_subscription(kind, topic, take, STREAM)
        self.release()

    # ---- what a user does

    def release(self) -> None:
        """Let simulated time run, if it stands."""

        def moves() -> bool:
            return self.state is not None and self.state.status != PlantState.PAUSED

        self._ask_until(
            moves,
            "the plant to run",
            self._pause.service_is_ready,
            lambda: self._pause.call_async(SetBool.Request(data=False)),
        )

    def switch(self, stack: str, duration: float) -> SwitchStack.Response:
        """Ask for a stack, again where nobody answers; return the answer."""
        asked: list[Any] = []
        self._ask_until(
            lambda: any(future.done() for future in asked),
            f"{self._switch.srv_name} to answer",
            self._switch.service_is_ready,
            lambda: asked.append(self.switch_async(stack, duration)),
        )
        return next(future.result() for future in asked if future.done())

    def switch_async(self, stack: str, duration: float) -> Any:
        """Ask for a stack and return the future."""
        return self._switch.call_async(SwitchStack.Request(stack=stack, duration=duration))

    def drive(self, x: float) -> None:
        """Let the HTMPC drive robot_a's base to x [m]; asks until its plan is followed."""
        task = SequenceTask("drive", "base_position", ((x, 0.0),), speed=0.3, tolerance=0.02)
        robot = self.scenario.sequences["drive"].robot
        goal = ExecuteSequence.Goal(robot=robot, tasks=[task_message(task)])
        self._ask_until(
            lambda: self.follows("htmpc"),
            "the controller to follow the HTMPC",
            self._sequences.server_is_ready,
            lambda: self._sequences.send_goal_async(goal),
        )

    def _ask_until(
        self,
        condition: Callable[[], bool],
        what: str,
        served: Callable[[], bool],
        ask: Callable[[], Any],
    ) -> None:
        """Ask whenever somebody serves until it has the effect: a server that died is seen on."""
        end = time.monotonic() + self.patience
        while not condition():
            if time.monotonic() > end:
                raise InVainError(f"waited in vain for {what}{self.place()}")
            if self.wait(served, _ANSWER):
                ask()
                self.wait(condition, _ANSWER)

    # ---- where the system stands

    @property
    def state(self) -> PlantState | None:
        """The plant's last one."""
        return self.run.player.state

    @property
    def all_transitions(self) -> list[TransitionStatus]:
        """What the controller said last, of the last tick."""
        last = max((each.tick for each in self.transitions.values()), default=0)
        return [each for each in self.transitions.values() if each.tick == last]

    def follows(self, source: str) -> bool:
        """Return whether A follows this source in a blend."""
        return any(
            each.phase == TransitionStatus.BLENDING and each.source == source
            for each in self.all_transitions
        )

    def is_on(self, stack: str) -> bool:
        """Return whether all robots are on a stack and stay there."""
        told = self.all_transitions
        stay = self.scenario.transition.at_end == "stay"
        return bool(told) and all(
            each.to_stack == stack
            and (
                each.phase == TransitionStatus.IDLE
                or (stay and each.phase == TransitionStatus.BLENDING and each.alpha >= 1.0)
            )
            for each in told
        )

    @property
    def commanded(self) -> bool:
        """Whether the plant follows the controller."""
        return self.state is not None and self.state.status == PlantState.FOLLOWING

    def forget(self) -> None:
        """Believe only what is heard from now on."""
        self.run.player.state = None
        self.transitions.clear()

    def place(self) -> str:
        """Return what the controller said last, in words."""
        return f"; the last transitions: {self.all_transitions}"

    def _on_transition(self, message: TransitionStatus) -> None:
        if any(message.tick < each.tick for each in self.transitions.values()):
            self.transitions.clear()  # the plant began anew
        self.transitions[tuple(message.robots)] = message
        if message.reason and (not self.reasons or message.reason != self.reasons[-1][-1]):
            self.reasons.append((time.time_ns(), message.source, message.reason))

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            text = "" if status.message == "ok" else status.message
            if text != self.complaints.get(status.name, ""):
                self.heard.append((time.time_ns(), status.name, text))
            self.complaints[status.name] = text


@contextmanager
def running(resolved: ResolvedScenario, out: Path) -> Iterator[Rig]:
    """Yield a rig whose processes are up, on a domain of its own; leave none behind."""
    with apart(resolved, out) as run:
        yield Rig(run)
