"""Random trains of the experiment ``relatching`` with the robots of these tests."""

from __future__ import annotations

from lexstack_experiments.experiments import relatching_trains
from lexstack_experiments.experiments.relatching_trains import (
    Train,
    path_lengths,
    random_train,
    still_blending,
)
from lexstack_experiments.loop import Loop
from support.channels import parts, with_single_stacks

__all__ = ["Train", "path_lengths", "random_train", "run", "still_blending"]


def run(train: Train, *, perfect: bool = False) -> Loop:
    """Return the closed loop after a train; ``perfect``: with a solver that is in time."""
    return relatching_trains.run(train, with_single_stacks(), parts(), perfect=perfect)
