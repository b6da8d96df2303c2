"""Short runs for system tests, and what their bags hold."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import yaml
from rosbags.highlevel import AnyReader

from lexstack_config.resolved import ResolvedScenario
from support.scenario import SCENARIO, changed


def short_scenario(**values: object) -> ResolvedScenario:
    """Return a run of 4 s with one switch, to reach_base, from 1 s to 2.5 s."""
    events = yaml.safe_load(SCENARIO.read_text(encoding="utf-8"))["events"]
    assert events[0]["switch"] == "reach_base"
    first = changed().scenario.events[0]
    return changed(**{"duration": 4.0, "events": (replace(first, duration=1.5),), **values})


def read(bag: Path, *topics: str) -> dict[str, list]:
    """Return all messages of some topics, in the order of the bag."""
    result: dict[str, list] = {topic: [] for topic in topics}
    with AnyReader([bag]) as reader:
        wanted = [c for c in reader.connections if c.topic in topics]
        for connection, _, data in reader.messages(wanted):
            result[connection.topic].append(reader.deserialize(data, connection.msgtype))
    return result


def transitions(bag: Path) -> list:
    """Return the transitions of every tick, in their order: they stand in the controller's chi."""
    return [each for chi in read(bag, "/robot_a/chi")["/robot_a/chi"] for each in chi.transitions]


def chi_by_tick(bag: Path, topic: str) -> dict[int, bytes]:
    """Return the bits of every chi of a topic, by tick."""
    return {m.tick: np.asarray(m.chi).tobytes() for m in read(bag, topic)[topic]}


def acceleration_ratio(bag: Path, limits: np.ndarray, dt: float) -> float:
    """Return the largest |chi(k) - chi(k-1)| / (dt a_max) over consecutive recorded commands."""
    commands = read(bag, "/robot_a/chi")["/robot_a/chi"]
    chi = np.array([m.chi for m in commands])
    ticks = np.array([m.tick for m in commands])
    steps = np.abs(np.diff(chi, axis=0)) / (dt * limits)
    return float(steps[np.diff(ticks) == 1].max())
