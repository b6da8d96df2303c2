"""What one run of a sweep can be, by the names that sweep files use."""

from __future__ import annotations

from lexstack_experiments.sweeps.kinds.experiment import experiment_run
from lexstack_experiments.sweeps.kinds.fault import fault_run
from lexstack_experiments.sweeps.kinds.kind import Kind
from lexstack_experiments.sweeps.kinds.promises import promises_run
from lexstack_experiments.sweeps.kinds.scenario import scenario_run

KINDS: dict[str, Kind] = {
    "promises": promises_run,
    "scenario": scenario_run,
    "experiment": experiment_run,
    "fault": fault_run,
}
"""Each takes the configuration folder, what the file names, and the values of a run."""
