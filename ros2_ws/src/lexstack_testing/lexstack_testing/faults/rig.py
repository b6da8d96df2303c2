"""A running system with a user who may also kill, stop and restart its processes."""

from __future__ import annotations

import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.action import ActionClient
from rclpy.context import Context
from rclpy.experimental import EventsExecutor
from std_srvs.srv import SetBool

from lexstack.errors import LexstackError
from lexstack.mpc import SequenceTask
from lexstack_bringup.processes import MODULES, RECORDER, arguments_of, bring_up, nodes_of
from lexstack_bringup.supervisor import Child, Supervisor
from lexstack_config.resolved import ResolvedScenario
from lexstack_interfaces.action import ExecuteSequence
from lexstack_interfaces.msg import PlantState, TransitionStatus
from lexstack_interfaces.srv import SwitchStack
from lexstack_ros.messages.names import base_of
from lexstack_ros.messages.plans import task_message
from lexstack_ros.messages.qos import SERVICE, STREAM
from lexstack_ros.node.calls import NoAnswerError, answer_of, wait_until
from lexstack_ros.node.readiness import READY
from lexstack_testing.ros_session import ros_session

USER = "rig"
_PATIENCE = 40.0  # s of wall time
_PARTNERS = ("sim_bridge", "hqp_controller", "stack_solver")
_ANSWER = 2.0  # s of wall time, after which a service is called again


class RigError(LexstackError):
    """The system did not do in time what was waited for; the text says what."""


class Rig:
    """All processes of a realtime run, and one node that uses them.

    Attributes:
        bags: folders of the bags so far: a recorder that starts again begins a new one.
        state: the plant's last one.
        transitions: the last one of each set of robots.
        complaints: by node, what it complained of last in /diagnostics.
        heard: all complaints, with time [ns since 1970] and node: a recorder that is away, or has
            no room, does not record what is said of it.
        reasons: all reasons in robot A's transitions, with time [ns since 1970] and source: the
            recorder may find a robot A that starts anew later than its users do.
    """

    def __init__(
        self, resolved: ResolvedScenario, out: Path, supervisor: Supervisor, context: Context
    ) -> None:
        """Bring everything up and release the plant."""
        self.scenario = resolved.scenario
        self.nodes = nodes_of(resolved.scenario)
        self.bags = [out / "bag"]
        self.state: PlantState | None = None
        self.transitions: dict[tuple[str, ...], TransitionStatus] = {}
        self.complaints: dict[str, str] = {}
        self.heard: list[tuple[int, str, str]] = []
        self.reasons: list[tuple[int, str, str]] = []
        self.supervisor = supervisor
        self._out = out
        self._path = out / "scenario.yaml"
        self._path.write_text(resolved.to_yaml(), encoding="utf-8")
        self.executor = EventsExecutor(context=context)
        self.node = rclpy.create_node(USER, context=context)
        self.executor.add_node(self.node)
        self._switch = self.node.create_client(
            SwitchStack, "/robot_a/switch_stack", qos_profile=SERVICE
        )
        self._pause = self.node.create_client(SetBool, "/sim_bridge/pause")
        self._sequences = ActionClient(self.node, ExecuteSequence, "/htmpc/execute_sequence")
        for kind, topic, take in (
            (PlantState, "/plant/state", self._on_state),
            (TransitionStatus, "/robot_a/transition", self._on_transition),
            (DiagnosticArray, "/diagnostics", self._on_diagnostics),
        ):
            self.node.create_subscription(kind, topic, take, STREAM)
        bring_up(supervisor, self._path, self.bags[0], peers=[USER])
        self.release()

    # ---- processes

    def child(self, name: str) -> Child:
        """Return the present process of a node."""
        return next(child for child in self.supervisor.children if child.name == name)

    def send(self, name: str, number: signal.Signals) -> int:
        """Send a signal to a node's process; return when [ns since 1970]."""
        child = self.child(name)
        child.process.send_signal(number)
        sent = time.time_ns()
        if number is signal.SIGKILL:
            child.process.wait()
            self.supervisor.children.remove(child)
        return sent

    def start(self, name: str, module: str = "", **parameters: str) -> int:
        """Start a node anew and wait until it is ready; return when it was started [ns].

        Args:
            name: of the node.
            module: to run in place of its own; after a colon its argument.
            parameters: beside the scenario and the peers.
        """
        given = {"scenario": str(self._path), **parameters}
        if name == RECORDER and "output" not in given:
            self.bags.append(self._out / f"bag_{len(self.bags)}")
            given["output"] = str(self.bags[-1])
        # Not all nodes: one that comes back serves as soon as it is connected with these. The
        # recorder, where there is one, shall miss nothing of it.
        there = {child.name for child in self.supervisor.children} & {RECORDER}
        given["peers"] = ",".join(other for other in (*_PARTNERS, *there) if other != name)
        begun = time.time_ns()
        log = self._out / "logs" / f"{name}.log"
        if log.exists():
            log.rename(log.with_suffix(f".{begun}.log"))
        module, _, argument = (module or MODULES[base_of(name)]).partition(":")
        before = [argument] if argument else []
        child = self.supervisor.start(name, module, [*before, *arguments_of(name, given)])
        self.until(lambda: child.printed(READY), f"{name} to be ready")
        return begun

    # ---- what a user does

    def release(self) -> None:
        """Let simulated time run, if it stands."""

        def moves() -> bool:
            state = self.state
            return state is not None and state.status != PlantState.PAUSED

        self.ask_until(self._pause, SetBool.Request(data=False), moves, "the plant to run")

    def switch(self, stack: str, duration: float) -> SwitchStack.Response:
        """Ask for a stack, again where nobody answers; return the answer."""
        request = SwitchStack.Request(stack=stack, duration=duration)
        return self.call(self._switch, request)

    def switch_async(self, stack: str) -> Any:
        """Ask for a stack and return the future."""
        return self._switch.call_async(SwitchStack.Request(stack=stack, duration=0.2))

    def drive(self, x: float) -> None:
        """Let the HTMPC drive robot A's base to x [m]; asks until robot A follows the plan."""
        task = SequenceTask("drive", "base_position", ((x, 0.0),), speed=0.3, tolerance=0.02)
        robot = self.scenario.sequences["drive"].robot
        goal = ExecuteSequence.Goal(robot=robot, tasks=[task_message(task)])
        end = time.monotonic() + _PATIENCE
        while not self.follows("htmpc"):
            if self._sequences.server_is_ready():
                self._sequences.send_goal_async(goal)
            self.wait(lambda: self.follows("htmpc"), _ANSWER)
            if time.monotonic() > end:
                raise RigError("robot A does not follow the HTMPC")

    def call(self, client: Any, request: Any) -> Any:
        """Return a service's answer; a server that died is seen for a while: ask again."""
        end = time.monotonic() + _PATIENCE
        while time.monotonic() < end:
            self.wait(client.service_is_ready, _ANSWER)
            with suppress(NoAnswerError):
                return answer_of(self.executor, client, request, _ANSWER)
        raise RigError(f"{client.srv_name}: no answer in {_PATIENCE:g} s")

    def ask_until(
        self, client: Any, request: Any, condition: Callable[[], bool], what: str
    ) -> None:
        """Call a service again and again until it has the effect."""
        end = time.monotonic() + _PATIENCE
        while not condition():
            if time.monotonic() > end:
                raise RigError(f"time ran out while waiting for {what}")
            if client.service_is_ready():
                client.call_async(request)
            self.wait(condition, 1.0)

    # ---- where the system stands

    @property
    def all_transitions(self) -> list[TransitionStatus]:
        """What robot A said last, of the last tick."""
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
        """Whether the plant follows robot A."""
        return self.state is not None and self.state.status == PlantState.FOLLOWING

    def forget(self) -> None:
        """Believe only what is heard from now on."""
        self.state = None
        self.transitions.clear()

    # ---- waiting

    def wait(self, condition: Callable[[], bool], seconds: float) -> bool:
        """Return whether the condition came true in time."""
        return wait_until(self.executor, condition, seconds)

    def until(self, condition: Callable[[], bool], what: str) -> None:
        """Wait for a condition; raises RigError."""
        if not self.wait(condition, _PATIENCE):
            raise RigError(f"time ran out while waiting for {what}")

    def close(self) -> None:
        """Leave the graph; the processes have ended."""
        self.executor.shutdown()
        self.node.destroy_node()

    def _on_state(self, message: PlantState) -> None:
        self.state = message

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
    with ros_session(children=True) as context:
        supervisor = Supervisor(out / "logs")
        rig = None
        try:
            rig = Rig(resolved, out, supervisor, context)
            yield rig
        finally:
            supervisor.end()
            if rig is not None:
                rig.close()
