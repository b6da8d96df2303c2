"""Limits that change at once and exclude where the joints are, T Fig. 1.

The controller's law beside the boxes that T prints, T(31) and T(34), and beside the least time that
the limits allow, which is worked out apart from the law.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import astuple

from lexstack_experiments.experiment import Experiment, Options
from lexstack_experiments.experiments.sudden_limits_cases import NAME, Case, cases, laws
from lexstack_experiments.experiments.sudden_limits_pictures import draw
from lexstack_experiments.experiments.sudden_limits_runs import LimitFigures, Play
from lexstack_experiments.results import AT_MOST_ONE, Figure, Goal, Peer, Results, Table, zero
from lexstack_experiments.runs import never_switched

OURS = "ours"
CASES = 6

_COLUMNS = (
    "case", "law", "empty", "acc. ratio", "jerk ratio", "vel. ratio", "outside s", "least s",
    "late ticks", "violation mrad", "EE away mm",
)  # fmt: skip

_NOTES = (
    "empty: ticks with an empty box. Ratios: peak of the command over the limits in force.",
    "outside: from the trigger until all joints are inside the new limits for good; least: what no",
    "motion within the limits falls below; late: by how much a joint is later than it must be, the",
    "worst joint. violation: how far a joint is outside later than it must be.",
    "EE away: distance of a tool from the same run without the switch, until the case ends.",
    "T(31), T(34) with an empty interval: the joint brakes, or the position limit gives way.",
)

Rows = dict[str, dict[str, LimitFigures]]


def run(options: Options) -> Results:
    """Run the first cases under every law and compare."""
    rows: Rows = {}
    for number, case in enumerate(cases(options.config, options.seed)[: options.cases], start=1):
        plays = _play(case, lambda line, n=number: options.say(f"case {n}, {line}"))
        still = Play(never_switched(case), laws(case)[0])
        rows[case.name] = {name: play.figures(still) for name, play in plays.items()}
        if number == 1:
            draw(plays, options.out / "fig1.png")
            options.say("drew fig1.png")
    scenario = cases(options.config, options.seed)[0].resolved.scenario
    return options.results(
        NAME,
        _figures(rows),
        Table(_COLUMNS, _table(rows)),
        {
            "plant": "ideal; MuJoCo where the case says so",
            "rate_hz": scenario.rate,
            "method": scenario.transition.method,
            "transition_s": scenario.transition.duration,
        },
        _NOTES,
    )


def _play(case: Case, say: Callable[[str], None]) -> dict[str, Play]:
    """Return a case under every law."""
    plays = {}
    for law in laws(case):
        plays[law.name] = Play(case, law)
        say(f"{case.name}: {law.name}")
    return plays


def _figures(rows: Rows) -> list[Figure]:
    """Return what is to be reached, at the worst of all cases."""
    ours = [laws[OURS] for laws in rows.values()]
    soft = [laws[OURS].jerk for name, laws in rows.items() if len(laws) == 1]
    printed = {
        title: [laws[name] for laws in rows.values() for name in laws if name.startswith(title)]
        for title in ("T(31)", "T(34)")
    }
    empty = [Peer(name, min(f.empty for f in found)) for name, found in printed.items() if found]
    late = [figures.late for figures in ours]
    title = "Ticks with an empty box"
    within = "Jerk / limit where jerk is limited"
    return [
        Figure(
            title, max(f.empty for f in ours), "", Goal("==", 0.0), "infeasible without", empty[0]
        ),
        *(Figure(f"{title}, beside {peer.name}", None, peer=peer) for peer in empty[1:]),
        Figure("Peak acceleration / limit", max(f.acceleration for f in ours), "", AT_MOST_ONE),
        Figure(within, max(soft) if soft else None, "", AT_MOST_ONE),
        zero("Ticks later inside than the limits allow", _most(late)),
        zero("Outside later than need be", 1e3 * max(f.violation for f in ours), "mrad"),
    ]


def _most(values: list[int | None]) -> int | None:
    """Return the largest, None where one is missing."""
    return None if None in values else max(value for value in values if value is not None)


def _table(rows: Rows) -> list[tuple]:
    """Return a line for each case and law."""
    return [
        (case, law, *astuple(figures)[:-2], 1e3 * figures.violation, figures.away)
        for case, laws in rows.items()
        for law, figures in laws.items()
    ]


EXPERIMENT = Experiment(
    "new limits exclude the present configuration, T Fig. 1", "cases", CASES, run
)
