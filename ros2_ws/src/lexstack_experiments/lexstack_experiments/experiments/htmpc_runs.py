"""The square wave of paper H, Sec. V: its cases, how they are run, and what is measured.

The tool is to stay where it is at home; the base is to go to a peak that it cannot reach without
taking the tool along (part 1), and back home (part 2). The plant is ideal: a double integrator.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
from scipy.optimize import minimize

from lexstack.errors import ModelError
from lexstack.mpc import Htmpc, HtmpcConfig, hold, steps
from lexstack.robots import RobotModel
from lexstack.types import Matrix, Vector
from lexstack_config.resolved import load_robot
from lexstack_experiments.baselines.htidkc import Htidkc, HtidkcConfig
from lexstack_experiments.baselines.htloop import Record, Track, follow_htidkc, follow_htmpc
from lexstack_experiments.measuring import after_last

ROBOT = "ur10_ridgeback"
HALF = 8.0  # s, part 1; part 2 is as long
SEEN = 1.0  # s, N dt: so long before the step a horizon sees it
WITHIN = 0.05  # of the initial error: the band of H Fig. 5
EXAMPLE = (0.5278, -1.9324)  # m, the peak of H Figs. 3 to 5
_REACH = 1.83  # m, the authors' value
_BAND = 0.25  # m
_FARTHEST = 3.0  # m from the base's home
_PERIOD = 0.02  # s, between the states that are measured
_STARTS = 12  # of the search for the reach

Follow = Callable[[Vector, tuple[Track, ...]], Record]
"""A controller in its loop: from rest at q, (n,), along the tracks, for both parts."""


@dataclass(frozen=True, slots=True, eq=False)
class Setting:
    """The robot at home, and where its tool is there.

    Attributes:
        robot: its model.
        home: q, shape (n,).
        tool: position, shape (3,), m.
        reach: how far the base can be from the tool, horizontally, with the tool there [m].
    """

    robot: RobotModel
    home: Vector
    tool: Vector
    reach: float

    def optimum(self, peak: Vector) -> float:
        """Return the least base error that leaves the tool where it is [m]; yaw is free."""
        return max(0.0, float(np.linalg.norm(peak - self.tool[:2])) - self.reach)


@dataclass(frozen=True, slots=True, eq=False)
class Wave:
    """One run of the square wave, measured every 20 ms, also between two solves.

    Attributes:
        times: shape (m,), s.
        tool: distance of the tool from where it is to stay, shape (m,), mm.
        base: distance of the base from its reference, of its initial value in each part, (m,).
        path: of the base, shape (m, 2), m.
        optimum: least normalised error of part 1; that of part 2 is 0.
        failures: solves that failed.
    """

    times: Vector
    tool: Vector
    base: Vector
    path: Matrix
    optimum: float
    failures: int

    @property
    def integrals(self) -> tuple[float, float]:
        """The normalised base error over each part [s]."""
        split = self._split
        return (
            float(np.trapezoid(self.base[:split], self.times[:split])),
            float(np.trapezoid(self.base[split:], self.times[split:])),
        )

    @property
    def blind(self) -> float:
        """The normalised base error from the start until a horizon sees the step [s]."""
        inside = self.times <= HALF - SEEN + 1e-9
        return float(np.trapezoid(self.base[inside], self.times[inside]))

    @property
    def off(self) -> tuple[float, float]:
        """How far the base error is from its optimum at the end of each part.

        Part 1 counts until a horizon sees the step; it is the largest value of the last second.
        """
        return self._late(HALF - SEEN, self.optimum), self._late(2.0 * HALF, 0.0)

    @property
    def settled(self) -> tuple[float | None, float | None]:
        """When the error gets within 5 % of its optimum, for good, from each part's start [s]."""
        first = self._times(self.times <= HALF - SEEN + 1e-9, self.optimum)
        return first, self._times(np.arange(len(self.times)) >= self._split, 0.0)

    @property
    def _split(self) -> int:
        """Place of the first entry of part 2; the time of the step occurs twice."""
        return int(np.searchsorted(self.times, HALF - 1e-9)) + 1

    def _late(self, end: float, optimum: float) -> float:
        """Return the largest distance from the optimum in the second before ``end``."""
        inside = (self.times >= end - 1.0 - 1e-9) & (self.times <= end + 1e-9)
        return float(np.abs(self.base[inside] - optimum).max())

    def _times(self, inside: Vector, optimum: float) -> float | None:
        """Return the time from which on all of a part is within the band."""
        times, errors = self.times[inside], np.abs(self.base[inside] - optimum)
        first = after_last(errors > WITHIN)
        return None if first == len(errors) else float(times[first] - times[0])


@lru_cache(maxsize=2)
def setting(config: Path) -> Setting:
    """Return the robot of the paper's tables; raises ConfigurationError, ModelError."""
    robot = RobotModel(ROBOT, load_robot(config / "robots" / f"{ROBOT}.yaml"))
    home = robot.home((0.0, 0.0, 0.0))
    tool = np.array(robot.tool(home)[0].position)
    return Setting(robot, home, tool, farthest(robot, home, float(tool[2])))


def peaks_of(tool: Vector, count: int, seed: int) -> Matrix:
    """Return random peaks, shape (count, 2), as the authors draw them.

    With seed 0 their example is among the first 25: r and angle in turns, around the tool.
    """
    rng = np.random.RandomState(seed)  # the generator of the authors
    peaks: list[Vector] = []
    while len(peaks) < count:
        radius = _REACH + _BAND + _BAND * rng.rand()
        angle = 2.0 * np.pi * rng.rand()
        peak = tool[:2] + radius * np.array((np.cos(angle), np.sin(angle)))
        if np.linalg.norm(peak) < _FARTHEST:
            peaks.append(peak)
    return np.array(peaks)


def wave_tracks(tool: Vector, peak: Vector) -> tuple[Track, Track]:
    """Return the two tasks: the tool stays, the base goes to the peak and back."""
    wave = steps(np.array((0.0, HALF)), np.array((peak, np.zeros(2))))
    return Track("ee_position", hold(tool)), Track("base_position", wave)


def htmpc(robot: RobotModel, config: HtmpcConfig, preview: bool = True) -> Follow:
    """Return the HTMPC in its loop; without preview it is HTMPC_WPT. It keeps no distances."""
    optimiser = Htmpc(robot, config, ())
    return lambda q, tracks: follow_htmpc(optimiser, q, tracks, 2.0 * HALF, preview=preview)


def htidkc(robot: RobotModel, config: HtidkcConfig) -> Follow:
    """Return the HTIDKC in its loop."""
    return lambda q, tracks: follow_htidkc(Htidkc(robot, config), q, tracks, 2.0 * HALF)


def run_wave(at: Setting, follow: Follow, peak: Vector) -> Wave:
    """Run one case and measure it."""
    record = follow(at.home, wave_tracks(at.tool, peak))
    times, q = between(record)
    tool = np.array([at.robot.tool(each)[0].position for each in q])
    split = int(np.searchsorted(times, HALF - 1e-9))
    first = np.linalg.norm(q[: split + 1, :2] - peak, axis=1)
    second = np.linalg.norm(q[split:, :2], axis=1)
    order = np.concatenate((np.arange(split + 1), np.arange(split, len(times))))
    return Wave(
        times[order],
        1e3 * np.linalg.norm(tool - at.tool, axis=1)[order],
        np.concatenate((first / first[0], second / second[0])),
        q[order, :2],
        at.optimum(peak) / float(first[0]),
        record.failures,
    )


def between(record: Record) -> tuple[Vector, Matrix]:
    """Return times (m,) [s] and q (m, n) every 20 ms; between two states the input is constant."""
    step = float(record.times[1] - record.times[0])
    parts = max(1, round(step / _PERIOD))
    if parts == 1:
        return record.times, record.q
    share = np.arange(parts)[None, :, None] / parts
    q, v = record.q[:-1, None], record.v[:-1, None]
    bent = record.q[1:, None] - q - step * v  # u dt^2 / 2
    inner = (q + share * step * v + share**2 * bent).reshape(-1, record.q.shape[1])
    times = (record.times[:-1, None] + step * share[0].T).reshape(-1)
    return np.append(times, record.times[-1]), np.vstack((inner, record.q[-1:]))


def farthest(robot: RobotModel, home: Vector, height: float) -> float:
    """Return the largest horizontal distance of the tool from the base at a height [m]."""
    rng = np.random.default_rng(0)
    limits = robot.limits
    box = list(zip(limits.position_lower, limits.position_upper, strict=True))
    box[:3] = [(0.0, 0.0)] * 3

    def position(q: Vector) -> Vector:
        return np.array(robot.tool(q)[0].position)

    best = 0.0
    for _ in range(_STARTS):
        begin = home + np.concatenate((np.zeros(3), rng.uniform(-1.0, 1.0, robot.n - 3)))
        found = minimize(
            lambda q: -float(np.linalg.norm(position(q)[:2])),
            begin,
            method="SLSQP",
            bounds=box,
            constraints={"type": "eq", "fun": lambda q: position(q)[2] - height},
            options={"maxiter": 300},
        )
        if abs(position(found.x)[2] - height) < 1e-5:
            best = max(best, -float(found.fun))
    if not best:
        raise ModelError(f"{robot.name}: no configuration with the tool at {height:.3f} m found")
    return best
