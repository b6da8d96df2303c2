"""What the references that an event gives are for the library."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

from lexstack.errors import ConfigurationError, InputError, ModelError
from lexstack.references import (
    TOOL,
    Hold,
    Spline,
    Target,
    Twist,
    Waypoints,
    base_spline,
    path_at_speed,
)
from lexstack.robots import Pose, Team, from_quaternion
from lexstack_config.reference_topics import ReferenceTopicsConfig
from lexstack_config.scenario import EventConfig, ScenarioConfig
from lexstack_config.trajectories import PathConfig, PostureWayConfig, TwistEventConfig, WayConfig


def check_trajectories(scenario: ScenarioConfig, team: Team, where: str) -> None:
    """Raise ConfigurationError for a trajectory that cannot be followed; ``where``: the file."""
    for i, event in enumerate(scenario.events):
        for key, robot, make in _trajectories(event, team, scenario.references):
            try:
                make()
            except (InputError, ModelError) as error:
                place = f"{where}: events[{i}].{key}.{team.names[robot]}"
                raise ConfigurationError(f"{place}: {error}") from error


def trajectory_targets(
    event: EventConfig, team: Team, options: ReferenceTopicsConfig
) -> Iterator[Target]:
    """Yield the trajectories that an event begins, and its twists."""
    for _key, _robot, make in _trajectories(event, team, options):
        yield make()
    for name, config in event.ee_twist.items():
        value = np.array((*config.linear, *config.angular))
        limits = options.twist_timeout, options.twist_linear, options.twist_angular
        for at in twist_times(config, event.at):
            yield Target(at, team.index(name), ee=Twist(value, *limits))


def twist_times(config: TwistEventConfig, at: float) -> list[float]:
    """Return when the messages of a twist are due [s], given the time of its event."""
    return [at + k / config.rate for k in range(max(1, round(config.duration * config.rate)))]


def _trajectories(
    event: EventConfig, team: Team, options: ReferenceTopicsConfig
) -> Iterator[tuple[str, int, Callable[[], Target]]]:
    """Yield key, robot and maker of each trajectory of an event."""
    for name, way in event.ee_trajectory.items():
        robot = team.index(name)
        yield "ee_trajectory", robot, partial(way_target, way, team, robot, event.at)
    for name, path in event.base_path.items():
        robot = team.index(name)
        yield "base_path", robot, partial(path_target, path, options, robot, event.at)
    for name, posture in event.posture_trajectory.items():
        robot = team.index(name)
        yield "posture_trajectory", robot, partial(posture_target, posture, team, robot, event.at)


def poses_of(config: WayConfig) -> list[Pose]:
    """Return the poses of a way."""
    turns = [from_quaternion(np.array(q)) for q in config.orientations]
    turns *= len(config.times) if len(turns) == 1 else 1
    return [Pose(np.array(p), r) for p, r in zip(config.positions, turns, strict=True)]


def way_target(config: WayConfig, team: Team, robot: int, at: float) -> Target:
    """Return timed poses of a frame; raises InputError or ModelError where they make no way."""
    if config.frame != TOOL:
        team.robots[robot].frame(config.frame)
    if not config.times:
        return Target(at, robot, ee=Hold(), frame=config.frame)
    poses, first = poses_of(config), config.times[0] or None
    if len(poses) == 1:
        return Target(at, robot, ee=poses[0], frame=config.frame, duration=first)
    way = Waypoints(at + np.array(config.times), tuple(poses))
    return Target(at, robot, ee=way, frame=config.frame, duration=first)


def path_target(
    config: PathConfig, options: ReferenceTopicsConfig, robot: int, at: float
) -> Target:
    """Return the way of a base; raises InputError where places or times make none."""
    places = np.array(config.places)
    if not len(places):
        return Target(at, robot, base=Hold())
    if len(places) == 1:
        return Target(at, robot, base=places[0])
    if not config.times:
        speeds = options.path_speed, options.path_turn
        return Target(at, robot, base=path_at_speed(at, places, *speeds))
    way = base_spline(at + np.array(config.times), places)
    return Target(at, robot, base=way, duration=config.times[0] or None)


def posture_target(config: PostureWayConfig, team: Team, robot: int, at: float) -> Target:
    """Return the way of an arm's joints; raises InputError where it makes none."""
    model = team.robots[robot]
    joints = model.joints[model.arm]
    for k, row in enumerate(config.positions):
        if len(row) != len(joints):
            raise InputError(f"positions[{k}]: expected {len(joints)} values, got {len(row)}")
    if not config.times:
        return Target(at, robot, posture=Hold())
    values = np.array(config.positions)
    lower, upper = model.limits.position_lower[model.arm], model.limits.position_upper[model.arm]
    beyond = np.argwhere((values < lower) | (values > upper))
    if len(beyond):
        k, j = (int(place) for place in beyond[0])
        raise InputError(
            f"positions[{k}]: {joints[j]}: {values[k, j]:g} is outside its limits "
            f"[{lower[j]:g}, {upper[j]:g}]"
        )
    first = config.times[0] or None
    if len(values) == 1:
        return Target(at, robot, posture=values[0], duration=first)
    return Target(at, robot, posture=Spline(at + np.array(config.times), values), duration=first)
