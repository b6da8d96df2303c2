"""The paper's task sequence, T Figs. 5 to 8, in the MuJoCo plant with its impedance loop.

Measured poses, one process, the same library code as in the nodes. Beside the bridge runs the
strong baseline: the new stack at once, within the same acceleration limits.
"""

from __future__ import annotations

from lexstack.transition import METHODS
from lexstack_bag.figures.figures import Analysis, PhaseMetrics
from lexstack_bag.figures.goals import goals_of
from lexstack_config.resolved import ResolvedScenario
from lexstack_experiments.experiment import Experiment, Options
from lexstack_experiments.experiments.sequence_pictures import draw
from lexstack_experiments.loop import Loop
from lexstack_experiments.measuring import largest
from lexstack_experiments.results import Cell, Figure, Goal, Peer, Results, Table
from lexstack_experiments.runs import analysed, changed, run_reporting, scenario_of, with_method

NAME = "transition-sequence"
BASELINE = "instant_limited"
SWITCHES = ("A", "B", "C")
_SLOWER = 1.2  # times the baseline's time that a switch may take to settle
_ROUNDING = 1e-6  # of a ratio that meets its limit exactly


def run(options: Options) -> Results:
    """Run the sequence with the default method and with the baseline, and compare."""
    resolved = sequence(options)
    method = resolved.scenario.transition.method
    loop = run_reporting(Loop(resolved), method, options.say)
    baseline = run_reporting(Loop(with_method(resolved, BASELINE)), BASELINE, options.say)
    ours, theirs = analysed(loop), analysed(baseline)
    draw(loop, ours, options.out)
    options.say(f"drew {options.cases + 1} pictures")
    return options.results(
        NAME,
        (*_paper_figures(ours, theirs), *_settling_figures(ours, theirs), *_plain(ours, theirs)),
        Table.of(_rows(ours, theirs)),
        {
            "plant": "MuJoCo, joint impedance loop at 1 kHz",
            "rate_hz": resolved.scenario.rate,
            "method": method,
            "transition_s": resolved.scenario.transition.duration,
            "baseline": BASELINE,
        },
    )


def sequence(options: Options) -> ResolvedScenario:
    """Return the scenario up to the end of the last switch that is asked for."""
    resolved = scenario_of(options.config, NAME)
    events = resolved.scenario.events
    ends = [*(event.at for event in events[1:]), resolved.scenario.duration]
    last = options.cases - 1
    shorter = changed(resolved, events=events[: last + 1], duration=ends[last], seed=options.seed)
    return with_method(shorter, next(iter(METHODS)))


def _paper_figures(ours: Analysis, theirs: Analysis) -> list[Figure]:
    """Return the figures that the report shows as well; the last switch may be left out."""
    whole = len(ours.phases) == len(SWITCHES) + 1
    figures = []
    for goal, other in zip(goals_of(ours.metrics), goals_of(theirs.metrics), strict=True):
        shown = whole or not goal.quantity.startswith("Final")
        limit = Goal("<=" if goal.limit else "==", goal.limit, _ROUNDING if goal.limit else 0.0)
        peer = Peer(BASELINE, other.value) if shown and other.value is not None else None
        value = goal.value if shown else None
        paper = goal.paper if goal.paper != "–" else ""
        figures.append(Figure(goal.quantity, value, goal.unit, limit, paper, peer))
    return figures


def _settling_figures(ours: Analysis, theirs: Analysis) -> list[Figure]:
    """Return for each switch how much longer than the baseline it takes to settle."""
    figures = []
    for i, name in enumerate(SWITCHES):
        mine, other = (_settled(measured, i + 1) for measured in (ours, theirs))
        title = f"Switch ({name}) to settled, against {BASELINE}"
        figures.append(Figure(title, _ratio(mine, other), "x", Goal("<=", _SLOWER)))
    return figures


def _ratio(mine: float | None, other: float | None) -> float | None:
    """Return a time over another one, None where one is missing."""
    return mine / other if mine is not None and other else None


def _plain(ours: Analysis, theirs: Analysis) -> list[Figure]:
    """Return what has no goal of its own."""
    title = "Peak jerk of the command / limit"
    jerk, other = ours.metrics.peak_jerk_ratio, theirs.metrics.peak_jerk_ratio
    return [Figure(title, jerk, peer=Peer(BASELINE, other))]


def _rows(ours: Analysis, theirs: Analysis) -> list[dict[str, Cell]]:
    """Return a row for each switch."""
    pairs = list(zip(ours.metrics.phases, theirs.metrics.phases, strict=True))[1:]
    return [
        {
            "switch": f"({name})",
            "to": mine.stack,
            "start s": mine.start_s,
            "settled s": mine.settled_s,
            "baseline s": other.settled_s,
            "ratio": _ratio(mine.settled_s, other.settled_s),
            "EE mm": largest(mine.ee_error_mm.values()),
            "base mm": largest((mine.base_error_mm or {}).values()),
            "acc. ratio": mine.peak_acceleration_ratio,
            "baseline acc.": other.peak_acceleration_ratio,
        }
        for name, (mine, other) in zip(SWITCHES, pairs, strict=False)
    ]


def _settled(measured: Analysis, phase: int) -> float | None:
    """Return when a phase has settled [s], None where it has not or is not there."""
    phases: tuple[PhaseMetrics, ...] = measured.metrics.phases
    return phases[phase].settled_s if phase < len(phases) else None


EXPERIMENT = Experiment(
    "the paper's task sequence in MuJoCo, T Figs. 5 to 8", "switches", len(SWITCHES), run
)
