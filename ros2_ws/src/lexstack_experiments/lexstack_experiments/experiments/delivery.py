"""Deliveries to three people, red, blue and yellow, four rounds: HT-Arch and ST-Arch, Fig. 9 of H.

Both architectures get the same plans: straight lines for the base to a station before each person,
straight lines for the tool to where the person takes or gives something, and the same rules for
when a task is done. H does not print where its people are; here they sit around a small table, and
in a second layout they stand around the robot.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lexstack.mpc import Htmpc, SequenceTask
from lexstack.types import Matrix
from lexstack_config.resolved import load_htmpc
from lexstack_experiments.experiment import Experiment, Options
from lexstack_experiments.experiments.htmpc_pictures import draw_deliveries
from lexstack_experiments.experiments.htmpc_runs import Setting, setting
from lexstack_experiments.experiments.htmpc_sequences import ARCHITECTURES, Trip, length, travel
from lexstack_experiments.results import Cell, Figure, Goal, Results, Table, zero

NAME = "delivery"
ROUNDS = 4
PEOPLE = ("red", "blue", "yellow")
WEIGHTS = ("lexstack", "authors")
DWELL, TOLERANCE = 1.0, 0.05  # s, m: the authors' rule for their demonstration
_BASE_SPEED = 0.5  # m/s, the authors'
_LONGEST = 60.0  # s per round
_RATIO = 2.3  # H, Sec. V-D

_COLUMNS = (
    "layout", "tool m/s", "weights", "HT s", "ST s", "ST / HT", "HT path m", "ST path m",
    "line m", "HT base s", "HT tool s", "ST base s", "ST tool s", "HT EE mm", "failed",
)  # fmt: skip
_NOTES = (
    "line: of the base's plan from station to station; at 0.5 m/s no architecture is faster.",
    "base s, tool s: while a task of the base, or one of the tool, was the first one.",
    "EE mm: the tool's mean distance from its place while it is to dwell there, HT-Arch.",
)


@dataclass(frozen=True, slots=True, eq=False)
class Layout:
    """Where people and stations are.

    Attributes:
        name: in words.
        stations: of the base, shape (3, 2), m.
        places: of the tool, shape (3, 3), m.
        speed: of the tool's plan [m/s]; None: it gets its place at once.
    """

    name: str
    stations: Matrix
    places: Matrix
    speed: float | None

    def tasks(self, rounds: int) -> tuple[SequenceTask, ...]:
        """Return the sequence: for each person a line of the base, then one of the tool."""
        return tuple(
            task
            for k in range(rounds)
            for person, station, place in zip(PEOPLE, self.stations, self.places, strict=True)
            for task in (
                SequenceTask(
                    f"{person} go {k}",
                    "base_position",
                    (tuple(station),),
                    _BASE_SPEED,
                    tolerance=TOLERANCE,
                ),
                SequenceTask(
                    f"{person} give {k}",
                    "ee_position",
                    (tuple(place),),
                    self.speed,
                    tolerance=TOLERANCE,
                    dwell=DWELL,
                ),
            )
        )

    def line(self, rounds: int) -> float:
        """Return the length of the base's plan [m]."""
        return length([np.zeros(2), *(station for _ in range(rounds) for station in self.stations)])


@dataclass(frozen=True, slots=True, eq=False)
class Case:
    """One layout with one set of weights: a trip for each architecture."""

    layout: Layout
    weights: str
    trips: dict[str, Trip]

    @property
    def ratio(self) -> float | None:
        """Time of ST-Arch over that of HT-Arch, None if one did not complete its sequence."""
        ht, st = (self.trips[name].seconds for name in ARCHITECTURES)
        return None if ht is None or st is None else st / ht


def layouts() -> tuple[Layout, ...]:
    """Return both layouts, the first one with two speeds of the tool."""
    table, around = _around(60.0), _around(60.0, 180.0)
    center = np.array([2.0, 0.0])
    height = np.full((3, 1), 1.0)
    places = np.hstack((center + 0.3 * table, height))
    stations = center + 1.4 * table
    standing = np.hstack((2.4 * around, height))
    return (
        Layout("table", stations, places, 0.25),
        Layout("table", stations, places, None),
        Layout("half circle", 1.3 * around, standing, 0.25),
        Layout("half circle", 1.3 * around, standing, None),
    )


def _around(step: float, turned: float = 0.0) -> Matrix:
    """Return three directions, shape (3, 2): towards home and a step [deg] to either side."""
    angles = np.radians(180.0 - turned + step * np.array((-1.0, 0.0, 1.0)))
    return np.column_stack((np.cos(angles), np.sin(angles)))


def run(options: Options) -> Results:
    """Run both architectures in every layout with both sets of weights."""
    at = setting(options.config)
    optimisers = {
        name: Htmpc(at.robot, load_htmpc(options.config / "htmpc" / f"{name}.yaml"), ())
        for name in WEIGHTS
    }
    cases = []
    for layout in layouts():
        for weights, optimiser in optimisers.items():
            cases.append(_case(at, optimiser, layout, weights, options.cases))
            told = [f"{name} {trip.seconds or 0.0:.1f} s" for name, trip in cases[-1].trips.items()]
            options.say(f"{layout.name}, tool {layout.speed}, {weights}: {', '.join(told)}")
    _draw(cases[0], options.out / "fig9.png")
    return options.results(
        NAME,
        _figures(cases),
        Table(_COLUMNS, [_row(case, options.cases) for case in cases]),
        {
            "base_m_s": _BASE_SPEED,
            "dwell_s": DWELL,
            "tolerance_m": TOLERANCE,
            "table_stations_m": cases[0].layout.stations.tolist(),
            "table_places_m": cases[0].layout.places.tolist(),
        },
        _NOTES,
    )


def _case(at: Setting, optimiser: Htmpc, layout: Layout, weights: str, rounds: int) -> Case:
    """Run both architectures."""
    tasks, longest = layout.tasks(rounds), _LONGEST * rounds
    trips = {
        name: travel(optimiser, at.home, tasks, architecture, longest)
        for name, architecture in ARCHITECTURES.items()
    }
    return Case(layout, weights, trips)


def _figures(cases: Sequence[Case]) -> list[Figure]:
    """Return the figures to reach, first that of our weights at the table."""
    figures = []
    for i, case in enumerate(cases):
        tool = "at once" if case.layout.speed is None else f"at {case.layout.speed} m/s"
        name = f"ST / HT, {case.layout.name}, tool {tool}, {case.weights}"
        goal = None if i else Goal(">=", _RATIO)
        figures.append(Figure(name, case.ratio, "", goal, "2.3"))
    trips = [trip for case in cases for trip in case.trips.values()]
    undone = float(sum(not trip.complete for trip in trips))
    failed = float(sum(trip.record.failures for trip in trips))
    return [
        *figures,
        zero("Sequences that were not completed", undone),
        zero("Failed solves", failed),
    ]


def _row(case: Case, rounds: int) -> tuple[Cell, ...]:
    """Return the row of one case."""
    ht, st = case.trips.values()
    return (
        case.layout.name, case.layout.speed, case.weights, ht.seconds, st.seconds, case.ratio,
        ht.length, st.length, case.layout.line(rounds), *_shares(ht), *_shares(st),
        _while_dwelling(case), ht.record.failures + st.record.failures,
    )  # fmt: skip


def _shares(trip: Trip) -> tuple[float, float]:
    """Return how long tasks of the base, and those of the tool, were the first ones [s]."""
    times = [sum(t for name, t in trip.durations.items() if word in name) for word in ("go", "giv")]
    return times[0], times[1]


def _while_dwelling(case: Case) -> float:
    """Return the mean distance of the tool from its place in the last second of each visit [mm]."""
    trip = case.trips["HT-Arch"]
    found = []
    for name, end in trip.done.items():
        person, what, _ = name.split()
        if what == "give":
            times = trip.record.times
            inside = (times > end - DWELL - 1e-9) & (times <= end + 1e-9)
            found.append(trip.off(case.layout.places[PEOPLE.index(person)])[inside].mean())
    return 1e3 * float(np.mean(found))


def _draw(case: Case, path: Path) -> None:
    """Write Fig. 9: paths from above, and which task was the first one when."""
    named = zip(PEOPLE, case.layout.stations, case.layout.places, strict=True)
    people = {name: (station, place[:2]) for name, station, place in named}
    times = {name: trip.done for name, trip in case.trips.items()}
    paths = {name: trip.path for name, trip in case.trips.items()}
    draw_deliveries(paths, people, times, path)


EXPERIMENT = Experiment(
    "deliveries to three people, HT-Arch and ST-Arch, Fig. 9 of H", "rounds", ROUNDS, run
)
