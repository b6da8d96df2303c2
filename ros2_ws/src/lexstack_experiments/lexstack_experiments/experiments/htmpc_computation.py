"""Solve times of both robots over N, with and without distances: H, Sec. V, 63 ms and 17 ms.

The rows are those of ``./scripts/bench htmpc``, with fewer solves: ours with the authors' problem
and with ours, and the paper's way in the same run. Beside them HTIDKC on the same tasks, on
lexstack's HQP.
"""

from __future__ import annotations

from dataclasses import replace
from time import perf_counter

import numpy as np

from lexstack.robots import RobotModel
from lexstack.types import Vector
from lexstack_config.resolved import load_robot
from lexstack_experiments.baselines.htidkc import Htidkc, load_htidkc
from lexstack_experiments.benches import htmpc as bench
from lexstack_experiments.experiment import Experiment, Options
from lexstack_experiments.experiments.htmpc_pictures import draw_times
from lexstack_experiments.measuring import p50_p99
from lexstack_experiments.results import Cell, Figure, Results, Table

NAME = "htmpc-computation"
SOLVES = 250
_MS = 1e3

_COLUMNS = ("robot", "ms mean", "ms p50", "ms p99")


def run(options: Options) -> Results:
    """Run the bench's rows, then HTIDKC."""
    results = bench.run(options)
    times = {name: htidkc_times(name, options) for name in bench.ROBOTS}
    rows = [_row(name, values) for name, values in times.items()]
    paper = Figure("HTIDKC, both levels, mean", float(_MS * times[bench.ROBOTS[0]].mean()), "ms")
    draw_times(_curves(results.tables[0]), options.out / "computation.png")
    return replace(
        results,
        name=NAME,
        figures=(*results.figures, replace(paper, paper="17 ms")),
        tables=(*results.tables, Table(_COLUMNS, tuple(rows), "HTIDKC on the same tasks")),
    )


def htidkc_times(name: str, options: Options) -> Vector:
    """Return wall times of HTIDKC along the bench's tasks [s], kinematics and tasks included."""
    robot = RobotModel("robot", load_robot(options.config / "robots" / f"{name}.yaml"))
    gains = load_htidkc(options.config / "htmpc" / "baselines" / "htidkc-tuned.yaml")
    controller = Htidkc(robot, gains)
    tracks = bench.tracks_of(robot, options)
    q, v = robot.home((0.0, 0.0, 0.0)), np.zeros(robot.n)
    times = []
    for k in range(options.cases + 1):
        now = np.array([k * controller.period])
        references = tuple((track.kind, track.trajectory.at(now)[0]) for track in tracks)
        begun = perf_counter()
        v = controller.solve(q, v, references).chi
        times.append(perf_counter() - begun)
        q = q + controller.period * v
    return np.array(times[1:])  # the first one warms up


def _row(name: str, times: Vector) -> tuple[Cell, ...]:
    """Return the row of one robot."""
    return (name, _MS * float(times.mean()), *p50_p99(_MS * times))


def _curves(table: Table) -> dict[str, dict[str, list[tuple[int, float]]]]:
    """Return N and median [ms] for each curve, by robot."""
    found: dict[str, dict[str, list[tuple[int, float]]]] = {}
    for row in table.rows:
        cells = dict(zip(table.columns, row, strict=True))
        curves = found.setdefault(str(cells["robot"]), {})
        spheres = ", spheres" if cells["spheres"] else ""
        n = int(cells["N"] or 0)
        for column, name in (
            ("cpu ms p50", cells["parameters"]),
            ("paper cpu ms p50", "the paper's way"),
        ):
            value = cells[column]
            if isinstance(value, float):
                curves.setdefault(f"{name}{spheres}", []).append((n, value))
    return found


EXPERIMENT = Experiment(
    "solve times of HTMPC, the paper's way and HTIDKC", "solves per row", SOLVES, run
)
