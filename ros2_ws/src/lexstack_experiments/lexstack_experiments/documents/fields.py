"""The fields that documents show, by name: tables and figures, from results and from code."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from lexstack_experiments.documents import (
    benches,
    hardware,
    mobile,
    obstacle,
    peers,
    realism,
    sudden_limits,
    transition_methods,
    transition_sequence,
)
from lexstack_experiments.documents.store import Store
from lexstack_experiments.experiments import EXPERIMENTS

Field = Callable[[], str]

_FROM_RESULTS: dict[str, Callable[[Store], str]] = {
    **benches.FIELDS,
    **hardware.FIELDS,
    **mobile.FIELDS,
    **obstacle.FIELDS,
    **peers.FIELDS,
    **realism.FIELDS,
    **sudden_limits.FIELDS,
    **transition_methods.FIELDS,
    **transition_sequence.FIELDS,
}


def fields_of(store: Store) -> dict[str, Field]:
    """Return every field, worked out when it is called."""
    fields: dict[str, Field] = {name: partial(of, store) for name, of in _FROM_RESULTS.items()}
    for name, experiment in EXPERIMENTS.items():
        fields[f"{name}.cases"] = partial(str, experiment.cases)
    return fields
