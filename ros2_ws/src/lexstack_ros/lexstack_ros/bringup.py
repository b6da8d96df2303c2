"""The processes of a run: which module each is, and with what parameters."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from lexstack_ros.readiness import READY
from lexstack_ros.supervisor import Supervisor

# In the order in which they start and end: the recorder leaves last. Nobody speaks before all are
# connected, so it misses nothing.
RECORDER = "recorder"
NODES = {
    "sim_bridge": "lexstack_sim.node",
    "hqp_controller": "lexstack_ros.nodes.hqp_controller",
    "stack_solver": "lexstack_ros.nodes.stack_solver",
    RECORDER: "lexstack_ros.nodes.recorder",
}
_READY_TIMEOUT = 60.0  # s of wall time, on a slow machine


def bring_up(
    supervisor: Supervisor, scenario: Path, bag: Path, mode: str, seed: int, users: Sequence[str]
) -> None:
    """Start every process of a run and wait until each may be relied on.

    Args:
        supervisor: starts them.
        scenario: file of the resolved scenario.
        bag: folder of the bag to be written.
        mode: lockstep or realtime.
        seed: of everything random in the plant.
        users: names of nodes that are there already and will use them.

    Raises:
        ChildDiedError: one ended; NotReadyError: one was not ready in time.
    """
    parameters = {
        "sim_bridge": {"mode": mode, "seed": str(seed)},
        RECORDER: {"output": str(bag)},
    }
    for name, module in NODES.items():
        given = {"scenario": str(scenario), **parameters.get(name, {})}
        given["peers"] = ",".join([*(other for other in NODES if other != name), *users])
        pairs = [argument for key, value in given.items() for argument in ("-p", f"{key}:={value}")]
        supervisor.start(name, module, ["--ros-args", *pairs])
    supervisor.wait_printed(tuple(NODES), READY, _READY_TIMEOUT)
