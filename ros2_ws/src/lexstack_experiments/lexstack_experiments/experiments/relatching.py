"""Random trains of targets, losses and switches in mid-blend: what they cost, and when they end.

Each train is run twice: as it is, and with a solver that is always there and in time. The second
run is what the first one is measured against.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lexstack_config.parts import Parts
from lexstack_experiments.experiment import Experiment, Options
from lexstack_experiments.experiments.relatching_trains import (
    RATE,
    Train,
    last_blending,
    path_lengths,
    random_train,
    run,
    with_single_stacks,
)
from lexstack_experiments.loop import Loop
from lexstack_experiments.results import Cell, Figure, Goal, Results, Table
from lexstack_experiments.runs import scenario_of

NAME = "relatching"
_TICKS = 400  # with events; then nothing more comes
_LITTLE = 0.05  # m, of each base's way: below it a ratio says nothing
_MOST = 1.5  # times the way with a solver that is always there
_ROUNDING = 1e-9
_COLUMNS = ("seed", "mode", "blend s", "targets", "switches", "ticks without B", "way m",
            "way with solver m", "ratio", "over after s", "promised s", "acceleration")  # fmt: skip


@dataclass(frozen=True)
class Outcome:
    """What one train came to.

    Attributes:
        seed: of the train.
        train: the events.
        path_length: of the base with the largest ratio [m].
        perfect: of the same base with a solver that is always there and in time [m].
        ratio: of the two; of the first, ``_LITTLE`` is left out.
        over: from the last event to the end of the last transition [s].
        promised: by when it must be over [s].
        acceleration: largest change of the command in a tick, by what the limits allow.
        failed: ticks at which a solve failed or a velocity limit was exceeded.
    """

    seed: int
    train: Train
    path_length: float
    perfect: float
    ratio: float
    over: float
    promised: float
    acceleration: float
    failed: int

    @property
    def row(self) -> tuple[Cell, ...]:
        """Its row of the table."""
        train = self.train
        events = len(train.targets), len(train.switches), len(train.silent)
        told = (
            self.path_length,
            self.perfect,
            self.ratio,
            self.over,
            self.promised,
            self.acceleration,
        )
        return self.seed, train.mode, train.duration, *events, *told


def run_experiment(options: Options) -> Results:
    """Run the trains, from the seed on."""
    resolved = with_single_stacks(scenario_of(options.config))
    parts = Parts.of(resolved)
    outcomes = []
    for seed in range(options.seed, options.seed + options.cases):
        train = random_train(seed, _TICKS)
        pair = run(train, resolved, parts), run(train, resolved, parts, perfect=True)
        outcomes.append(_outcome(seed, train, *pair))
        if len(outcomes) % 10 == 0:
            options.say(f"{len(outcomes)} of {options.cases} trains")
    late = [each for each in outcomes if each.over > each.promised]
    ratios = [each.ratio for each in outcomes]
    return Results(
        NAME,
        options.seed,
        options.cases,
        (
            Figure("Way of a base, over that with the solver in time, longest", max(ratios), "x",
                   Goal("<=", _MOST)),
            Figure("The same, median", float(np.median(ratios)), "x"),
            Figure("Transitions that are not over in the promised time", len(late), "",
                   Goal("==", 0)),
            Figure("From the last event to the end, longest", max(e.over for e in outcomes), "s"),
            Figure("Peak acceleration / limit", max(e.acceleration for e in outcomes), "",
                   Goal("<=", 1.0, _ROUNDING)),
            Figure("Ticks that failed or left the velocity limits",
                   sum(e.failed for e in outcomes), "", Goal("==", 0)),
        ),
        (Table(_COLUMNS, tuple(each.row for each in outcomes)),),
        {"plant": "exact integrator", "rate_hz": RATE, "ticks_with_events": _TICKS},
        (f"Of each way {_LITTLE:g} m are left out of the ratio, in the run with events.",),
    )  # fmt: skip


def _outcome(seed: int, train: Train, result: Loop, perfect: Loop) -> Outcome:
    """Return what one train came to."""
    went, least = path_lengths(result), path_lengths(perfect)
    ratios = np.maximum(went - _LITTLE, 0.0) / np.maximum(least, _ROUNDING)
    worst = int(ratios.argmax())
    limits = result.parts.team.limits
    chi = np.array([command.chi for command in result.record.commands])
    steps = np.abs(np.diff(chi, axis=0)) / (result.parts.dt * limits.acceleration)
    fast = (np.abs(chi) > (1.0 + _ROUNDING) * limits.velocity).any(axis=1)
    fallen = np.array([bool(command.fallback) for command in result.record.commands])
    return Outcome(
        seed,
        train,
        float(went[worst]),
        float(least[worst]),
        float(ratios[worst]),
        max(last_blending(result) + 1 - train.until, 0) / RATE,
        (train.settled - train.until) / RATE,
        float(steps.max()),
        int(np.count_nonzero(fast | fallen)),
    )


EXPERIMENT = Experiment(
    "random trains of targets, losses and switches in mid-blend",
    "trains",
    120,
    run_experiment,
)
