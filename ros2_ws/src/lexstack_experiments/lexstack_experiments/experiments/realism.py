"""The task sequence on plants that are not as their model says: one flaw at a time, then all.

MuJoCo with the impedance loop. The flaws are those of scenario ``realism``; measured poses, which
are themselves late, coarse and noisy where the scenario says so.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from lexstack_bag.figures.figures import Analysis
from lexstack_config.plant import PlantConfig
from lexstack_config.resolved import ResolvedScenario
from lexstack_experiments.experiment import Experiment, Options
from lexstack_experiments.loop import Loop
from lexstack_experiments.measuring import largest
from lexstack_experiments.results import AT_MOST_ONE, Figure, Results, Table, zero
from lexstack_experiments.runs import analysed, changed, run_reporting, scenario_of
from lexstack_sim.plant import Plant

NAME = "realism"
_PLANTS = (
    "none", "encoder_step", "velocity_noise", "latency", "payload", "friction", "base_slip",
    "pushes", "all",
)  # fmt: skip
_LENGTHS = ("EE after (A) mm", "base after (A) mm", "final EE mm", "peak EE mm")


def run(options: Options) -> Results:
    """Run the sequence on every plant and state how well it does."""
    whole = scenario_of(options.config, NAME)
    order = [_PLANTS[-1], *_PLANTS[:-1]]  # the one that counts first, if not all are to run
    loops = {
        flaw: run_reporting(Loop(_with(whole, flaw, options)), flaw, options.say)
        for flaw in order[: options.cases]
    }
    measured = {flaw: analysed(loop) for flaw, loop in loops.items()}
    worst = max(m.metrics.peak_acceleration_ratio or 0.0 for m in measured.values())
    empty = sum(m.metrics.empty_bounds for m in measured.values())
    missed = sum(
        phase.transition_s is None for m in measured.values() for phase in m.metrics.phases[1:]
    )
    rows = {flaw: _row(flaw, measured[flaw], loops[flaw]) for flaw in _PLANTS if flaw in measured}
    everything = rows["all"]
    return options.results(
        NAME,
        (
            Figure("Peak acceleration of the command / limit", worst, "", AT_MOST_ONE),
            zero("Ticks with an empty box of bounds", empty),
            zero("Switches not adopted", missed),
            *(
                Figure(f"All flaws: {name.removesuffix(' mm')}", everything[name], "mm")
                for name in _LENGTHS
            ),
        ),
        Table.of(rows.values()),
        {"plant": "MuJoCo, joint impedance loop at 1 kHz", "rate_hz": whole.scenario.rate},
        ("settled: switches after which all errors stay in their band, of 3.",),
    )


def _with(whole: ResolvedScenario, flaw: str, options: Options) -> ResolvedScenario:
    """Return the scenario with one flaw of its plant, with all or with none."""
    plant = whole.scenario.plant
    if flaw != "all":
        one = {} if flaw == "none" else {flaw: getattr(plant, flaw)}
        plant = replace(PlantConfig(), **one)
    return changed(whole, plant=plant, seed=options.seed)


def _row(flaw: str, measured: Analysis, loop: Loop) -> dict[str, Any]:
    """Return the figures of one plant."""
    metrics = measured.metrics
    first, last = metrics.phases[1], metrics.phases[-1]
    touched = loop.plant.counters.contact if isinstance(loop.plant, Plant) else None
    errors = (first.ee_error_mm, first.base_error_mm, last.ee_error_mm, first.ee_peak_error_mm)
    return {
        "flaw": flaw,
        **{
            name: largest((error or {}).values())
            for name, error in zip(_LENGTHS, errors, strict=True)
        },
        "settled": sum(phase.settled_s is not None for phase in metrics.phases[1:]),
        "acc. ratio": metrics.peak_acceleration_ratio,
        "empty boxes": metrics.empty_bounds,
        "robots touch, ticks": touched,
    }


EXPERIMENT = Experiment(
    "the task sequence with noise, latency, payload, friction, slip and a push",
    "plants",
    len(_PLANTS),
    run,
)
"""Registered under its name."""
