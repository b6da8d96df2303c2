"""All transition methods on the same cases, one table.

The plant is ideal, q(k+1) = q(k) + dt chi: the methods differ in the command, and the figures are
those of the command. What MuJoCo adds is in the experiment transition-sequence.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import astuple

from lexstack_experiments.experiment import Experiment, Options
from lexstack_experiments.experiments.method_cases import Case, cases
from lexstack_experiments.experiments.method_pictures import draw
from lexstack_experiments.experiments.method_runs import MethodFigures, Play, Rows
from lexstack_experiments.methods import METHODS
from lexstack_experiments.results import AT_MOST_ONE, Figure, Goal, Peer, Results, Table
from lexstack_experiments.runs import never_switched

NAME = "transition-methods"
OURS = next(iter(METHODS))
FAMILY = (OURS, "bridge_jerk")  # one method; the second keeps jerk limits as well
CASES = 10
STILL = "no switch"
# These never look at the solver's chi: they solve all levels of the new stack, or of both,
# themselves.
_ALONE = frozenset({"instant_limited", "activation", "weights"})
_TIE = 1.05  # times the best figure that still counts as tied with it
_NO_EXCESS = 1e-6  # m/s and rad/s

_COLUMNS = (
    "row", "method", "base m/s2", "arm rad/s2", "acc. ratio", "jerk ratio", "EE rms mm",
    "EE peak mm", "excess", "excess, steps", "empty", "settled s", "QPs", "us p50", "us p99",
)  # fmt: skip

_NOTES = (
    "Peaks of the command from a switch until 0.5 s after its blend; ratios to the joints' limits.",
    f"{STILL}: what the motion of the references asks for by itself; it competes with nobody.",
    "EE: distance of the tools from the same case without any switch.",
    "excess: level 1's residual beyond bounded least squares in the same box while level 1 goes on",
    "as it was; 'steps': over the blend of (C), at which its references jump.",
    "QPs: levels that the controller solves per tick of a blend; us: wall time of such a tick.",
)


def run(options: Options) -> Results:
    """Run all methods on the first cases and compare."""
    chosen = cases(options.config, options.seed)[: options.cases]
    rows: Rows = {}
    for number, case in enumerate(chosen, start=1):
        rows |= _play(case, lambda line, n=number: options.say(f"case {n}, {line}"))
    draw(rows, STILL, options.out / "methods.png")
    scenario = chosen[0].resolved.scenario
    return options.results(
        NAME,
        _figures(rows),
        (
            Table(_COLUMNS, _table(rows)),
            _pivot(rows, "acceleration", "peak acceleration / limit"),
            _pivot(rows, "jerk", "peak jerk / limit"),
        ),
        {
            "plant": "ideal",
            "rate_hz": scenario.rate,
            "transition_s": scenario.transition.duration,
            "profile": scenario.transition.profile,
            "tie": _TIE,
            "no_excess": _NO_EXCESS,
            "cases": [case.about for case in chosen],
        },
        (*_NOTES, *_short(rows)),
    )


def _play(case: Case, say: Callable[[str], None]) -> Rows:
    """Return the figures of a case's rows under every method."""
    still = Play(never_switched(case), OURS)
    rows: Rows = {row.name: {STILL: still.figures(row, still)} for row in case.rows}
    for method in METHODS:
        play = Play(case, method)
        for row in case.rows:
            rows[row.name][method] = play.figures(row, still)
        say(f"{case.about}: {method}")
    return rows


def _figures(rows: Rows) -> list[Figure]:
    """Return in how many rows ours is best or tied and has no excess, and the sums behind it."""
    everyone, followers = list(METHODS), [name for name in METHODS if name not in _ALONE]
    strict = {name: methods[OURS].excess <= _NO_EXCESS for name, methods in rows.items()}

    def count(*figures: str, among: list[str]) -> int:
        return sum(
            all(_best(methods, figure, among) for figure in figures) for methods in rows.values()
        )

    smooth = ("acceleration", "jerk")
    every = Goal("==", len(rows))
    title = "Rows in which ours is best or tied in smoothness, without excess"
    return [
        Figure(title, len(rows) - len(_missed(rows)), "", every),
        Figure("The same of the default alone", len(rows) - len(_missed(rows, (OURS,)))),
        Figure("Rows best or tied in peak acceleration", count(smooth[0], among=everyone)),
        Figure("Rows best or tied in peak jerk", count(smooth[1], among=everyone)),
        Figure(
            "Rows best or tied in both, of those who let the solver solve",
            count(*smooth, among=followers),
        ),
        Figure("Rows without excess of level 1", sum(strict.values()), "", every),
        _worst("Largest acceleration / limit", rows, "acceleration", AT_MOST_ONE),
        _worst("Ticks with an empty box", rows, "empty", Goal("==", 0.0)),
    ]


def _least(
    methods: dict[str, MethodFigures], figure: str, among: Collection[str]
) -> tuple[float, str]:
    """Return the smallest figure of some methods, strict or not, and whose it is."""
    return min((getattr(methods[name], figure), name) for name in among)


def _best(
    methods: dict[str, MethodFigures], figure: str, among: Collection[str], ours: str = OURS
) -> bool:
    """Return whether ours is best or tied in a figure among some methods."""
    return bool(getattr(methods[ours], figure) <= _TIE * _least(methods, figure, among)[0])


def _missed(rows: Rows, family: Collection[str] = FAMILY) -> list[str]:
    """Return the rows in which none of ours is best or tied in both figures, without excess."""
    return [
        name
        for name, methods in rows.items()
        if not any(
            methods[ours].excess <= _NO_EXCESS
            and all(_best(methods, figure, METHODS, ours) for figure in ("acceleration", "jerk"))
            for ours in family
            if ours in methods
        )
    ]


def _short(rows: Rows) -> list[str]:
    """Return a sentence for each row and figure in which ours falls short."""
    told = []
    for name in _missed(rows):
        methods = rows[name]
        ours = methods[OURS]
        for figure in ("acceleration", "jerk"):
            value, best = _least(methods, figure, METHODS)
            if not _best(methods, figure, METHODS):
                mine = getattr(ours, figure)
                told.append(f"{name}: peak {figure} {mine:.3g}, with {best} {value:.3g}.")
        if ours.excess > _NO_EXCESS:
            told.append(f"{name}: excess of level 1 {ours.excess:.2g}.")
    return told


def _worst(title: str, rows: Rows, figure: str, goal: Goal) -> Figure:
    """Return ours at its worst, beside the strong baseline at its worst."""
    ours, theirs = (
        max(float(getattr(methods[name], figure)) for methods in rows.values())
        for name in (OURS, "instant_limited")
    )
    return Figure(title, ours, "", goal, peer=Peer("instant_limited", theirs))


def _pivot(rows: Rows, figure: str, title: str) -> Table:
    """Return one figure as a table with a column for each method."""
    lines = tuple(
        (name, *(getattr(methods[method], figure) for method in (STILL, *METHODS)))
        for name, methods in rows.items()
    )
    return Table(("row", STILL, *METHODS), lines, title)


def _table(rows: Rows) -> list[tuple]:
    """Return a line for each row and method."""
    return [
        (name, method, *astuple(figures))
        for name, methods in rows.items()
        for method, figures in methods.items()
    ]


EXPERIMENT = Experiment("all transition methods on the same cases", "cases", CASES, run)
