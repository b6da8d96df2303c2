"""How far one and three SQP iterations stay from the converged lexicographic optimum, by level.

The states are drawn from closed loops of the square wave with peaks of their own. In each, IPOPT
solves the levels in order to convergence, with the tolerance of H(13) as part of its constraints,
from the same first guess; ``warm`` is the plan before, shifted, as in the loop, and ``cold`` is
braking.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from lexstack.mpc import Htmpc, HtmpcConfig, Kind, Objective, Plan, Start, Task
from lexstack.robots import RobotModel
from lexstack.types import Matrix, Vector
from lexstack_config.resolved import load_htmpc
from lexstack_experiments.baselines.htloop import objectives_of
from lexstack_experiments.baselines.htmpc_oracle import HtmpcOracle, OracleLevel
from lexstack_experiments.experiment import Experiment, Options
from lexstack_experiments.experiments.htmpc_pictures import draw_gaps
from lexstack_experiments.experiments.htmpc_runs import (
    HALF,
    Setting,
    peaks_of,
    setting,
    wave_tracks,
)
from lexstack_experiments.results import Cell, Figure, Goal, Results, Table, zero

NAME = "oracle"
STATES = 200
PER_LOOP = 20
ITERATIONS = (1, 3)
GUESSES = ("warm", "cold")
SEED = 2000  # added to --seed: neither tables nor tuning draw their peaks from there
KINDS: tuple[Kind, Kind] = ("ee_position", "base_position")
_SOME = 1e-2  # of cost: below, there was nothing to gain (about a millimetre of the tool)

_COLUMNS = (
    "level", "guess", "iterations", "gap of all", "states", "gap p50", "gap p90", "gap worst",
    "below optimum", "error mm", "optimum mm", "off p50 mm", "off p90 mm",
)  # fmt: skip
_NOTES = (
    "gap: cost H(9a) above the converged optimum, of what there was to gain: at level 1 from",
    "braking, at level 2 from the optimum of level 1. of all: sum of gaps over sum of gains; p50,",
    "p90, worst: over the states with something to gain. At level 2 the optimum spends delta",
    "wherever that helps, ours only where a step does by its curvature.",
    "below optimum: states where ours costs less than IPOPT's, which is a local method too, and",
    "whose level 2 is held by its own level 1. error, optimum: means over states of the rms of the",
    "task's error over the horizon; off: by how much these differ.",
)


@dataclass(frozen=True, slots=True, eq=False)
class State:
    """One state of a closed loop, with all that a solve gets there."""

    start: Start
    objectives: tuple[Objective, ...]
    before: Plan


@dataclass(frozen=True, slots=True, eq=False)
class Gap:
    """One solve beside the optimum.

    Attributes:
        level: 0 or 1.
        guess: warm or cold.
        iterations: of SQP.
        gap: cost above the optimum.
        gain: what there was to gain in cost.
        rms: of the task's error over the horizon [m].
        best: the same at the optimum [m].
    """

    level: int
    guess: str
    iterations: int
    gap: float
    gain: float
    rms: float
    best: float


def states_of(at: Setting, optimiser: Htmpc, count: int, seed: int) -> Iterator[State]:
    """Yield states drawn from closed loops, no two of one solve; never the first solve."""
    rng = np.random.default_rng(seed)
    step = optimiser.config.step
    solves = round(2.0 * HALF / step)
    for peak in peaks_of(at.tool, -(-count // PER_LOOP), SEED + seed):
        tracks = wave_tracks(at.tool, peak)
        chosen = set((1 + rng.permutation(solves - 1)[: min(PER_LOOP, count)]).tolist())
        count -= len(chosen)
        q, v, plan = at.home, np.zeros(at.robot.n), None
        for k in range(max(chosen) + 1):
            start = Start(k * step, q, v)
            objectives = objectives_of(tracks, start.stamp + optimiser.horizon.times)
            if k in chosen and plan is not None:
                yield State(start, objectives, plan)
            plan = optimiser.solve(start, objectives, plan)
            q, v = plan.q[1], plan.v[1]


class Judge:
    """Holds solves against the oracle's levels.

    Attributes:
        unsolved: states where IPOPT did not converge at every level.
        failures: our solves that failed.
    """

    def __init__(self, robot: RobotModel, config: HtmpcConfig) -> None:
        """Generate the programs of the oracle, and an optimiser for each number of iterations."""
        self._oracle = HtmpcOracle(robot, config, KINDS)
        self._ours = {
            i: Htmpc(robot, replace(config, iterations=i, early_stop_ratio=0.0), ())
            for i in ITERATIONS
        }
        self.unsolved = 0
        self.failures = 0

    def gaps(self, state: State) -> list[Gap]:
        """Return the gaps of all levels, guesses and iterations; none where IPOPT failed."""
        start = state.start
        begun = (start.q, start.v, state.before.input_before(start.stamp))
        guess = state.before.shifted(start.stamp)
        levels = self._oracle.solve(begun, state.objectives, guess, 1.0)
        if len(levels) < len(KINDS) or not all(level.converged for level in levels):
            self.unsolved += 1
            return []
        return [
            gap
            for iterations, solver in self._ours.items()
            for warm in GUESSES
            for gap in self._both(solver, state, levels, warm, iterations)
        ]

    def _both(
        self,
        solver: Htmpc,
        state: State,
        levels: tuple[OracleLevel, ...],
        guess: str,
        iterations: int,
    ) -> Iterator[Gap]:
        """Yield the gaps of both levels."""
        program = solver.program(state.start, state.before)
        # Cold, but with the same input before: braking that begins where the plan before was.
        before = state.before if guess == "warm" else _braking(solver, state)
        braking = solver.horizon.braking(state.start.v, solver.robot.limits.acceleration)
        for level, objective in enumerate(state.objectives):
            task = Task(objective, solver.config, solver.robot)
            plan = solver.solve(state.start, state.objectives[: level + 1], before)
            self.failures += not plan.solved

            def cost(u: Matrix, task: Task = task) -> float:
                return program.cost(program.iterate(u), task)

            def rms(u: Matrix, task: Task = task) -> float:
                error = task.error(program.iterate(u).at)
                return float(np.sqrt(np.mean(np.square(error).sum(axis=1))))

            best = levels[level]
            worst = cost(levels[0].u if level else braking)
            yield Gap(
                level,
                guess,
                iterations,
                cost(plan.u) - best.total,
                worst - best.total,
                rms(plan.u),
                rms(best.u),
            )


def _braking(solver: Htmpc, state: State) -> Plan:
    """Return a plan that brakes, made to look as if it were the one before."""
    u = solver.horizon.braking(state.start.v, solver.robot.limits.acceleration)
    shifted = np.vstack((state.before.input_before(state.start.stamp), u[:-1]))
    return replace(state.before, u=shifted, active_sets=())


def run(options: Options) -> Results:
    """Judge all states."""
    at = setting(options.config)
    config = load_htmpc(options.config / "htmpc" / "lexstack.yaml")
    judge = Judge(at.robot, config)
    found: list[Gap] = []
    loop = Htmpc(at.robot, config, ())
    for i, state in enumerate(states_of(at, loop, options.cases, options.seed)):
        found += judge.gaps(state)
        if (i + 1) % PER_LOOP == 0:
            options.say(f"{i + 1} of {options.cases} states")
    draw_gaps(_shares_of(found), options.out / "gaps.png")
    return options.results(
        NAME,
        _figures(found, judge),
        Table(_COLUMNS, _rows(found)),
        {"peaks_seed": SEED + options.seed, "tolerance_of_oracle": "delta of H(13)"},
        _NOTES,
    )


def _chosen(found: list[Gap], level: int, guess: str, iterations: int) -> list[Gap]:
    """Return the gaps of one row."""
    return [g for g in found if (g.level, g.guess, g.iterations) == (level, guess, iterations)]


def _each(found: list[Gap]) -> Iterator[tuple[int, str, int, list[Gap]]]:
    """Yield level, guess, iterations and the gaps, row by row."""
    for level in range(len(KINDS)):
        for guess in GUESSES:
            for iterations in ITERATIONS:
                yield level, guess, iterations, _chosen(found, level, guess, iterations)


def shares(found: list[Gap]) -> Vector:
    """Return the gaps of a row, of what there was to gain, where there was something."""
    gains = np.array([gap.gain for gap in found])
    gaps = np.array([gap.gap for gap in found])
    some = gains > _SOME
    return np.asarray(gaps[some] / gains[some])


def of_all(found: list[Gap]) -> float | None:
    """Return the sum of a row's gaps, of all that there was to gain; None without any."""
    gain = sum(gap.gain for gap in found)
    return sum(gap.gap for gap in found) / gain if gain else None


def _shares_of(found: list[Gap]) -> dict[str, Vector]:
    """Return the shares of every row by its name."""
    return {
        f"level {level + 1}, {guess}, {iterations}": shares(gaps)
        for level, guess, iterations, gaps in _each(found)
    }


def _rows(found: list[Gap]) -> Iterator[tuple[Cell, ...]]:
    """Yield the rows of the table."""
    for level, guess, iterations, gaps in _each(found):
        part = shares(gaps)
        off = 1e3 * np.array([gap.rms - gap.best for gap in gaps])

        def value(of: Callable[[Vector], float], values: Vector) -> float | None:
            return float(of(values)) if len(values) else None

        yield (
            level + 1, guess, iterations, of_all(gaps), len(part), value(np.median, part),
            value(lambda v: float(np.percentile(v, 90)), part), value(np.max, part),
            int((part < 0.0).sum()), value(np.mean, 1e3 * np.array([gap.rms for gap in gaps])),
            value(np.mean, 1e3 * np.array([gap.best for gap in gaps])), value(np.median, off),
            value(lambda v: float(np.percentile(v, 90)), off),
        )  # fmt: skip


def _figures(found: list[Gap], judge: Judge) -> list[Figure]:
    """Return the gaps; what is to hold is that they are measured everywhere, and shrink."""
    figures, all_of = [], {}
    for level, guess, iterations, gaps in _each(found):
        all_of[level, guess, iterations] = of_all(gaps)
        if guess == "warm":
            name = f"Gap of level {level + 1}, {iterations} SQP per level, of all there was to gain"
            figures.append(Figure(name, all_of[level, guess, iterations]))
    for level in range(len(KINDS)):
        one, three = (all_of[level, "cold", iterations] for iterations in ITERATIONS)
        ratio = three / one if one and three is not None else None
        name = f"Gap of level {level + 1} from cold, three iterations over one"
        figures.append(Figure(name, ratio, "", Goal("<=", 1.0)))
    return [
        *figures,
        zero("States where IPOPT did not converge", float(judge.unsolved)),
        zero("Failed solves", float(judge.failures)),
    ]


EXPERIMENT = Experiment(
    "gap of one and three SQP iterations to the converged optimum", "states", STATES, run
)
