"""Changes that nobody foretells: H, Sec. V-D, and its video, on random cases.

The robot brings its tool to a person who takes what it holds at an unknown time; then it goes to
the next person, further away than the arm reaches. In each case one of three things happens:

- ``held``: nothing else. The base goes on towards the next person, and is to stop before the tool
  is pulled away.
- ``next moves``: while the tool is held, the next person, station and place, moves.
- ``jump``: after the tool has arrived, its own place jumps.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from lexstack.mpc import HT_ARCH, Htmpc, HtmpcConfig, RobotPose, SequenceTask
from lexstack.mpc import Sequence as TaskSequence
from lexstack.types import Vector
from lexstack_config.resolved import load_htmpc
from lexstack_experiments.experiment import Experiment, Options
from lexstack_experiments.experiments.htmpc_pictures import draw_reactions
from lexstack_experiments.experiments.htmpc_runs import Setting, setting
from lexstack_experiments.experiments.htmpc_sequences import Event, Trip, travel
from lexstack_experiments.measuring import after_last, largest
from lexstack_experiments.results import Cell, Figure, Goal, Results, Table, zero

Kind = Literal["held", "next moves", "jump"]

NAME = "reactivity"
KINDS: tuple[Kind, ...] = ("held", "next moves", "jump")
CASES = 30
NEAR = 0.02  # m: a place that is reached
_SPEED = 0.5  # m/s, of the base's plan
_PLACE = (1.9, 0.6, 0.9)  # m, where the first person takes something
_STATION, _NEXT = (4.5, -1.0), (5.4, -0.6, 1.0)  # m, of the next person
_ARRIVED = 3.0  # s, when the tool is at its place in every case
_CHANGE = (
    6.0,
    9.0,
)  # s, when something moves: the base has left by then
_RELEASE = (16.0, 22.0)  # s
_LONGEST = 60.0  # s
_STILL = 0.02  # m/s: a base that stands
_LATE = 1.0  # s, before a release: over so long the base is to stand

_COLUMNS = (
    "case", "what", "change s", "moved m", "released s", "EE held mm", "row held mm",
    "base stood s", "base m/s", "arm / reach", "back within 20 mm s", "next reached s", "failed",
)  # fmt: skip
_NOTES = (
    "EE held, row held: the tool's largest distance from its place, and largest error of a row",
    "(what delta bounds), from its arrival to the release, without the 20 mm way after a jump.",
    "base stood: from when on until the release; base: its largest speed in the last second of it.",
    "back: from the jump until the tool is within 20 mm for good; next: from the release.",
)


@dataclass(frozen=True, slots=True, eq=False)
class Case:
    """What happens in one case.

    Attributes:
        kind: see the module.
        change: when something moves [s], None where nothing does.
        moved: by how much, shape (3,), m.
        released: when the first person takes it [s].
    """

    kind: Kind
    change: float | None
    moved: Vector
    released: float

    @property
    def event(self) -> Event:
        """What happens to the sequence, once each."""
        told: set[str] = set()

        def event(sequence: TaskSequence, pose: RobotPose) -> TaskSequence:
            if self.change is not None and pose.stamp >= self.change and "change" not in told:
                told.add("change")
                sequence = self._changed(sequence, pose)
            if pose.stamp >= self.released and "release" not in told:
                told.add("release")
                sequence = sequence.release("give")
            return sequence

        return event

    @property
    def place(self) -> Vector:
        """Where the tool is to be at the release, shape (3,), m."""
        return np.array(_PLACE) + (self.moved if self.kind == "jump" else 0.0)

    @property
    def next_place(self) -> Vector:
        """Where the tool is to be at the end, shape (3,), m."""
        return np.array(_NEXT) + (self.moved if self.kind == "next moves" else 0.0)

    def _changed(self, sequence: TaskSequence, pose: RobotPose) -> TaskSequence:
        """Return the sequence after what moves has moved."""
        if self.kind == "jump":
            return sequence.retarget("give", (tuple(self.place),), pose)
        station = tuple(np.array(_STATION) + self.moved[:2])
        moved = sequence.retarget("go", (station,), pose)
        return moved.retarget("give next", (tuple(self.next_place),), pose)


@dataclass(frozen=True, slots=True, eq=False)
class Reaction:
    """One case as it went, and the largest distance of the tool from the base [m]."""

    case: Case
    trip: Trip
    reach: float

    @property
    def held(self) -> Vector:
        """The tool's error while it is held at its place, shape (k, 3), m."""
        times, off = self.trip.record.times, self.trip.tool - self.case.place
        begin = _ARRIVED
        if self.case.kind == "jump" and self.back is not None and self.case.change is not None:
            begin = self.case.change + self.back + _ARRIVED
        return off[(times >= begin) & (times <= self.case.released + 1e-9)]

    @property
    def stood(self) -> float | None:
        """From when on the base stood until the release [s], None if it did not."""
        times = self.trip.record.times
        until = times <= self.case.released + 1e-9
        first = after_last(self._speeds[until] > _STILL)
        return None if first == until.sum() else float(times[first])

    @property
    def speed(self) -> float:
        """The base's largest speed in the last second before the release [m/s]."""
        times, released = self.trip.record.times, self.case.released
        late = (times >= released - _LATE) & (times <= released + 1e-9)
        return float(self._speeds[late].max())

    @property
    def stretched(self) -> float:
        """The distance of the tool from the base at the release, of the largest one."""
        at = int(np.searchsorted(self.trip.record.times, self.case.released - 1e-9))
        away = np.linalg.norm(self.trip.tool[at, :2] - self.trip.path[at])
        return float(away) / self.reach

    @property
    def back(self) -> float | None:
        """From the jump until the tool is at its new place, until the release [s], else None."""
        change = self.case.change
        if self.case.kind != "jump" or change is None:
            return None
        times = self.trip.record.times
        inside = (times >= change) & (times <= self.case.released + 1e-9)
        first = after_last(self.trip.off(self.case.place)[inside] > NEAR)
        return None if first == inside.sum() else float(times[inside][first] - change)

    @property
    def reached(self) -> float | None:
        """From the release until the next person is served [s]; None if that never was."""
        if not self.trip.complete or self.trip.off(self.case.next_place)[-1] > NEAR:
            return None
        return self.trip.done["give next"] - self.case.released

    @property
    def _speeds(self) -> Vector:
        """Of the base at every state, shape (m,), m/s."""
        return np.asarray(np.linalg.norm(self.trip.record.v[:, :2], axis=1))


def cases(count: int, seed: int) -> Iterator[Case]:
    """Yield random cases, their kinds in turns."""
    rng = np.random.default_rng(seed)
    for i in range(count):
        kind = KINDS[i % len(KINDS)]
        angle, released = rng.uniform(-np.pi, np.pi), rng.uniform(*_RELEASE)
        far = rng.uniform(0.1, 0.4) if kind == "jump" else rng.uniform(0.5, 1.5)
        moved = np.array((far * np.cos(angle), far * np.sin(angle), rng.uniform(-0.2, 0.2)))
        change = None if kind == "held" else float(rng.uniform(*_CHANGE))
        yield Case(kind, change, np.zeros(3) if change is None else moved, float(released))


def react(at: Setting, optimiser: Htmpc, case: Case) -> Reaction:
    """Run one case."""
    tasks = (
        SequenceTask("give", "ee_position", (_PLACE,), tolerance=NEAR, held=True),
        SequenceTask("go", "base_position", (_STATION,), _SPEED, tolerance=0.05),
        SequenceTask("give next", "ee_position", (_NEXT,), tolerance=NEAR, dwell=0.5),
    )
    trip = travel(optimiser, at.home, tasks, HT_ARCH, _LONGEST, case.event)
    return Reaction(case, trip, at.reach)


def run(options: Options) -> Results:
    """Run all cases."""
    at = setting(options.config)
    config = load_htmpc(options.config / "htmpc" / "lexstack.yaml")
    optimiser = Htmpc(at.robot, config, ())
    reactions = []
    for case in cases(options.cases, options.seed):
        reactions.append(react(at, optimiser, case))
        options.say(f"{len(reactions)} of {options.cases}: {case.kind}")
    shown = {reaction.case.kind: reaction for reaction in reversed(reactions)}
    draw_reactions(
        {kind: (r.trip, r.case.place, _events(r.case)) for kind, r in sorted(shown.items())},
        1e3 * config.ee.tolerance,
        options.out / "reactivity.png",
    )
    return options.results(
        NAME,
        _figures(reactions, config),
        Table(_COLUMNS, [_row(i, reaction) for i, reaction in enumerate(reactions)]),
        {"delta_m": config.ee.tolerance, "place_m": _PLACE, "station_m": _STATION, "next_m": _NEXT},
        _NOTES,
    )


def _figures(reactions: list[Reaction], config: HtmpcConfig) -> list[Figure]:
    """Return the figures to reach."""
    delta = 1e3 * config.ee.tolerance
    rows = [1e3 * float(np.abs(reaction.held).max()) for reaction in reactions]
    back = [r.back for r in reactions if r.case.kind == "jump"]
    reached = [reaction.reached for reaction in reactions]
    unserved = sum(time is None for time in (*reached, *back))
    failed = sum(reaction.trip.record.failures for reaction in reactions)
    return [
        Figure("EE error of a row while held, largest", max(rows), "mm", Goal("<=", delta)),
        Figure(
            "Base before the release, fastest", max(reaction.speed for reaction in reactions),
            "m/s", Goal("<=", _STILL), "stops",
        ),
        Figure("Targets not reached", float(unserved), "", Goal("==", 0.0), "all reached"),
        zero("Failed solves", float(failed)),
        *_spread("Jump to back within 20 mm", back),
        *_spread("Release to the next served", reached),
    ]  # fmt: skip


def _spread(title: str, times: list[float | None]) -> list[Figure]:
    """Return the median and the longest of some times; no values where one is missing."""
    known = [time for time in times if time is not None]
    all_of = known if len(known) == len(times) else []
    median = float(np.median(all_of)) if all_of else None
    found = {"median": median, "longest": largest(all_of)}
    return [Figure(f"{title}, {word}", value, "s") for word, value in found.items()]


def _row(i: int, reaction: Reaction) -> tuple[Cell, ...]:
    """Return the row of one case."""
    case, held = reaction.case, 1e3 * reaction.held
    return (
        i, case.kind, case.change, float(np.linalg.norm(case.moved)), case.released,
        float(np.linalg.norm(held, axis=1).max()), float(np.abs(held).max()), reaction.stood,
        reaction.speed, reaction.stretched, reaction.back, reaction.reached,
        reaction.trip.record.failures,
    )  # fmt: skip


def _events(case: Case) -> dict[str, float]:
    """Return what happens when [s], to be marked in the picture."""
    found = {} if case.change is None else {case.kind: case.change}
    return {**found, "release": case.released}


EXPERIMENT = Experiment(
    "held until released, a next target that moves, a present one that jumps", "cases", CASES, run
)
