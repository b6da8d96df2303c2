"""A run of one fault: all processes over DDS, in realtime; on a cluster one per machine."""

from __future__ import annotations

import dataclasses
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from lexstack.errors import ConfigurationError, LexstackError
from lexstack.options import shown
from lexstack_experiments.experiment import Options
from lexstack_experiments.experiments.faults import done
from lexstack_experiments.sweeps.kinds.kind import Row
from lexstack_testing.faults.cases import CASES

_OPTIONS = {"seed", "case"}


def fault_run(config: Path, of: str, values: Mapping[str, Any]) -> Row:
    """Do a fault to a running system; ``case`` of the values names it, else the sweep does.

    Raises:
        ConfigurationError: there is no such case.
        LexstackError: its bag cannot be read.
    """
    name = str(values.get("case", of))
    for key in values:
        if key not in _OPTIONS:
            raise ConfigurationError(f"{shown(key)}: a fault has only seed and case")
    if name not in CASES:
        raise ConfigurationError(f"case: unknown {shown(name)}; known: {', '.join(CASES)}")
    with tempfile.TemporaryDirectory() as out:
        options = Options(config, Path(out), int(values["seed"]), 1)
        outcomes, unreadable = done(options, [name])
    if unreadable or not outcomes:
        raise LexstackError(f"{name}: the bag cannot be read: {', '.join(unreadable)}")
    found = dataclasses.asdict(outcomes[0])
    return {key: value for key, value in found.items() if isinstance(value, float | int | str)}
