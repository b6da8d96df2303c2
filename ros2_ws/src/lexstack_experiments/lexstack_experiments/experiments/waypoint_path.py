"""Two waypoints of the end effector, the first at several heights: Fig. 8 of H.

The first waypoint lies beside the straight line from home to where the base has the second one in
reach. HT-Arch gets that line alone, and leaves it as far as the first waypoint demands. ST-Arch
needs a place for its base from which the arm alone reaches the first waypoint: at a predefined
distance from it, as in H, or, stronger than H's baseline, at the largest distance that the height
allows. Of all such places it gets the one with the shortest way.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lexstack.mpc import HT_ARCH, ST_ARCH, Htmpc, SequenceTask
from lexstack.types import Matrix, Vector
from lexstack_config.resolved import load_htmpc
from lexstack_experiments.experiment import Experiment, Options
from lexstack_experiments.experiments.htmpc_pictures import draw_tracks_from_above
from lexstack_experiments.experiments.htmpc_runs import Setting, farthest, setting
from lexstack_experiments.experiments.htmpc_sequences import Trip, length, travel
from lexstack_experiments.measuring import largest
from lexstack_experiments.results import Cell, Figure, Goal, Peer, Results, Table, zero

NAME = "waypoint-path"
HEIGHTS = (0.8, 0.4, 1.2, 1.6, 2.0)  # m, of the first waypoint; 0.8 m is the paper's
FIRST = (2.5, 2.5)  # m, x and y of the first waypoint
SECOND = (6.0, 0.0, 0.8)  # m, the second waypoint
STATION = (5.0, 0.0)  # m, where the base has the second waypoint in reach
PREDEFINED = 0.8  # m, from the base to the first waypoint
_SPEED = 0.5  # m/s, of both plans
_LONGEST = 60.0  # s
_MARGIN = 0.05  # m, that the arm of ST-Arch keeps to its reach
_DIRECTIONS = 3600

_COLUMNS = (
    "height m", "HT path m", "ST path m", "ST by height m", "least m", "HT / ST", "HT / least",
    "HT s", "ST s", "ST by height s", "HT nearest m", "reach m", "ST distances m",
)  # fmt: skip
_NOTES = (
    "path: of the base, until the second waypoint is done; ST: base at 0.8 m from the waypoint;",
    "ST by height: as far from it as the arm allows there. least: the shortest line that comes as",
    "near to the waypoint as the reach at that height, with the best yaw, demands.",
)


@dataclass(frozen=True, slots=True, eq=False)
class Case:
    """One height: the trips, and what geometry alone says.

    Attributes:
        height: of the first waypoint [m].
        reach: of the tool from the base at that height, horizontally, with the best yaw [m].
        least: the shortest way [m].
        distances: from the arm's mount to the waypoint at the places of ST-Arch [m].
        trips: HT-Arch, ST-Arch, and ST-Arch with the distance by height.
    """

    height: float
    reach: float
    least: float
    distances: tuple[float, float]
    trips: tuple[Trip, Trip, Trip]

    @property
    def lengths(self) -> tuple[float, ...]:
        """Of the paths until the second waypoint is done [m]."""
        return tuple(length(trip.until("second")) for trip in self.trips)

    @property
    def nearest(self) -> float:
        """How near the base of HT-Arch came to the first waypoint [m]."""
        return float(np.linalg.norm(self.trips[0].path - FIRST, axis=1).min())


def run(options: Options) -> Results:
    """Run the architectures at every height."""
    at = setting(options.config)
    optimiser = Htmpc(at.robot, load_htmpc(options.config / "htmpc" / "lexstack.yaml"), ())
    cases = []
    for height in HEIGHTS[: options.cases]:
        cases.append(case(at, optimiser, height))
        told = ", ".join(f"{value:.2f}" for value in cases[-1].lengths)
        options.say(f"first waypoint at {height} m: paths of {told} m")
    draw_tracks_from_above(
        _paths(cases),
        {"waypoint 1": FIRST, "waypoint 2": SECOND[:2], "station": STATION},
        options.out / "fig8.png",
    )
    return options.results(
        NAME,
        _figures(cases),
        Table(_COLUMNS, [_row(case) for case in cases]),
        {"first_m": FIRST, "second_m": SECOND, "station_m": STATION, "speed_m_s": _SPEED},
        _NOTES,
    )


def case(at: Setting, optimiser: Htmpc, height: float) -> Case:
    """Run one height."""
    reach = farthest(at.robot, at.home, height)
    mount = np.array(at.robot.config.arm.mount.xyz[:2])
    # The base of ST-Arch keeps its yaw of zero: what counts is the distance from the mount.
    distances = (PREDEFINED, reach - float(np.linalg.norm(mount)) - _MARGIN)
    first = SequenceTask("first", "ee_position", ((*FIRST, height),), _SPEED, dwell=1.0)
    go = SequenceTask("go", "base_position", (STATION,), _SPEED, tolerance=0.05)
    second = SequenceTask("second", "ee_position", (SECOND,), _SPEED, dwell=1.0)
    stay = SequenceTask("stay", "base_position", (STATION,), tolerance=0.1)
    tasks = (first, go, second, stay)
    trips = [travel(optimiser, at.home, tasks, HT_ARCH, _LONGEST)]
    for distance in distances:
        place = through(np.array(FIRST) - mount, distance)
        via = SequenceTask("via", "base_position", (tuple(place),), _SPEED, tolerance=0.05)
        trips.append(travel(optimiser, at.home, (via, *tasks), ST_ARCH, _LONGEST))
    home = np.zeros(2)
    least = length((home, through(np.array(FIRST), reach), np.array(STATION)))
    return Case(height, reach, least, distances, (trips[0], trips[1], trips[2]))


def through(center: Vector, radius: float) -> Vector:
    """Return the place at most ``radius`` from a centre with the shortest way home to station."""
    angles = np.linspace(-np.pi, np.pi, _DIRECTIONS, endpoint=False)
    places = center + radius * np.column_stack((np.cos(angles), np.sin(angles)))
    ways = np.linalg.norm(places, axis=1) + np.linalg.norm(places - STATION, axis=1)
    return np.asarray(places[ways.argmin()])


def _figures(cases: list[Case]) -> list[Figure]:
    """Return the figures to reach; where not all was done there is none."""
    complete = all(trip.complete for case in cases for trip in case.trips)
    ratios = [case.lengths[0] / case.lengths[1] for case in cases] if complete else []
    tuned = [case.lengths[0] / case.lengths[2] for case in cases] if complete else []
    least = [case.lengths[0] / case.least for case in cases] if complete else []
    spare = [case.nearest / case.reach for case in cases]
    failed = sum(trip.record.failures for case in cases for trip in case.trips)
    undone = sum(not trip.complete for case in cases for trip in case.trips)
    return [
        Figure("Path HT / ST, longest of all heights", largest(ratios), "", Goal("<=", 1.0), "< 1"),
        Figure("Path HT / ST by height, longest", largest(tuned)),
        Figure("Path HT / least, longest", largest(least)),
        Figure(
            "Nearest to the first waypoint / reach, least of all heights",
            min(spare), "", None, "just reachable",
            Peer("ST-Arch", PREDEFINED / max(case.reach for case in cases)),
        ),
        zero("Trips that were not completed", float(undone)),
        zero("Failed solves", float(failed)),
    ]  # fmt: skip


def _row(case: Case) -> tuple[Cell, ...]:
    """Return the row of one height."""
    if not all(trip.complete for trip in case.trips):
        return (case.height, *(None,) * (len(_COLUMNS) - 1))
    ht, st, tuned = case.lengths
    seconds = (trip.done["second"] for trip in case.trips)
    places = " and ".join(f"{distance:.2f}" for distance in case.distances)
    return (
        case.height, ht, st, tuned, case.least, ht / st, ht / case.least, *seconds,
        case.nearest, case.reach, places,
    )  # fmt: skip


def _paths(cases: list[Case]) -> dict[str, Matrix]:
    """Return the paths to draw, by name: HT-Arch at every height, ST-Arch as it is at the first."""
    paths = {f"HT, {case.height} m": case.trips[0].path for case in cases}
    paths["ST, 0.8 m off"] = cases[0].trips[1].path
    return paths


EXPERIMENT = Experiment(
    "two waypoints, HT-Arch and ST-Arch, Fig. 8 of H", "heights", len(HEIGHTS), run
)
