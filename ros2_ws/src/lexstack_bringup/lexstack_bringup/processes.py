"""The processes of a run: which module each is, and with what parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from lexstack_bringup.naming import Naming
from lexstack_bringup.supervisor import Supervisor
from lexstack_config.resolved import ResolvedScenario
from lexstack_config.scenario import ScenarioConfig
from lexstack_config.yaml_text import read_text
from lexstack_ros.messages.names import SOLVER, base_of
from lexstack_ros.node.readiness import READY

# In the order in which they start and end: the recorder leaves last. Nobody speaks before all are
# connected, so it misses nothing.
RECORDER = "recorder"
BRIDGE = "sim_bridge"
HTMPC = "htmpc"  # runs where a scenario has sequences for it
NODES = {
    BRIDGE: "lexstack_plant.adapters.mujoco",
    "hqp_controller": "lexstack_ros.controller.node",
    "stack_solver": "lexstack_ros.solver.node",
    RECORDER: "lexstack_ros.recorder.node",
}
ADAPTER = "plant_adapter"  # in place of the bridge, where the plant is a user's own
ADAPTERS = {ADAPTER: "lexstack_plant.adapters.ros2_control"}
PLANNERS = {HTMPC: "lexstack_ros.planner.node"}  # in runs with sequences
MODULES = {**PLANNERS, **ADAPTERS, **NODES}
PLAIN = Naming()
_READY_TIMEOUT = 60.0  # s of wall time, on a slow machine


def nodes_of(scenario: ScenarioConfig, *, simulated: bool = True) -> tuple[str, ...]:
    """Return the names of the nodes that a scenario needs, with the bridge or the adapter."""
    more = [f"{SOLVER}_{number}" for number in range(2, scenario.solvers + 1)]
    nodes = (*NODES, *more, *PLANNERS) if scenario.plans else (*NODES, *more)
    return nodes if simulated else tuple(ADAPTER if node == BRIDGE else node for node in nodes)


def arguments_of(node: str, parameters: Mapping[str, str], naming: Naming = PLAIN) -> list[str]:
    """Return the command line of a node; ``parameters`` as YAML."""
    names = naming.rules
    if node != base_of(node):
        names += ["-r", f"__node:={node}"]
    given = numbered(node, parameters)
    pairs = [word for key, value in given.items() for word in ("-p", f"{key}:={value}")]
    return ["--ros-args", *names, *pairs]


def numbered(node: str, parameters: Mapping[str, str]) -> dict[str, str]:
    """Return the parameters of a node, with its number if it is one of several solvers."""
    number = {"number": node.removeprefix(f"{SOLVER}_")} if node != base_of(node) else {}
    return {**parameters, **number}


def executable_of(node: str) -> tuple[str, str]:
    """Return package and executable of a node, as ``ros2 run`` takes them."""
    return MODULES[base_of(node)].partition(".")[0], base_of(node)


def parameters_of(node: str, scenario: Path, bag: Path, nodes: Sequence[str]) -> dict[str, Any]:
    """Return the parameters of a node that is started with ``nodes``, itself one of them."""
    given = {"scenario": str(scenario)}
    if node == RECORDER:
        given["output"] = str(bag)
    given["peers"] = ",".join(other for other in nodes if other != node)
    found: dict[str, Any] = numbered(node, given)
    return found | ({"number": int(found["number"])} if "number" in found else {})


def bring_up(
    supervisor: Supervisor,
    scenario: Path,
    bag: Path,
    peers: Sequence[str],
    *,
    nodes: Sequence[str] | None = None,
    timeout: float = _READY_TIMEOUT,
    more: Mapping[str, Mapping[str, str]] | None = None,
    naming: Naming = PLAIN,
) -> None:
    """Start nodes of a run and wait until each may be relied on.

    Args:
        supervisor: starts them.
        scenario: file of the resolved scenario; mode and seed stand there.
        bag: folder of the bag to be written.
        peers: names of the other nodes of the run: users, and what other hosts start.
        nodes: those to start here, as ``nodes_of`` names them, others are left out; None: all.
        timeout: of wall time until all are connected with each other and with the peers [s].
        more: parameters by node, as YAML, beside those that every run gives. With some for the
            adapter, which needs the file of a plant, it takes the place of the simulation.
        naming: under which names they meet.

    Raises:
        ChildDiedError: one ended; NotReadyError: one was not ready in time.
    """
    extra = more or {}
    if nodes is None:
        resolved = ResolvedScenario.from_yaml(read_text(scenario), str(scenario))
        nodes = nodes_of(resolved.scenario, simulated=ADAPTER not in extra)
    chosen = [name for module in MODULES for name in nodes if base_of(name) == module]
    for name in chosen:
        given = {"scenario": str(scenario), **extra.get(name, {})}
        if name == RECORDER:
            given["output"] = str(bag)
        given["peers"] = ",".join([*(other for other in chosen if other != name), *peers])
        supervisor.start(name, MODULES[base_of(name)], arguments_of(name, given, naming))
    supervisor.wait_printed(chosen, READY, timeout)
