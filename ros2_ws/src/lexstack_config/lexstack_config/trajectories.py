"""The schema of references that move, in the events of a scenario."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated

from lexstack.errors import ConfigurationError
from lexstack.options import Finite, Finite3, NotNegative, Positive, Range

Quaternion = tuple[Finite, Finite, Finite, Finite]
_UNIT = 1e-3  # how far a quaternion's norm may be from 1
_FASTEST = 100.0  # Hz


@dataclass(frozen=True, slots=True)
class WayConfig:
    """Poses of a frame at times, in the world."""

    times: tuple[NotNegative, ...]  # s after the event
    positions: tuple[Finite3, ...]  # m, as many as times
    orientations: tuple[Quaternion, ...]  # x, y, z, w; as many as times, or one for all
    frame: str = "tool"  # its name: tool, one of the robot's tools, or a link or joint

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for counts that differ, times in disorder, no quaternion."""
        check_times(self.times, where, positions=len(self.positions))
        if len(self.orientations) not in (1, len(self.times)):
            raise ConfigurationError(
                f"{where}: orientations: expected 1 or {len(self.times)}, "
                f"got {len(self.orientations)}"
            )
        for k, quaternion in enumerate(self.orientations):
            norm = sum(value * value for value in quaternion) ** 0.5
            if abs(norm - 1.0) > _UNIT:
                raise ConfigurationError(
                    f"{where}: orientations[{k}]: norm must be 1, got {norm:.4f}"
                )


@dataclass(frozen=True, slots=True)
class PathConfig:
    """Places of a base, at times or as fast as ``references`` of the scenario say."""

    places: tuple[Finite3, ...]  # x [m], y [m], yaw [rad]
    times: tuple[NotNegative, ...] = ()  # s after the event; none: at the speed of a path

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for counts that differ, or times in disorder."""
        if self.times:
            check_times(self.times, where, places=len(self.places))


@dataclass(frozen=True, slots=True)
class PostureWayConfig:
    """Positions of an arm's joints at times."""

    times: tuple[NotNegative, ...]  # s after the event
    positions: tuple[tuple[Finite, ...], ...]  # rad or m, all joints of the arm in their order

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for counts that differ, or times in disorder."""
        check_times(self.times, where, positions=len(self.positions))


@dataclass(frozen=True, slots=True)
class TwistEventConfig:
    """A twist of a tool for a while, sent again and again as a joystick does."""

    duration: Positive  # s
    linear: Finite3 = (0.0, 0.0, 0.0)  # m/s, axes of the world
    angular: Finite3 = (0.0, 0.0, 0.0)  # rad/s, axes of the world
    rate: Annotated[Positive, Range(most=_FASTEST)] = 20.0  # Hz, messages per simulated second


def check_times(times: tuple[float, ...], where: str, **counts: int) -> None:
    """Raise ConfigurationError for times in disorder, or others than as many as something else."""
    for name, count in counts.items():
        if count != len(times):
            raise ConfigurationError(f"{where}: {name}: expected {len(times)}, as many as times")
    for k, (one, other) in enumerate(pairwise(times), start=1):
        if other <= one:
            raise ConfigurationError(f"{where}: times[{k}]: {other:g} s is not after {one:g} s")
