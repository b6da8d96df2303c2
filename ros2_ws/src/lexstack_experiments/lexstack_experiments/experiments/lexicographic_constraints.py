"""H(11) and H(12) with two tolerances on the paper's example: Table I and Fig. 5 of H."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from lexstack.mpc import Constraint, HtmpcConfig
from lexstack_config.resolved import load_htmpc
from lexstack_experiments.experiment import Experiment, Options
from lexstack_experiments.experiments.htmpc_pictures import draw_constraints
from lexstack_experiments.experiments.htmpc_runs import (
    EXAMPLE,
    HALF,
    WITHIN,
    Wave,
    htmpc,
    run_wave,
    setting,
)
from lexstack_experiments.results import Cell, Figure, Goal, Results, Table, zero

NAME = "lexicographic-constraints"
FORMS: dict[Constraint, str] = {"sum": "H(11)", "stage": "H(11) per stage", "axis": "H(12)"}
TOLERANCES = (0.001, 0.01)  # m, low and high
OURS, AUTHORS, SECOND = "lexstack", "authors", "authors, second"
_PAPER = {  # mean and standard deviation of the tool's distance [mm], and within 5 % in part 1, 2
    ("sum", 0.001): "3.24 / 0.56",
    ("sum", 0.01): "6.25 / 2.73, diverges in part 2",
    ("axis", 0.001): "3.07 / 0.73, within 5 %",
    ("axis", 0.01): "3.42 / 1.55, within 5 %",
}
_NOTES = (
    "within 5 %: from when on the base error is, to the end of its part, that near to its optimum.",
    "off: the largest distance from the optimum in the last second; part 1 ends 1 s early, when",
    "the horizon sees the step. Both are normalised by the error that the part begins with.",
)


@dataclass(frozen=True, slots=True)
class Case:
    """One set of weights, one form of the constraint, one tolerance."""

    weights: str
    form: Constraint
    delta: float

    @property
    def text(self) -> str:
        """Say it in words."""
        return f"{self.weights}, {FORMS[self.form]}, {1e3 * self.delta:g} mm"


def cases(weights: dict[str, HtmpcConfig]) -> Iterator[tuple[Case, HtmpcConfig]]:
    """Yield all cases with their parameters, H(12) before H(11)."""
    for form in reversed(list(FORMS)):
        for delta in TOLERANCES:
            for name, config in weights.items():
                bent = config.second_order_correction and form == "axis"
                ee = replace(config.ee, tolerance=delta)
                changed = replace(config, lexicographic=form, second_order_correction=bent, ee=ee)
                yield Case(name, form, delta), changed


def second_version(authors: HtmpcConfig) -> HtmpcConfig:
    """Return the other weights that the authors published: Q 2 for the tool, S .01, R .01 / .1."""
    effort = replace(authors.effort, base_velocity=0.01, arm_velocity=0.01, arm_input=0.01)
    return replace(authors, name=SECOND, ee=replace(authors.ee, stage=2.0), effort=effort)


def run(options: Options) -> Results:
    """Run the cases on the paper's peak, ours as configured first."""
    at = setting(options.config)
    folder = options.config / "htmpc"
    ours, authors = load_htmpc(folder / "lexstack.yaml"), load_htmpc(folder / "authors.yaml")
    weights = {OURS: ours, AUTHORS: authors, SECOND: second_version(authors)}
    waves: dict[Case, Wave] = {}
    as_configured = run_wave(at, htmpc(at.robot, ours), np.array(EXAMPLE))
    for case, config in list(cases(weights))[: options.cases]:
        waves[case] = run_wave(at, htmpc(at.robot, config), np.array(EXAMPLE))
        options.say(f"{case.text}: tool {waves[case].tool.mean():.2f} mm")
    draw_constraints(_curves(waves), HALF, options.out / "fig5.png")
    rows = [_row(case, wave) for case, wave in waves.items()]
    return options.results(
        NAME,
        (*_figures(as_configured), *_authors_figures(waves)),
        Table.of(rows),
        {
            "peak_m": list(EXAMPLE),
            "reach_m": at.reach,
            "optimum_part_1": as_configured.optimum,
            "ours_delta_m": ours.ee.tolerance,
            "ours_constraint": FORMS[ours.lexicographic],
        },
        _NOTES,
    )


def _figures(wave: Wave) -> list[Figure]:
    """Return what our weights are to reach, as they are configured."""
    figures = [
        Figure("Ours: EE error, mean", float(wave.tool.mean()), "mm", Goal("<=", 1.0), "3.42"),
        Figure("Ours: EE error, peak", float(wave.tool.max()), "mm", Goal("<=", 10.0)),
    ]
    for part, off in enumerate(wave.off):
        name = f"Ours: base off its optimum in part {part + 1}, of the initial error"
        figures.append(Figure(name, off, "", Goal("<=", WITHIN), "<= 0.05"))
    return [*figures, zero("Ours: failed solves", float(wave.failures))]


def _authors_figures(waves: dict[Case, Wave]) -> list[Figure]:
    """Return Table I beside what the authors' weights give here; it has no goal."""
    return [
        Figure(f"{case.text}: EE mean", float(wave.tool.mean()), "mm", None, _paper(case))
        for case, wave in waves.items()
        if case.weights != OURS and case.form != "stage"
    ]


def _row(case: Case, wave: Wave) -> dict[str, Cell]:
    """Return the row of one case."""
    return {
        "weights": case.weights,
        "constraint": FORMS[case.form],
        "delta mm": 1e3 * case.delta,
        "EE mm": float(wave.tool.mean()),
        "std mm": float(wave.tool.std()),
        "peak mm": float(wave.tool.max()),
        "paper: EE / std, base": "" if case.weights == OURS else _paper(case),
        "within 5 % in 1, s": wave.settled[0],
        "in 2, s": wave.settled[1],
        "off 1": wave.off[0],
        "off 2": wave.off[1],
        "part 1 s": wave.integrals[0],
        "part 2 s": wave.integrals[1],
        "failed": wave.failures,
    }


def _paper(case: Case) -> str:
    """Return the paper's figures for a form and a tolerance; its H(11) is taken as the sum."""
    return _PAPER.get((case.form, case.delta), "")


def _curves(waves: dict[Case, Wave]) -> dict[str, dict[str, Wave]]:
    """Return the waves by weights, and then by form and tolerance in words."""
    found: dict[str, dict[str, Wave]] = {}
    for case, wave in waves.items():
        name = f"{FORMS[case.form]}, {1e3 * case.delta:g} mm"
        found.setdefault(case.weights, {})[name] = wave
    return found


EXPERIMENT = Experiment(
    "H(11) and H(12) with two tolerances, Table I and Fig. 5 of H", "cases", 18, run
)
