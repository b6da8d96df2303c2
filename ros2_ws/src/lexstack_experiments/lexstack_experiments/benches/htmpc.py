"""A full two-level solve of the HTMPC in closed loop, beside the paper's way to do it.

Every row is a closed loop of its own on the ideal plant: the tool is held, the base gets the square
wave of paper H with random peaks that the arm cannot reach, and with spheres five obstacles go
around. The rows take turns, so that what else the machine does falls on all of them alike.
``authors`` is the problem of the paper; ``lexstack`` has hard limits, bent steps and resuming
besides.

The paper's way (CasADi's sparse QP, its object built anew for every QP) solves the problem of
``authors`` from the states, guesses and references of that loop.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from importlib.util import find_spec
from time import thread_time

import casadi as ca
import numpy as np

from lexstack.errors import ModelError
from lexstack.mpc import CollisionScene, Htmpc, Plan, Start, hold, steps
from lexstack.robots import RobotModel
from lexstack.types import Vector
from lexstack_config.resolved import load_htmpc, load_robot
from lexstack_experiments.baselines.htloop import Track, objectives_of
from lexstack_experiments.baselines.htmpc_paper import LICENSED, SOLVERS, PaperHtmpc
from lexstack_experiments.experiment import Experiment, Options
from lexstack_experiments.measuring import no_collection
from lexstack_experiments.results import Cell, Figure, Goal, Peer, Results, Table, zero

NAME = "htmpc"
SOLVES = 1000
ROBOTS = ("ur10_ridgeback", "panda_summit")
HORIZONS = (10, 20, 30)
PARAMETERS = ("authors", "lexstack")
SPHERES, OBSTACLES = 10, 5
_TURN = 50  # solves of one row before it is the next one's turn
_PAPER = 20  # solves in the paper's way, per row
_MS = 1e3
_TWICE = Goal("<=", 2.5)
_HALF = 8.0  # s, half a period of the square wave
_RADIUS = 0.2  # m, of the obstacles

_NOTES = (
    "ms: wall time of a two-level solve; cpu ms: time of the thread, without what others took.",
    "failed: solves of which a level failed; ratio: cpu p50 of the paper's way over ours.",
)


@dataclass(frozen=True, slots=True)
class Row:
    """What one row solves."""

    robot: str
    horizon: int
    spheres: bool
    parameters: str

    @property
    def text(self) -> str:
        """Say it in words."""
        spheres = f", {SPHERES} spheres" if self.spheres else ""
        return f"{self.robot}, N = {self.horizon}{spheres}, {self.parameters}"


class Loop:
    """The closed loop of one row, to be advanced in turns.

    Attributes:
        row: what it is.
        wall: of every solve [s].
        cpu: of every solve [s].
        failed: solves with a failed level.
        paper: wall times of the paper's way [s].
        paper_cpu: its thread's times [s].
        paper_failed: QPs that the paper's way could not solve.
    """

    def __init__(self, row: Row, options: Options, paper: str) -> None:
        """Build the optimiser, and for ``authors`` the paper's."""
        self.row = row
        folder = options.config
        robot = RobotModel("robot", load_robot(folder / "robots" / f"{row.robot}.yaml"))
        loaded = load_htmpc(folder / "htmpc" / f"{row.parameters}.yaml")
        config = dataclasses.replace(loaded, horizon=row.horizon)
        chosen = _chosen(robot) if row.spheres else ()
        self._optimiser = Htmpc(robot, config, chosen)
        self._q, self._v = robot.home((0.0, 0.0, 0.0)), np.zeros(robot.n)
        self._tracks = tracks_of(robot, options)
        self._plan: Plan | None = None
        self._every = max(1, options.cases // _PAPER)
        self._paper: PaperHtmpc | None = None
        fits = paper != "gurobi" or row.horizon * robot.n <= LICENSED
        if row.parameters == "authors" and fits:
            kinds = ("ee_position", "base_position")
            radii = (_RADIUS,) * OBSTACLES if row.spheres else ()
            self._paper = PaperHtmpc(robot, config, kinds, paper, spheres=chosen, radii=radii)
        self.wall: list[float] = []
        self.cpu: list[float] = []
        self.failed = 0
        self.paper: list[float] = []
        self.paper_cpu: list[float] = []

    @property
    def paper_failed(self) -> int:
        """QPs that the paper's way could not solve."""
        return 0 if self._paper is None else self._paper.failures

    def advance(self, count: int) -> None:
        """Do some solves more."""
        optimiser = self._optimiser
        for _ in range(count):
            now = len(self.wall) * optimiser.config.step
            times = now + optimiser.horizon.times
            objectives = objectives_of(self._tracks, times)
            around = _around(times[1:]) if self.row.spheres else None
            start = Start(now, self._q, self._v)
            before = self._plan
            begun = thread_time()
            plan = optimiser.solve(start, objectives, before, around)
            self.cpu.append(thread_time() - begun)
            self.wall.append(plan.solve_time)
            self.failed += not plan.solved
            if self._paper is not None and len(self.wall) % self._every == 0 and before is not None:
                state = (start.q, start.v, before.input_before(now))
                begun = thread_time()
                self.paper.append(
                    self._paper.solve(state, objectives, before.shifted(now), around)[1]
                )
                self.paper_cpu.append(thread_time() - begun)
            self._plan, self._q, self._v = plan, plan.q[1], plan.v[1]

    def cells(self) -> dict[str, Cell]:
        """Return the row of the table."""
        row = self.row
        return {
            "robot": row.robot,
            "N": row.horizon,
            "spheres": SPHERES if row.spheres else 0,
            "parameters": row.parameters,
            "ms p50": _ms(self.wall),
            "ms p99": _ms(self.wall, 99),
            "ms worst": _MS * max(self.wall),
            "ms mean": _MS * float(np.mean(self.wall)),
            "cpu ms p50": _ms(self.cpu),
            "cpu ms p99": _ms(self.cpu, 99),
            "failed": self.failed,
            "paper ms p50": _ms(self.paper),
            "ratio": self.ratio,
        }

    @property
    def ratio(self) -> float | None:
        """The paper's way over ours, in medians of the thread's time, None where it did not run."""
        return float(np.median(self.paper_cpu) / np.median(self.cpu)) if self.paper else None


def _ms(times: list[float], percent: float = 50.0) -> float | None:
    """Return a percentile of times [s] in ms, by default the median; None without any."""
    return _MS * float(np.percentile(times, percent)) if times else None


def run(options: Options) -> Results:
    """Run all rows in turns, and compare."""
    paper = paper_solver()
    options.say(f"the paper's way with CasADi's {paper}")
    rows = [
        Row(robot, horizon, spheres, parameters)
        for robot in ROBOTS
        for horizon in HORIZONS
        for spheres in (False, True)
        for parameters in PARAMETERS
    ]
    loops = {}
    for row in rows:
        loops[row] = Loop(row, options, paper)
        loops[row].advance(1)  # the first solve warms up and does not count
        loops[row].wall.clear()
        loops[row].cpu.clear()
    options.say("all built")
    with no_collection():
        for begun in range(0, options.cases, _TURN):
            for loop in loops.values():
                loop.advance(min(_TURN, options.cases - begun))
            options.say(f"{min(begun + _TURN, options.cases)} of {options.cases} solves per row")
    failures = sum(loop.paper_failed for loop in loops.values())
    return options.results(
        NAME,
        _figures(loops, paper),
        Table.of(loop.cells() for loop in loops.values()),
        {"paper_qp_solver": paper, "paper_qp_failures": failures, "obstacles": OBSTACLES},
        _NOTES,
    )


def paper_solver() -> str:
    """Return the first QP solver of the paper's way that works here: Gurobi if it is there."""
    for name in SOLVERS:
        if find_spec("gurobipy") if name == "gurobi" else ca.has_conic(name):
            return name
    raise ModelError(f"CasADi has none of the QP solvers {', '.join(SOLVERS)}")


def _figures(loops: dict[Row, Loop], paper: str) -> list[Figure]:
    """Return the figures to reach."""
    figures = []
    for row, loop in loops.items():
        peer = Peer(f"the paper's way, {paper}", _ms(loop.paper)) if loop.paper else None
        if row.horizon == 10:
            goal = Goal("<=", 4.0 if row.spheres else 2.0)
            figures.append(
                Figure(f"{row.text}: p50", _ms(loop.wall), "ms", goal, "63 ms mean", peer)
            )
            if not row.spheres:
                figures.append(
                    Figure(f"{row.text}: p99", _ms(loop.wall, 99), "ms", Goal("<=", 6.0))
                )
            if loop.paper:
                name = f"{row.text}: the paper's way over ours"
                figures.append(Figure(name, loop.ratio, "", Goal(">=", 20.0)))
        if row.horizon == 20 and not row.spheres:
            short = loops[dataclasses.replace(row, horizon=10)]
            ratio = float(np.median(loop.cpu) / np.median(short.cpu))
            figures.append(Figure(f"{row.text}: cpu over N = 10", ratio, "", _TWICE))
    failed = sum(loop.failed for loop in loops.values())
    return [*figures, zero("Solves with a failed level", float(failed))]


def tracks_of(robot: RobotModel, options: Options) -> tuple[Track, Track]:
    """Return the tasks: hold the tool at home; the base between random peaks and home."""
    rng = np.random.default_rng(options.seed)
    tool = robot.tool(robot.home((0.0, 0.0, 0.0)))[0].position
    waves = int(np.ceil(options.cases * 0.1 / (2.0 * _HALF))) + 1
    reach = float(np.linalg.norm(tool[:2])) + 0.4  # about that of either arm, from the base
    radius = reach + 0.25 + 0.25 * rng.random(waves)
    angle = rng.uniform(-np.pi, np.pi, waves)
    peaks = tool[:2] + radius[:, None] * np.column_stack((np.cos(angle), np.sin(angle)))
    values = np.zeros((2 * waves, 2))
    values[::2] = peaks
    wave = steps(_HALF * np.arange(2 * waves), values)
    return Track("ee_position", hold(tool)), Track("base_position", wave)


def _around(times: Vector) -> CollisionScene:
    """Return five obstacles that go around the robot, at times of shape (N,) [s]."""
    angles = 2.0 * np.pi * np.arange(OBSTACLES) / OBSTACLES + 0.1 * times[:, None]
    heights = np.broadcast_to(np.linspace(0.3, 1.3, OBSTACLES), angles.shape)
    centers = np.stack((2.2 * np.cos(angles), 2.2 * np.sin(angles), heights), axis=2)
    return CollisionScene(centers, np.full(OBSTACLES, _RADIUS))


def _chosen(robot: RobotModel) -> tuple[int, ...]:
    """Return ten of the robot's spheres, from the base to the tool."""
    places = np.linspace(0, len(robot.config.spheres) - 1, SPHERES).round().astype(int)
    return tuple(int(place) for place in places)


EXPERIMENT = Experiment("the HTMPC beside the paper's way", "solves per row", SOLVES, run)
