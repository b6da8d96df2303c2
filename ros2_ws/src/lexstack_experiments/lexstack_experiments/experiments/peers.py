"""Random reaches of three arms, beside pink and mink: how many arrive, when, within which limits.

Two problems are set: with limits of position and velocity alone, which all three can be asked to
keep; and with those of acceleration too, which pink has besides ours. Every law gets the same
starts, goals, models, period and time, and takes its turn on each reach.
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from lexstack.robots import Team
from lexstack_experiments.experiment import Experiment, Options
from lexstack_experiments.experiments.peers_cases import DT, MARGIN, ROBOTS, arm, random_reach
from lexstack_experiments.experiments.peers_ours import ByJoints, Straight
from lexstack_experiments.experiments.peers_pictures import draw
from lexstack_experiments.experiments.peers_runs import SECONDS, Law, Run, run
from lexstack_experiments.experiments.peers_theirs import Mink, Pink, Weighted
from lexstack_experiments.measuring import no_collection, p50_p99
from lexstack_experiments.results import Cell, Figure, Goal, Peer, Results, Table, zero

NAME = "peers"
_US = 1e6
VELOCITY, ALL = "velocity", "acceleration"
"""The problems: with limits up to those of velocity, and of acceleration."""

_COLUMNS = ("robot", "limits", "law", "reached %", "median s", "90 % s", "position ticks",
            "largest rad", "velocity ticks", "largest x", "acceleration ticks", "most x",
            "us p50", "us p99", "ms before")  # fmt: skip


@dataclass(frozen=True, slots=True)
class Entry:
    """Who takes part.

    Attributes:
        name: of the law.
        limits: ``VELOCITY`` or ``ALL``.
        make: from the arm, with these limits, to the law.
        peer: whether it is not ours.
        straight: whether it follows the tool's error; the others know the joints' goal before.
    """

    name: str
    limits: str
    make: Callable[[Team], Law]
    peer: bool = False
    straight: bool = True

    @property
    def key(self) -> tuple[str, str]:
        """Tells it from others."""
        return self.limits, self.name


QUICK = {"gain": 100.0, "max_linear": 5.0, "max_angular": 5.0}
"""Of ``ee_pose``: the whole error in one period, as pink and mink by default; 1/s, m/s, rad/s."""

TUNED = {"gain": 10.0, "max_linear": 1.0, "max_angular": 2.0}
"""Of ``ee_pose``, chosen on 25 to 40 other reaches of each arm (seed 101); 1/s, m/s, rad/s."""

ENTRIES = (
    Entry("lexstack", VELOCITY, lambda team: Straight(team, QUICK)),
    Entry("lexstack, by joints", VELOCITY, ByJoints, straight=False),
    Entry("pink, defaults", VELOCITY, lambda team: Pink(team, Weighted()), peer=True),
    Entry("mink, defaults", VELOCITY, lambda team: Mink(team, Weighted()), peer=True),
    Entry("mink, tuned", VELOCITY, lambda team: Mink(team, MINK), peer=True),
    Entry("lexstack, defaults", ALL, lambda team: Straight(team, {})),
    Entry("lexstack, tuned", ALL, lambda team: Straight(team, TUNED)),
    Entry("lexstack, by joints", ALL, ByJoints, straight=False),
    Entry("pink, tuned", ALL, lambda team: Pink(team, PINK), peer=True),
    Entry("pink, by joints", ALL, lambda team: Pink(team, PINK_JOINTS), peer=True, straight=False),
)
PINK = Weighted(gain=0.1, accelerations=True)
PINK_JOINTS = Weighted(gain=0.1, accelerations=True, joints=True)
MINK = Weighted(gain=0.5, lm_damping=1e-2)
"""Tuned on the same reaches as ours: gain 0.02 to 1, lm_damping 0 to 1, posture 1e-4 to 1e-2."""

Runs = dict[tuple[str, str, str], list[Run]]
"""Of each robot, limits, law."""


def run_experiment(options: Options) -> Results:
    """Run all reaches with all laws, in turns, an arm per process, and compare."""
    runs: Runs = {}
    missing: set[str] = set()
    with ProcessPoolExecutor(min(len(ROBOTS), os.cpu_count() or 1)) as pool:
        work = partial(_reaches, options.config, options.seed, options.cases)
        for robot, (found, absent) in zip(ROBOTS, pool.map(work, ROBOTS), strict=True):
            runs |= found
            missing |= absent
            options.say(f"{robot}: {options.cases} reaches")
    draw(options.out / "peers.png", runs, SECONDS)
    return options.results(
        NAME,
        _figures(runs),
        Table(_COLUMNS, tuple(_row(key, found) for key, found in runs.items())),
        {"plant": "exact integrator", "seconds": SECONDS, "dt_s": DT, "margin": MARGIN},
        tuple(f"Not installed, so not in the table: {name}." for name in sorted(missing)),
    )


def _reaches(config: Path, seed: int, cases: int, robot: str) -> tuple[Runs, set[str]]:
    """Return the runs of one arm, and which packages are missing."""
    runs: Runs = {}
    missing: set[str] = set()
    teams = {ALL: arm(config, robot), VELOCITY: arm(config, robot, free=True)}
    laws: list[tuple[Entry, Law]] = []
    rng = np.random.default_rng([seed, ROBOTS.index(robot)])
    with warnings.catch_warnings(), no_collection():
        warnings.simplefilter("ignore")  # pink's, of joints at their limits
        for entry in ENTRIES:
            try:
                laws.append((entry, entry.make(teams[entry.limits])))
            except ImportError as error:
                missing.add(error.name or str(error))
        for number in range(cases):
            reach = random_reach(teams[ALL], rng)
            for turn in range(len(laws)):
                entry, law = laws[(turn + number) % len(laws)]
                found = run(law, reach, teams[ALL])
                runs.setdefault((robot, *entry.key), []).append(found)
    return runs, missing


def _row(key: tuple[str, str, str], runs: list[Run]) -> tuple[Cell, ...]:
    """Return a row of the table."""
    times = [each.time for each in runs if each.time is not None]
    over = np.sum([each.over for each in runs], axis=0).tolist()
    sizes = np.max([each.sizes for each in runs], axis=0).tolist()
    beyond = [cell for pair in zip(over, sizes, strict=True) for cell in pair]
    steps = _US * np.concatenate([each.steps for each in runs])
    before = 1e3 * float(np.median([each.preparing for each in runs]))
    share = 100.0 * len(times) / len(runs)
    return (
        *key,
        share,
        _quantile(times, 0.5),
        _quantile(times, 0.9),
        *beyond,
        *p50_p99(steps),
        before,
    )


def _quantile(times: list[float], share: float) -> float | None:
    """Return a quantile of the reaches that arrive, None of none."""
    return float(np.quantile(times, share)) if times else None


def _figures(runs: Runs) -> list[Figure]:
    """Return what ours is to reach, on all arms together."""
    figures = []
    own = [e for e in ENTRIES if not e.peer]
    kept = {VELOCITY: 2, ALL: 3}  # which limits a law knows
    for name, what in enumerate(("position", "velocity", "acceleration")):
        ticks = sum(
            each.over[name]
            for entry in own
            if name < kept[entry.limits]
            for each in _of(runs, entry)
        )
        figures.append(zero(f"ticks of ours beyond limits of {what}", ticks))
    for limits in (VELOCITY, ALL):
        for straight in (True, False):
            figures += _against(runs, limits, straight=straight)
    return figures


def _of(runs: Runs, entry: Entry) -> list[Run]:
    """Return an entry's runs, robot by robot."""
    return [each for robot in ROBOTS for each in runs.get((robot, *entry.key), [])]


def _against(runs: Runs, limits: str, *, straight: bool) -> list[Figure]:
    """Return share and time of ours beside the peers that have the same limits to keep.

    Times are compared on the reaches that both come to an end of.
    """
    same = [e for e in ENTRIES if e.limits == limits]
    (*_, mine) = [e for e in same if not e.peer and e.straight == straight]
    peers = [e for e in same if e.peer and (e.straight or not straight) and _of(runs, e)]
    if not peers:
        return []
    ours, title = _of(runs, mine), f"limits up to {limits}, {mine.name}"
    best = max(peers, key=lambda e: _share(_of(runs, e)))
    ratios = {e.name: _ratio(ours, _of(runs, e)) for e in peers}
    slowest = max((n for n in ratios if ratios[n] is not None), key=lambda n: ratios[n], default="")
    theirs = _share(_of(runs, best))
    return [
        Figure(f"{title}: share reached", _share(ours), "%", Goal(">=", theirs), "",
               Peer(best.name, theirs)),
        Figure(f"{title}: time, median over that of {slowest}", ratios.get(slowest), "x",
               Goal("<=", 1.0, 0.005)),
    ]  # fmt: skip


def _share(runs: list[Run]) -> float:
    """Return the share that arrives, %."""
    return 100.0 * sum(each.time is not None for each in runs) / max(len(runs), 1)


def _ratio(ours: list[Run], theirs: list[Run]) -> float | None:
    """Return the median of our time over theirs."""
    pairs = zip(ours, theirs, strict=True)
    ratios = [a.time / b.time for a, b in pairs if a.time is not None and b.time]
    return float(np.median(ratios)) if ratios else None


EXPERIMENT = Experiment(
    "random reaches of three arms beside pink and mink", "reaches of each arm", 500, run_experiment
)
