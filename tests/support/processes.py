"""Whole runs for system tests: all processes on a domain of their own, watched from the test."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import rclpy
import yaml
from rclpy.experimental import EventsExecutor
from rclpy.signals import SignalHandlerOptions
from rosbags.highlevel import AnyReader

from lexstack_bringup.domain import own_domain
from lexstack_bringup.player import PLAYER, Player
from lexstack_bringup.processes import bring_up, nodes_of
from lexstack_bringup.supervisor import Supervisor
from lexstack_config.resolved import ResolvedScenario
from lexstack_ros.node.readiness import is_connected
from support.scenario import SCENARIO, changed


def short_scenario(**values: object) -> ResolvedScenario:
    """Return a run of 4 s with one switch, to reach_base, from 1 s to 2.5 s."""
    events = yaml.safe_load(SCENARIO.read_text(encoding="utf-8"))["events"]
    assert events[0]["switch"] == "reach_base"
    first = changed().scenario.events[0]
    return changed(**{"duration": 4.0, "events": (replace_duration(first, 1.5),), **values})


def replace_duration(event, duration):
    """Return an event with another duration of its transition."""
    import dataclasses

    return dataclasses.replace(event, duration=duration)


class Run:
    """All processes of one run, and the player in this one."""

    def __init__(self, resolved: ResolvedScenario, out: Path, supervisor: Supervisor) -> None:
        """Bring everything up."""
        self.out = out
        self.supervisor = supervisor
        self.resolved = resolved
        (out / "scenario.yaml").write_text(resolved.to_yaml(), encoding="utf-8")
        rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
        self.executor = EventsExecutor()
        self.player = Player(resolved, self.executor)
        bring_up(supervisor, out / "scenario.yaml", out / "bag", peers=[PLAYER])
        # All know the player then; the player learns of the last of them a little later.
        end = time.monotonic() + 30.0
        while not is_connected(self.player, nodes_of(resolved.scenario)):
            assert time.monotonic() < end, "the player does not see all nodes"
            self.executor.spin_once(timeout_sec=0.05)

    def process(self, name: str):
        """Return a child's process."""
        return next(c for c in self.supervisor.children if c.name == name).process

    def play(self, watch: Callable[[], None] | None = None) -> None:
        """Play the scenario; ``watch`` may act on the processes meanwhile."""
        self.player.play(watch or self.supervisor.check, 100.0)

    def end(self) -> list[str]:
        """End all processes; return those that had to be killed."""
        return self.supervisor.end()


@contextmanager
def running(resolved: ResolvedScenario, out: Path) -> Iterator[Run]:
    """Yield a run whose processes are up; leave none behind."""
    with own_domain() as domain:
        before = os.environ.get("ROS_DOMAIN_ID")
        os.environ["ROS_DOMAIN_ID"] = str(domain)
        supervisor = Supervisor(out / "logs")
        run = None
        try:
            run = Run(resolved, out, supervisor)
            yield run
        finally:
            supervisor.end()
            if run is not None:
                run.executor.shutdown()
                run.player.destroy_node()
            rclpy.try_shutdown()
            if before is None:
                del os.environ["ROS_DOMAIN_ID"]
            else:
                os.environ["ROS_DOMAIN_ID"] = before


def read(bag: Path, *topics: str) -> dict[str, list]:
    """Return all messages of some topics, in the order of the bag."""
    result: dict[str, list] = {topic: [] for topic in topics}
    with AnyReader([bag]) as reader:
        wanted = [c for c in reader.connections if c.topic in topics]
        for connection, _, data in reader.messages(wanted):
            result[connection.topic].append(reader.deserialize(data, connection.msgtype))
    return result


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
