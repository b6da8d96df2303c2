"""Whole runs of a scenario with a player: each node a process of its own, or all in this one.

Both record a bag. In lockstep both give the same bits; together they are up at once and need one
core, apart they can be killed, stopped and looked at as processes.
"""

from __future__ import annotations

import signal
import subprocess
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

from rclpy.context import Context
from rclpy.experimental import EventsExecutor
from rclpy.node import Node

from lexstack.errors import LexstackError
from lexstack_bringup.player import PLAYER, Player
from lexstack_bringup.processes import HTMPC, MODULES, RECORDER, arguments_of, bring_up, nodes_of
from lexstack_bringup.supervisor import Child, Supervisor
from lexstack_config.resolved import ResolvedScenario
from lexstack_plant.adapters.mujoco import SimBridge
from lexstack_ros.controller.node import HqpControllerNode
from lexstack_ros.messages.names import SOLVER, base_of
from lexstack_ros.node.calls import wait_until
from lexstack_ros.node.options import NodeOptions
from lexstack_ros.node.readiness import READY, is_connected
from lexstack_ros.planner.node import HtmpcNode
from lexstack_ros.recorder.node import Recorder
from lexstack_ros.solver.node import StackSolverNode
from lexstack_testing.ros_session import ros_session

KINDS: dict[str, Callable[[NodeOptions], Node]] = {
    "sim_bridge": SimBridge,
    "hqp_controller": HqpControllerNode,
    SOLVER: StackSolverNode,
    HTMPC: HtmpcNode,
    RECORDER: Recorder,
}
_PATIENCE = 30.0  # s of wall time for all to connect
_RESTARTED = 40.0  # s of wall time for one process to be ready again
_LONGEST = 100.0  # s of wall time of a run
_PARTNERS = ("sim_bridge", "hqp_controller", SOLVER)


class PlayedRun(ABC):
    """A run, up as long as ``apart`` or ``together`` yield it.

    Attributes:
        out: its folder, with the bag in ``bag``.
        path: of its scenario, resolved.
        resolved: the scenario.
        context: of ROS.
        executor: of the player, and of all nodes of this process.
        player: plays the scenario.
    """

    def __init__(self, resolved: ResolvedScenario, out: Path, context: Context) -> None:
        """Write the scenario to ``out``, and make the player."""
        self.out, self.resolved, self.context = out, resolved, context
        self.path = out / "scenario.yaml"
        self.path.write_text(resolved.to_yaml(), encoding="utf-8")
        self.executor = EventsExecutor(context=context)
        self.player = self.make_player()

    def make_player(self) -> Player:
        """Return who plays the scenario."""
        return Player(self.resolved, self.executor, self.context)

    @abstractmethod
    def bring_up(self) -> None:
        """Start all nodes, and wait until they are connected."""

    @abstractmethod
    def check(self) -> None:
        """Raise LexstackError where a node has ended."""

    @abstractmethod
    def end(self) -> list[str]:
        """End all nodes; return the processes that had to be killed."""

    def play(self, watch: Callable[[], None] | None = None) -> None:
        """Play the scenario; ``watch`` may act meanwhile."""
        self.player.play(watch or self.check, _LONGEST)

    def _connect(self, nodes: Collection[Node], names: Collection[str]) -> None:
        """Wait until nodes of this process are connected with all that are named."""
        connected = wait_until(
            self.executor, lambda: all(is_connected(node, names) for node in nodes), _PATIENCE
        )
        if not connected:
            raise LexstackError("the nodes do not see each other")


class ApartRun(PlayedRun):
    """Every node a process.

    Attributes:
        supervisor: of the processes.
        bags: folders of the bags so far: a recorder that starts again begins a new one.
    """

    def __init__(self, resolved: ResolvedScenario, out: Path, context: Context) -> None:
        """Start nothing yet."""
        super().__init__(resolved, out, context)
        self.supervisor = Supervisor(out / "logs")
        self.bags = [out / "bag"]

    def bring_up(self) -> None:
        """Start all processes, and wait until they are connected."""
        bring_up(self.supervisor, self.path, self.bags[0], peers=[PLAYER])
        # All know the player then; the player learns of the last of them a little later.
        self._connect([self.player], nodes_of(self.resolved.scenario))

    def check(self) -> None:
        """Raise ChildDiedError where a process has ended."""
        self.supervisor.check()

    def end(self) -> list[str]:
        """End all processes; return those that had to be killed."""
        return self.supervisor.end()

    def child(self, name: str) -> Child:
        """Return the present process of a node."""
        return next(child for child in self.supervisor.children if child.name == name)

    def process(self, name: str) -> subprocess.Popen[bytes]:
        """Return a node's process."""
        return self.child(name).process

    def send(self, name: str, number: signal.Signals) -> int:
        """Send a signal to a node's process; return when [ns since 1970].

        The end of a process that shall end is waited for, and ``check`` does not miss it.
        """
        child = self.child(name)
        child.process.send_signal(number)
        sent = time.time_ns()
        if number in (signal.SIGKILL, signal.SIGINT):
            child.process.wait(10.0)
            self.supervisor.children.remove(child)
        return sent

    def start(self, name: str, module: str = "", **parameters: str) -> int:
        """Start a node again and wait until it is ready; return when it was started [ns].

        Args:
            name: of the node.
            module: to run in place of its own; after a colon its argument.
            parameters: beside the scenario and the peers.
        """
        given = {"scenario": str(self.path), **parameters}
        if name == RECORDER and "output" not in given:
            self.bags.append(self.out / f"bag_{len(self.bags)}")
            given["output"] = str(self.bags[-1])
        # Not all nodes: one that comes back serves as soon as it is connected with these. The
        # recorder, where there is one, shall miss nothing of it.
        there = {child.name for child in self.supervisor.children} & {RECORDER}
        given["peers"] = ",".join(other for other in (*_PARTNERS, *there) if other != name)
        begun = time.time_ns()
        log = self.out / "logs" / f"{name}.log"
        if log.exists():
            log.rename(log.with_suffix(f".{begun}.log"))
        module, _, argument = (module or MODULES[base_of(name)]).partition(":")
        before = [argument] if argument else []
        child = self.supervisor.start(name, module, [*before, *arguments_of(name, given)])
        if not wait_until(self.executor, lambda: child.printed(READY), _RESTARTED, self.check):
            raise LexstackError(f"{name}: not {READY} after {_RESTARTED:g} s")
        return begun


class TogetherRun(PlayedRun):
    """All nodes in this process, on one executor.

    Attributes:
        nodes: by name.
    """

    def __init__(self, resolved: ResolvedScenario, out: Path, context: Context) -> None:
        """Make no node yet."""
        super().__init__(resolved, out, context)
        self.nodes: dict[str, Node] = {}

    def bring_up(self) -> None:
        """Make all nodes, and wait until they are connected."""
        for name in nodes_of(self.resolved.scenario):
            self.add(name, **({"output": str(self.out / "bag")} if name == RECORDER else {}))
        everybody = [self.player, *self.nodes.values()]
        self._connect(everybody, [node.get_name() for node in everybody])

    def add(self, name: str, **parameters: Any) -> Node:
        """Make a node of the scenario, and return it."""
        given: dict[str, Any] = {"scenario": str(self.path), **parameters}
        if name != base_of(name):
            given["number"] = int(name.removeprefix(f"{SOLVER}_"))
        node = KINDS[base_of(name)](NodeOptions(self.context, parameters=given, name=name))
        self.nodes[name] = node
        self.executor.add_node(node)
        return node

    def check(self) -> None:
        """Raise what a node ends its process with."""
        for node in self.nodes.values():
            failure = getattr(node, "failure", None)
            if failure is not None:
                raise failure

    def end(self) -> list[str]:
        """End all nodes as ``run_node`` does, the recorder last; no process has to be killed."""
        for name in sorted(self.nodes, key=lambda name: name == RECORDER):
            node = self.nodes.pop(name)
            self.executor.remove_node(node)
            getattr(node, "close", lambda: None)()
            node.destroy_node()
        return []


R = TypeVar("R", bound=PlayedRun)


@contextmanager
def apart(resolved: ResolvedScenario, out: Path) -> Iterator[ApartRun]:
    """Yield a run whose processes are up; leave none behind."""
    with ros_session(children=True) as context, _up(ApartRun(resolved, out, context)) as run:
        yield run


@contextmanager
def together(resolved: ResolvedScenario, out: Path) -> Iterator[TogetherRun]:
    """Yield a run whose nodes are up in this process; leave none behind."""
    with ros_session(children=False) as context, _up(TogetherRun(resolved, out, context)) as run:
        yield run


@contextmanager
def _up(run: R) -> Iterator[R]:
    """Yield a run that is up, and end it, whatever happens."""
    try:
        run.bring_up()
        yield run
    finally:
        run.end()
        run.executor.shutdown()
        run.player.destroy_node()
