"""Closed loops of the HTMPC on the ideal plant, to be advanced in turns."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from time import thread_time
from typing import Any

import numpy as np

from lexstack.mpc import CollisionScene, Htmpc, Objective, Plan, Start, hold, steps
from lexstack.robots import RobotModel
from lexstack.types import Vector
from lexstack_config.resolved import load_htmpc, load_robot
from lexstack_experiments.baselines.htloop import Track, objectives_of
from lexstack_experiments.baselines.htmpc_paper import LICENSED, PaperHtmpc
from lexstack_experiments.experiment import Options
from lexstack_experiments.results import Cell

SPHERES, OBSTACLES = 10, 5
_PAPER = 20  # solves in the paper's way, per row
_MS = 1e3
_HALF = 8.0  # s, half a period of the square wave
_RADIUS = 0.2  # m, of the obstacles


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
        states: what the first solves were given, as a worker takes it.
        paper: wall times of the paper's way [s].
        paper_cpu: its thread's times [s].
        paper_failed: QPs that the paper's way could not solve.
    """

    def __init__(self, row: Row, options: Options, paper: str, keep: int = 0) -> None:
        """Build the optimiser, and for ``authors`` the paper's; keep so many states."""
        self.row = row
        folder = options.config
        robot = RobotModel("robot", load_robot(folder / "robots" / f"{row.robot}.yaml"))
        loaded = load_htmpc(folder / "htmpc" / f"{row.parameters}.yaml")
        config = dataclasses.replace(loaded, horizon=row.horizon)
        chosen = _chosen(robot) if row.spheres else ()
        self._optimiser, self._spheres = Htmpc(robot, config, chosen), chosen
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
        self._keep = keep
        self.states: list[dict[str, Any]] = []
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
            if len(self.states) < self._keep:
                self.states.append(_listed(start, objectives, around))
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

    @property
    def described(self) -> dict[str, Any]:
        """The row as a worker takes it."""
        row = self.row
        return {
            "robot": row.robot,
            "horizon": row.horizon,
            "parameters": row.parameters,
            "spheres": list(self._spheres),
        }

    def cells(self) -> dict[str, Cell]:
        """Return the row of the table."""
        row = self.row
        return {
            "robot": row.robot,
            "N": row.horizon,
            "spheres": SPHERES if row.spheres else 0,
            "parameters": row.parameters,
            "paper over ours": self.ratio,
            "cpu ms p50": ms(self.cpu),
            "cpu ms p99": ms(self.cpu, 99),
            "paper cpu ms p50": ms(self.paper_cpu),
            "ms p50": ms(self.wall),
            "ms p99": ms(self.wall, 99),
            "ms worst": _MS * max(self.wall),
            "ms mean": _MS * float(np.mean(self.wall)),
            "failed": self.failed,
        }

    @property
    def ratio(self) -> float | None:
        """The paper's way over ours, in medians of the thread's time, None where it did not run."""
        return float(np.median(self.paper_cpu) / np.median(self.cpu)) if self.paper else None


def ms(times: list[float], percent: float = 50.0) -> float | None:
    """Return a percentile of times [s] in ms, by default the median; None without any."""
    return _MS * float(np.percentile(times, percent)) if times else None


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


def _listed(
    start: Start, objectives: tuple[Objective, ...], around: CollisionScene | None
) -> dict[str, Any]:
    """Return what a solve is given, as JSON holds it."""
    return {
        "stamp": start.stamp,
        "q": start.q,
        "v": start.v,
        "references": [(each.kind, each.reference) for each in objectives],
        "centers": [] if around is None else around.centers,
        "radii": [] if around is None else around.radii,
    }
