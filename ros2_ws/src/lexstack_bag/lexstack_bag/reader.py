"""Reads a bag, with the definitions that it carries itself, into a Run."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from mcap.records import Schema
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from lexstack_bag.columns import one_per_tick, seconds, stream
from lexstack_bag.container import Container, RawMessage, find_files
from lexstack_bag.errors import BagError
from lexstack_bag.loss import LossCounter
from lexstack_bag.run import ChiStream, PlantStream, Run, Target, TransitionStream
from lexstack_bag.writer import CLOSING_RECORD, SCENARIO_RECORD
from lexstack_core.config.resolved import ResolvedScenario
from lexstack_core.errors import ConfigurationError
from lexstack_core.model import Team

PLANT_STATE = "/plant/state"
TRANSITION = "/robot_a/transition"
NEEDED = (PLANT_STATE, "/robot_a/chi", TRANSITION)
"""Topics without which there is nothing to analyse."""

_TARGETS = {"ee_target": "ee", "base_target": "base"}

Progress = Callable[[str], None]


def read_run(path: Path, progress: Progress = lambda _line: None) -> Run:
    """Return the run in a bag.

    Args:
        path: a run folder, a bag folder or an .mcap file.
        progress: told what happens, in single lines.

    Raises:
        BagError: nothing there, not readable, or not recorded by lexstack.
    """
    files = find_files(path)
    container = Container(files)
    collector = _Collector()
    for message in container.messages():
        collector.add(message)
    total = sum(collector.counts.values())
    progress(f"read {total} messages of {len(collector.counts)} topics from {files[0].name}")
    return _assemble(files[0], container, collector)


class _Collector:
    """Sorts a bag's messages: decodes what analysis needs, counts all of them."""

    def __init__(self) -> None:
        """Start empty."""
        self.counts: dict[str, int] = defaultdict(int)
        self.losses: dict[str, LossCounter] = defaultdict(LossCounter)
        self.decoded: dict[str, list[Any]] = defaultdict(list)
        self.targets: list[Target] = []
        self._decoders: dict[str, Callable[[bytes], Any]] = {}
        self._now = 0.0  # s, stamp of the last plant state

    def add(self, message: RawMessage) -> None:
        """Take one message."""
        topic = message.topic
        self.counts[topic] += 1
        if message.sequence:
            self.losses[topic].see(message.sequence)
        robot, _, name = topic[1:].partition("/")
        if topic in (PLANT_STATE, TRANSITION) or name == "chi":
            value = self._decode(message)
            self.decoded[topic].append(value)
            if topic == PLANT_STATE:
                self._now = seconds(value.header.stamp)
        elif name in _TARGETS:
            target = self._target(robot, name, self._decode(message))
            if np.isfinite([*target.position, *target.quaternion]).all():
                self.targets.append(target)

    def _decode(self, message: RawMessage) -> Any:
        """Return a message's content."""
        name = message.schema.name
        if name not in self._decoders:
            self._decoders[name] = _decoder(message.schema)
        try:
            return self._decoders[name](message.data)
        except Exception as error:  # the decoder is generated and raises whatever it meets
            raise BagError(f"{message.topic}: a message cannot be decoded: {error}") from error

    def _target(self, robot: str, name: str, value: Any) -> Target:
        """Return a reference: it holds from its stamp on, or at once if that has passed."""
        pose = value.pose
        return Target(
            robot,
            _TARGETS[name],  # type: ignore[arg-type]
            max(seconds(value.header.stamp), self._now),
            np.array([pose.position.x, pose.position.y, pose.position.z]),
            np.array(
                [pose.orientation.x, pose.orientation.y, pose.orientation.z, pose.orientation.w]
            ),
        )


def _decoder(schema: Schema) -> Callable[[bytes], Any]:
    """Return a function from CDR to a message of a bag's own definition."""
    if schema.encoding != "ros2msg":
        raise BagError(f"{schema.name}: definitions in {schema.encoding!r} are not supported")
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(schema.data.decode(), schema.name))
    return lambda data: store.deserialize_cdr(data, schema.name)


def _assemble(path: Path, container: Container, collector: _Collector) -> Run:
    """Return the Run of all that was collected; raises BagError for a foreign bag."""
    facts = dict(container.metadata.get(SCENARIO_RECORD, {}))
    if "scenario" not in facts:
        raise BagError(f"{path}: not a lexstack bag (no Metadata record {SCENARIO_RECORD!r})")
    try:
        resolved = ResolvedScenario.from_yaml(facts.pop("scenario"), f"{path}: scenario")
    except ConfigurationError as error:
        raise BagError(str(error)) from error
    if not collector.decoded[PLANT_STATE]:
        raise BagError(f"{path}: holds no message of {PLANT_STATE}")
    n = Team.from_scenario(resolved).n
    chi = {
        robot: stream(ChiStream, one_per_tick(collector.decoded[f"/{robot}/chi"]), n)
        for robot in resolved.scenario.robots
    }
    return Run(
        path,
        facts,
        resolved,
        stream(PlantStream, one_per_tick(collector.decoded[PLANT_STATE]), n),
        chi,
        stream(TransitionStream, collector.decoded[TRANSITION], n),
        tuple(collector.targets),
        dict(sorted(collector.counts.items())),
        _lost(container, collector),
        container.complete,
    )


def _lost(container: Container, collector: _Collector) -> int:
    """Return what the recorder counted, or without its closing word the gaps in the bag."""
    word = container.metadata.get(CLOSING_RECORD, {}).get("recorder_lost")
    return int(word) if word else sum(counter.lost for counter in collector.losses.values())
