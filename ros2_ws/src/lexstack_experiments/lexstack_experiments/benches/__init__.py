"""The benches: one file each, registered here by the name that the command uses."""

from lexstack_experiments.benches import transition
from lexstack_experiments.experiment import Experiment

BENCHES: dict[str, Experiment] = {
    "transition": transition.EXPERIMENT,
}

__all__ = ["BENCHES"]
