"""Faults of a running system: every process killed and stopped in every phase, a cut network, ...

Realtime runs of all processes over DDS. What is done to them is in ``lexstack_testing.faults``;
here the runs are started, and what their bags say is held against the limits.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from lexstack.errors import LexstackError
from lexstack_config.parts import build_team
from lexstack_config.resolved import ResolvedScenario
from lexstack_experiments.experiment import Experiment, Options
from lexstack_experiments.experiments.fault_checks import Outcome, outcome
from lexstack_experiments.experiments.fault_cuts import CUTS, cut_events, why_no_cut
from lexstack_experiments.experiments.fault_records import Statement, read_record
from lexstack_experiments.measuring import largest
from lexstack_experiments.results import AT_MOST_ONE, Cell, Figure, Goal, Results, Table, zero
from lexstack_experiments.runs import scenario_of
from lexstack_testing.faults.cases import CASES, FLOOD

NAME = "faults"
_MODULE = "lexstack_testing.faults.run"
_PER_CASE, _PER_RUN = 90.0, 120.0  # s of wall time at most
_WIDTH = 60  # letters of a reason in the table
Found = tuple[list[Outcome], list[str]]  # outcomes, bags that cannot be read


def run(options: Options) -> Results:
    """Do the first cases, and say what came of them."""
    names = [*CASES, *CUTS][: options.cases]
    notes = []
    outcomes, unreadable = done(options, [name for name in names if name in CASES])
    cuts = [name for name in names if name in CUTS]
    why = why_no_cut() if cuts else ""
    if why:
        notes.append(f"The network was not cut: {why}.")
    for name in () if why else cuts:
        found = _judged(options, [cut_events(options, name)], scenario_of(options.config, NAME))
        outcomes, unreadable = outcomes + found[0], unreadable + found[1]
        options.say(f"{name}: done")
    return options.results(
        NAME,
        figures(outcomes, unreadable),
        Table.of(_row(each) for each in outcomes),
        {"mode": "realtime", "rate_hz": 100.0},
        (
            "Detected: the first of a reason in the transition or diagnostics, or a held plant.",
            "Diagnostics come once a second.",
            "Serves again: from the restart or the end of the fault; imports alone take 2 s.",
            *notes,
        ),
    )


def done(options: Options, names: Sequence[str]) -> Found:
    """Do cases in as few runs as can be, and judge them."""
    outcomes: list[Outcome] = []
    unreadable: list[str] = []
    groups = (
        [name for name in names if CASES[name].phase != "following"],
        [name for name in names if CASES[name].phase == "following"],
    )
    for number, group in enumerate(groups):
        if group:
            scenario = scenario_of(options.config, NAME)
            done_ = _perform(options, options.out / f"run_{number}", scenario, group)
            heard = done_["heard"], done_["reasons"]
            found = _judged(options, done_["events"], scenario, *heard)
            outcomes, unreadable = outcomes + found[0], unreadable + found[1]
    order = {name: place for place, name in enumerate(names)}
    return sorted(outcomes, key=lambda each: order[each.case]), unreadable


def _perform(
    options: Options, out: Path, scenario: ResolvedScenario, names: Sequence[str]
) -> dict[str, Any]:
    """Run the processes and do the faults; returns what was done when, and what was heard."""
    out.mkdir()
    path = out / "asked.yaml"
    seeded = replace(scenario, scenario=replace(scenario.scenario, seed=options.seed))
    path.write_text(seeded.to_yaml(), encoding="utf-8")
    words = ["--scenario", str(path), "--out", str(out), "--cases", ",".join(names)]
    with subprocess.Popen(
        [sys.executable, "-m", _MODULE, *words], stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stderr is not None
        last = ""
        for line in process.stderr:
            last = line.strip() or last
            if line.partition(":")[0] in CASES:
                options.say(last)
        if process.wait(_PER_RUN + _PER_CASE * len(names)):
            raise LexstackError(f"faults: {last}; logs: {out / 'logs'}")
    return dict(json.loads((out / "events.json").read_text(encoding="utf-8")))


def _judged(
    options: Options,
    events: Sequence[dict[str, Any]],
    resolved: ResolvedScenario,
    heard: Sequence[tuple[int, str, str]] = (),
    reasons: Sequence[tuple[int, str, str]] = (),
) -> Found:
    """Return what came of cases that share a run."""
    bags = dict.fromkeys(Path(bag) for e in events for bag in (e["bag"], e["later"]))
    record = read_record(list(bags))
    # What was said of a recorder that was away is in no bag.
    record.diagnostics += [
        Statement(*entry) for entry in heard if "recorder" in entry[1] + entry[2]
    ]
    record.transitions += [Statement(*entry) for entry in reasons]
    options.say(f"{len(record.messages)} messages read from {len(bags)} bags")
    limits = build_team(resolved).limits
    dt = 1.0 / resolved.scenario.rate
    return [outcome(event, record, limits, dt) for event in events], record.unreadable


def figures(outcomes: Sequence[Outcome], unreadable: Sequence[str]) -> list[Figure]:
    """Return what is to be reached in every case."""
    floods = [each.answers for each in outcomes if each.case.startswith("flood")]
    rate, speed = (max(getattr(e, name) for e in outcomes) for name in ("acceleration", "velocity"))
    beyond, answered = max(each.beyond for each in outcomes), floods[0] if floods else None
    return [
        Figure("Peak acceleration of the command / limit", rate, "", AT_MOST_ONE),
        Figure("Peak velocity of the command / limit", speed, "", AT_MOST_ONE),
        Figure(
            "Largest way of a command out of its box", beyond, "m/s or rad/s", Goal("<=", 0, 1e-9)
        ),
        zero("Messages reordered", sum(e.reordered for e in outcomes)),
        zero("Cases without the reason", sum(bool(e.missing) for e in outcomes)),
        zero("Cases after which the solver did not serve", sum(not e.rejoined for e in outcomes)),
        zero("Cases that were not seen to end", sum(e.recovered is None for e in outcomes)),
        zero("Bags that cannot be read", len(unreadable)),
        Figure("Requests of the flood that were answered", answered, "", Goal("==", FLOOD)),
        Figure("Longest detection", largest(e.detected for e in outcomes), "s"),
        Figure("Longest way back", largest(e.recovered for e in outcomes), "s"),
    ]


def _row(each: Outcome) -> dict[str, Cell]:
    """Return a line of the table."""
    reason = f"NOT in {each.missing}" if each.missing else each.reason
    return {
        "fault": each.case,
        "detected s": each.detected,
        "in diagnostics s": each.told,
        "serves again s": each.recovered,
        "held or braked s": each.away,
        "acc. ratio": each.acceleration,
        "reordered": each.reordered,
        "reason in the transition": reason[:_WIDTH] or "–",
        "in diagnostics": each.complaint[:_WIDTH] or "–",
    }


EXPERIMENT = Experiment(
    "every process killed and stopped in every phase, cut network, floods, wrong messages",
    "cases",
    len(CASES) + len(CUTS),
    run,
)
