"""Whole runs of a scenario with a player: each node a process of its own, or all in this one.

Both record a bag. In lockstep both give the same bits; together they are up at once and need one
core, apart they can be killed, stopped and looked at as processes.
"""

from __future__ import annotations

import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Protocol

from rclpy.context import Context
from rclpy.experimental import EventsExecutor
from rclpy.node import Node

from lexstack.errors import LexstackError
from lexstack_bringup.player import PLAYER, Player
from lexstack_bringup.processes import HTMPC, RECORDER, bring_up, nodes_of
from lexstack_bringup.supervisor import Supervisor
from lexstack_config.resolved import ResolvedScenario
from lexstack_plant.adapters.mujoco import SimBridge
from lexstack_ros.controller.node import HqpControllerNode
from lexstack_ros.messages.names import SOLVER, base_of
from lexstack_ros.node.calls import wait_until
from lexstack_ros.node.options import NodeOptions
from lexstack_ros.node.readiness import is_connected
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
_LONGEST = 100.0  # s of wall time of a run


class PlayedRun(Protocol):
    """A run that is up.

    Attributes:
        out: its folder, with the bag in ``bag``.
        resolved: its scenario.
        context: of ROS.
        executor: of the player, and of all nodes of this process.
        player: plays the scenario.
    """

    out: Path
    resolved: ResolvedScenario
    context: Context
    executor: EventsExecutor
    player: Player

    def check(self) -> None:
        """Raise LexstackError where a node has ended."""

    def play(self, watch: Callable[[], None] | None = None) -> None:
        """Play the scenario; ``watch`` may act meanwhile."""

    def end(self) -> list[str]:
        """End all nodes; return the processes that had to be killed."""


class ApartRun:
    """Every node a process.

    Attributes:
        supervisor: of the processes.
    """

    def __init__(
        self, resolved: ResolvedScenario, out: Path, supervisor: Supervisor, context: Context
    ) -> None:
        """Bring everything up."""
        self.out = out
        self.supervisor = supervisor
        self.resolved = resolved
        (out / "scenario.yaml").write_text(resolved.to_yaml(), encoding="utf-8")
        self.context = context
        self.executor = EventsExecutor(context=context)
        self.player = Player(resolved, self.executor, context)
        bring_up(supervisor, out / "scenario.yaml", out / "bag", peers=[PLAYER])
        # All know the player then; the player learns of the last of them a little later.
        nodes = nodes_of(resolved.scenario)
        if not wait_until(self.executor, lambda: is_connected(self.player, nodes), _PATIENCE):
            raise LexstackError("the player does not see all nodes")

    def process(self, name: str) -> subprocess.Popen[bytes]:
        """Return a node's process."""
        return next(c for c in self.supervisor.children if c.name == name).process

    def check(self) -> None:
        """Raise ChildDiedError where a process has ended."""
        self.supervisor.check()

    def play(self, watch: Callable[[], None] | None = None) -> None:
        """Play the scenario; ``watch`` may act on the processes meanwhile."""
        self.player.play(watch or self.check, _LONGEST)

    def end(self) -> list[str]:
        """End all processes; return those that had to be killed."""
        return self.supervisor.end()


class TogetherRun:
    """All nodes in this process, on one executor.

    Attributes:
        nodes: by name.
    """

    def __init__(self, resolved: ResolvedScenario, out: Path, context: Context) -> None:
        """Make all nodes, and wait until they are connected."""
        self.out = out
        self.resolved = resolved
        path = out / "scenario.yaml"
        path.write_text(resolved.to_yaml(), encoding="utf-8")
        self.context = context
        self.executor = EventsExecutor(context=context)
        self.player = Player(resolved, self.executor, context)
        self.nodes: dict[str, Node] = {}
        try:
            for name in nodes_of(resolved.scenario):
                self.add(name, **({"output": str(out / "bag")} if name == RECORDER else {}))
            everybody = [self.player, *self.nodes.values()]
            names = [node.get_name() for node in everybody]
            if not wait_until(
                self.executor, lambda: all(is_connected(n, names) for n in everybody), _PATIENCE
            ):
                raise LexstackError("the nodes do not see each other")
        except BaseException:
            self.end()
            raise

    def add(self, name: str, **parameters: Any) -> Node:
        """Make a node of the scenario, and return it."""
        given: dict[str, Any] = {"scenario": str(self.out / "scenario.yaml"), **parameters}
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

    def play(self, watch: Callable[[], None] | None = None) -> None:
        """Play the scenario; ``watch`` may act meanwhile."""
        self.player.play(watch or self.check, _LONGEST)

    def end(self) -> list[str]:
        """End all nodes as ``run_node`` does, the recorder last; no process has to be killed."""
        for name in sorted(self.nodes, key=lambda name: name == RECORDER):
            node = self.nodes.pop(name)
            self.executor.remove_node(node)
            getattr(node, "close", lambda: None)()
            node.destroy_node()
        return []


@contextmanager
def apart(resolved: ResolvedScenario, out: Path) -> Iterator[ApartRun]:
    """Yield a run whose processes are up; leave none behind."""
    with ros_session(children=True) as context:
        supervisor = Supervisor(out / "logs")
        run = None
        try:
            run = ApartRun(resolved, out, supervisor, context)
            yield run
        finally:
            supervisor.end()
            if run is not None:
                run.executor.shutdown()
                run.player.destroy_node()


@contextmanager
def together(resolved: ResolvedScenario, out: Path) -> Iterator[TogetherRun]:
    """Yield a run whose nodes are up in this process; leave none behind."""
    with ros_session(children=False) as context:
        run = TogetherRun(resolved, out, context)
        try:
            yield run
        finally:
            run.end()
            run.executor.shutdown()
            run.player.destroy_node()
