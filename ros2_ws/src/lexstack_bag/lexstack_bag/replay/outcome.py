"""What a replay found: where chi, or a plan, is another than the recorded one, and by how much."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lexstack.robots import Team
from lexstack.types import Matrix, Vector
from lexstack_bag.run.run import Integers


@dataclass(frozen=True, slots=True)
class Joint:
    """One entry of chi."""

    name: str  # robot/joint
    unit: str  # of its velocity


def joints_of(team: Team) -> tuple[Joint, ...]:
    """Return names and units of all joints, in the order of chi."""
    return tuple(
        Joint(f"{robot.name}/{joint}", "m/s" if slides else "rad/s")
        for robot in team.robots
        for joint, slides in zip(robot.joints, robot.prismatic, strict=True)
    )


@dataclass(frozen=True, slots=True)
class Outcome:
    """One node's chi, or its plans, recorded and replayed, tick by tick.

    Attributes:
        node: whose it is, by its topic: robot_a, robot_b, htmpc.
        joints: names and units, n of them.
        tick: shape (T,).
        stamp: simulated time, shape (T,) [s].
        recorded: shape (T, n); rows of nan: there was none.
        replayed: shape (T, n).
        what: chi, or plan: then n are the joints at all states of a horizon.
    """

    node: str
    joints: tuple[Joint, ...]
    tick: Integers
    stamp: Vector
    recorded: Matrix
    replayed: Matrix
    what: str = "chi"

    @property
    def different(self) -> NDArray[np.bool_]:
        """Which ticks have another chi, bit by bit, shape (T,)."""
        same = self.recorded.view(np.int64) == self.replayed.view(np.int64)
        both_none = np.isnan(self.recorded) & np.isnan(self.replayed)
        return np.asarray(~(same | both_none).all(axis=1))

    @property
    def first(self) -> int | None:
        """The first tick with another chi, or None."""
        places = np.flatnonzero(self.different)
        return int(self.tick[places[0]]) if places.size else None

    @property
    def identical(self) -> bool:
        """Whether no tick differs."""
        return self.first is None

    def largest(self) -> Iterator[tuple[float, str, str, float]]:
        """Yield by unit: the largest difference, its unit, its joint, its time [s]."""
        apart = np.abs(self.replayed - self.recorded)
        apart[~np.isfinite(apart)] = 0.0
        for unit in dict.fromkeys(joint.unit for joint in self.joints):
            mine = np.array([joint.unit == unit for joint in self.joints])
            if not apart.size or not mine.any():
                continue
            part = np.where(mine, apart, -1.0)
            tick, place = np.unravel_index(int(part.argmax()), part.shape)
            yield float(part.max()), unit, self.joints[place].name, float(self.stamp[tick])

    def plain(self) -> dict[str, Any]:
        """Return the figures of ``replay.json``."""
        return {
            "node": self.node,
            "ticks": len(self.tick),
            "identical": self.identical,
            "first_different_tick": self.first,
            "different_ticks": int(np.count_nonzero(self.different)),
            "largest": [
                {"difference": value, "unit": unit, "joint": joint, "time_s": time}
                for value, unit, joint, time in self.largest()
            ],
        }

    def line(self) -> str:
        """Return the finding in one line."""
        count = len(self.tick)
        if not count:
            return f"{self.node}: no {self.what} recorded"
        if self.identical:
            return f"{self.node}: identical over all {count} ticks"
        at = float(self.stamp[np.flatnonzero(self.different)[0]])
        most = "; ".join(
            f"{value:.3g} {unit} ({joint}, {time:.2f} s)"
            for value, unit, joint, time in self.largest()
        )
        return (
            f"{self.node}: differs first at tick {self.first} ({at:.2f} s), in "
            f"{int(np.count_nonzero(self.different))} of {count} ticks; at most {most}"
        )
