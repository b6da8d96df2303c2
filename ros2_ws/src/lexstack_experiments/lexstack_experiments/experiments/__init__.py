"""The experiments: one file each, registered here by the name that the command uses."""

from lexstack_experiments.experiment import Experiment
from lexstack_experiments.experiments import (
    computation,
    delivery,
    faults,
    hardware,
    htmpc_computation,
    htmpc_tuning,
    lexicographic_constraints,
    obstacle,
    oracle_gap,
    peers,
    reach,
    reactivity,
    realism,
    relatching,
    robots,
    square_wave,
    sudden_limits,
    transition_methods,
    transition_sequence,
    waypoint_path,
)

EXPERIMENTS: dict[str, Experiment] = {
    "transition-sequence": transition_sequence.EXPERIMENT,
    "sudden-limits": sudden_limits.EXPERIMENT,
    "computation": computation.EXPERIMENT,
    "transition-methods": transition_methods.EXPERIMENT,
    "robots": robots.EXPERIMENT,
    "obstacle": obstacle.EXPERIMENT,
    "realism": realism.EXPERIMENT,
    "lexicographic-constraints": lexicographic_constraints.EXPERIMENT,
    "square-wave": square_wave.EXPERIMENT,
    "waypoint-path": waypoint_path.EXPERIMENT,
    "delivery": delivery.EXPERIMENT,
    "reactivity": reactivity.EXPERIMENT,
    "reach": reach.EXPERIMENT,
    "peers": peers.EXPERIMENT,
    "relatching": relatching.EXPERIMENT,
    "oracle": oracle_gap.EXPERIMENT,
    "faults": faults.EXPERIMENT,
    "hardware": hardware.EXPERIMENT,
    "htmpc-computation": htmpc_computation.EXPERIMENT,
    "tune-htmpc": htmpc_tuning.EXPERIMENT,
}

__all__ = ["EXPERIMENTS"]
