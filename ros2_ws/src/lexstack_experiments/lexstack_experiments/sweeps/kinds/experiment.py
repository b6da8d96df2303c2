"""A run of an experiment: its figures by their names."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from lexstack.errors import ConfigurationError
from lexstack.options import shown
from lexstack_experiments.experiment import Options
from lexstack_experiments.experiments import EXPERIMENTS
from lexstack_experiments.sweeps.kinds.kind import Row, column

_OPTIONS = {"seed", "cases"}


def experiment_run(config: Path, of: str, values: Mapping[str, Any]) -> Row:
    """Run an experiment with a seed and a number of cases.

    Raises:
        ConfigurationError: there is no such experiment, or it has no such option.
    """
    if of not in EXPERIMENTS:
        raise ConfigurationError(f"of: unknown {shown(of)}; known: {', '.join(EXPERIMENTS)}")
    for key in values:
        if key not in _OPTIONS:
            raise ConfigurationError(f"{shown(key)}: an experiment has only seed and cases")
    experiment = EXPERIMENTS[of]
    with tempfile.TemporaryDirectory() as out:
        cases = min(int(values.get("cases", experiment.cases)), experiment.cases)
        seconds = experiment.seconds
        results = experiment.run(
            Options(config, Path(out), int(values["seed"]), cases, seconds=seconds)
        )
    row: Row = {
        column(figure.name, figure.unit): figure.value
        for figure in results.figures
        if figure.value is not None
    }
    return {**row, "goals_reached": int(results.all_reached)}
