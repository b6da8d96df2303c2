"""The benches: one file each, registered here by the name that the command uses."""

from lexstack_experiments.benches import (
    analysis,
    hqp,
    htmpc,
    htmpc_peers,
    recorder,
    scaling,
    speed,
    strictness,
    system,
    tick,
    transition,
)
from lexstack_experiments.experiment import Experiment

BENCHES: dict[str, Experiment] = {
    "analysis": analysis.EXPERIMENT,
    "hqp": hqp.EXPERIMENT,
    "htmpc": htmpc.EXPERIMENT,
    "htmpc-peers": htmpc_peers.EXPERIMENT,
    "recorder": recorder.EXPERIMENT,
    "scaling": scaling.EXPERIMENT,
    "speed": speed.EXPERIMENT,
    "strictness": strictness.EXPERIMENT,
    "system": system.EXPERIMENT,
    "tick": tick.EXPERIMENT,
    "transition": transition.EXPERIMENT,
}

__all__ = ["BENCHES"]
