"""Random square waves: HTMPC, HTMPC_WPT and HTIDKC; Figs. 3, 4, 6 and 7 of H.

Every controller runs with the paper's gains and with tuned ones; tuning is an experiment of its own
(``tune-htmpc``), on other cases, with as many trials for each.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lexstack.robots import RobotModel
from lexstack.types import Matrix, Vector
from lexstack_config.resolved import load_htmpc
from lexstack_experiments.baselines.htidkc import load_htidkc
from lexstack_experiments.experiment import Experiment, Options
from lexstack_experiments.experiments.htmpc_pictures import (
    draw_paths,
    draw_radial,
    draw_violins,
    draw_waves,
)
from lexstack_experiments.experiments.htmpc_runs import (
    EXAMPLE,
    HALF,
    SEEN,
    Follow,
    Wave,
    htidkc,
    htmpc,
    peaks_of,
    run_wave,
    setting,
)
from lexstack_experiments.results import Cell, Figure, Goal, Peer, Results, Table, zero

NAME = "square-wave"
CASES = 25
OURS = "HTMPC"
WPT = "HTMPC_WPT"
TUNED = "HTIDKC tuned"
PAPER = ("HTMPC authors", "HTMPC_WPT authors", "HTIDKC authors")
_BETTER = 0.58  # of HTIDKC's error in part 2: the paper's 42 %

_CASE_COLUMNS = ("case", "x m", "y m", "controller", "part 1", "part 2", "EE mm", "EE peak mm")
_NOTES = (
    "part 1, part 2: means over time of base error / initial error, means over the cases.",
    "part 1 - optimum: above what no controller can avoid; part 2 m: not normalised.",
    "within 5 %: cases that are that near to their optimum at the end of the part.",
)


@dataclass(frozen=True, slots=True, eq=False)
class Score:
    """One controller on all cases.

    Attributes:
        waves: one for each case.
        parts: mean of the normalised base error over each part, shape (cases, 2).
    """

    waves: tuple[Wave, ...]
    parts: Matrix

    @classmethod
    def of(cls, waves: Sequence[Wave]) -> Score:
        """Return the score of these runs."""
        return cls(tuple(waves), np.array([wave.integrals for wave in waves]) / HALF)

    @property
    def mean(self) -> float:
        """Of the tool's distance over all cases [mm]."""
        return float(np.mean([wave.tool.mean() for wave in self.waves]))

    @property
    def peak(self) -> float:
        """The tool's largest distance in any case [mm]."""
        return max(float(wave.tool.max()) for wave in self.waves)

    @property
    def blind(self) -> float:
        """Mean of the normalised base error until a horizon sees the step."""
        return float(np.mean([wave.blind for wave in self.waves])) / (HALF - SEEN)

    @property
    def failures(self) -> int:
        """Solves that failed."""
        return sum(wave.failures for wave in self.waves)

    @property
    def left(self) -> float:
        """Mean over part 1 of what the base error has above its optimum."""
        return float(np.mean(self.parts[:, 0] - [wave.optimum for wave in self.waves]))

    @property
    def metres(self) -> float:
        """Mean over part 2 of the base's distance from home, not normalised [m]."""
        return float(np.mean([_second(wave) for wave in self.waves]))


def run(options: Options) -> Results:
    """Run all controllers on all cases."""
    at = setting(options.config)
    peaks = peaks_of(at.tool, options.cases, options.seed)
    scores: dict[str, Score] = {}
    for name, follow in controllers(options.config, at.robot).items():
        scores[name] = Score.of([run_wave(at, follow, peak) for peak in peaks])
        parts = scores[name].parts.mean(axis=0)
        options.say(f"{name}: parts {parts[0]:.3f}, {parts[1]:.3f}")
    _draw(scores, peaks, at.tool, options.out)
    return options.results(
        NAME,
        _figures(scores),
        (
            Table.of(_row(name, score) for name, score in scores.items()),
            Table(_CASE_COLUMNS, tuple(_case_rows(scores, peaks)), "every case"),
        ),
        {"half_period_s": HALF, "reach_m": at.reach},
        _NOTES,
    )


def controllers(config: Path, robot: RobotModel) -> dict[str, Follow]:
    """Return all controllers, ours first."""
    folder = config / "htmpc"
    authors = load_htmpc(folder / "authors.yaml")
    gains = folder / "baselines"
    return {
        OURS: htmpc(robot, load_htmpc(folder / "lexstack.yaml")),
        WPT: htmpc(robot, load_htmpc(folder / "waypoints.yaml"), preview=False),
        TUNED: htidkc(robot, load_htidkc(gains / "htidkc-tuned.yaml")),
        PAPER[0]: htmpc(robot, authors),
        PAPER[1]: htmpc(robot, authors, preview=False),
        PAPER[2]: htidkc(robot, load_htidkc(gains / "htidkc-authors.yaml")),
    }


def _figures(scores: dict[str, Score]) -> list[Figure]:
    """Return the figures to reach, and the paper's claim with the paper's weights."""
    ours, tuned, weak = scores[OURS], scores[TUNED], scores[PAPER[2]]
    theirs = scores[PAPER[0]]
    part = {name: score.parts.mean(axis=0) for name, score in scores.items()}
    ratio = float(part[OURS][1] / part[PAPER[2]][1])
    own = float(part[PAPER[0]][1] / part[PAPER[2]][1])
    figures = [
        Figure("Part 2, ours / the paper's HTIDKC", ratio, "", Goal("<=", _BETTER), "0.58"),
        Figure("Part 2, the authors' weights / the paper's HTIDKC", own, "", None, "0.58"),
    ]
    for i in (0, 1):
        peer = Peer(TUNED, float(part[TUNED][i]))
        limit = Goal("<=", float(part[TUNED][i]))
        figures.append(Figure(f"Part {i + 1}, ours", float(part[OURS][i]), "", limit, "", peer))
    seen = f"Part 1 until the horizon sees the step, at {HALF - SEEN:g} s"
    figures.append(Figure(f"{seen}, ours", ours.blind, "", None, "", Peer(TUNED, tuned.blind)))
    for i in (0, 1):
        peer = Peer(TUNED, float(part[TUNED][i]))
        figures.append(Figure(f"Part {i + 1}, {WPT}", float(part[WPT][i]), "", None, "", peer))
    figures += [
        Figure(
            "EE error, mean", ours.mean, "mm", Goal("<=", tuned.mean), "", Peer(TUNED, tuned.mean)
        ),
        Figure(
            "EE error, peak", ours.peak, "mm", Goal("<=", tuned.peak), "", Peer(TUNED, tuned.peak)
        ),
        Figure("EE error of the authors' weights, mean", theirs.mean, "mm", None, "", None),
        Figure("EE error of the paper's HTIDKC, mean", weak.mean, "mm"),
    ]
    foresight = float(part[OURS][1] / part[WPT][1])
    figures.append(Figure("Part 2, HTMPC / HTMPC_WPT", foresight, "", None, "slightly below 1"))
    failed = float(sum(score.failures for score in scores.values()))
    return [*figures, zero("Failed solves of all controllers", failed)]


def _row(name: str, score: Score) -> dict[str, Cell]:
    """Return the row of one controller."""
    settled = [wave.settled for wave in score.waves]
    parts = score.parts.mean(axis=0)
    return {
        "controller": name,
        "part 1": float(parts[0]),
        "part 2": float(parts[1]),
        "part 1 - optimum": score.left,
        "part 2 m": score.metres,
        "EE mm": score.mean,
        "EE peak mm": score.peak,
        "within 5 % in 1": sum(first is not None for first, _ in settled),
        "in 2": sum(second is not None for _, second in settled),
        "failed": score.failures,
    }


def _case_rows(scores: dict[str, Score], peaks: Matrix) -> list[tuple[Cell, ...]]:
    """Return a row for each case and controller."""
    return [
        (
            i,
            *(float(value) for value in peak),
            name,
            *(float(value) for value in score.parts[i]),
            float(score.waves[i].tool.mean()),
            float(score.waves[i].tool.max()),
        )
        for i, peak in enumerate(peaks)
        for name, score in scores.items()
    ]


def _second(wave: Wave) -> float:
    """Return the mean over part 2 of the base's distance from home [m]."""
    inside = wave.times >= HALF
    return float(np.linalg.norm(wave.path[inside], axis=1).mean())


def _draw(scores: dict[str, Score], peaks: Matrix, tool: Vector, out: Path) -> None:
    """Write Figs. 3, 4, 6 and 7; the example is the paper's, or the first case."""
    example = int(np.argmin(np.linalg.norm(peaks - EXAMPLE, axis=1)))
    off = peaks - tool[:2]
    directions = np.arctan2(off[:, 1], off[:, 0])
    draw_paths(scores[OURS].waves, peaks, tool, out / "fig3.png")
    one = {name: score.waves[example] for name, score in scores.items()}
    draw_waves(one, HALF, out / "fig4.png")
    draw_violins({name: score.parts for name, score in scores.items()}, out / "fig6.png")
    shown = (OURS, WPT, TUNED, PAPER[2])
    maps = {name: scores[name].parts[:, 1] for name in shown}
    draw_radial(maps, directions, out / "fig7.png")


EXPERIMENT = Experiment("random square waves, Figs. 3, 4, 6 and 7 of H", "cases", CASES, run)
