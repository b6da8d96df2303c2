"""A bag of any length, made without a run: two robots at 100 Hz, every topic of a demo.

Messages are made once and then changed where they differ: stamps, ticks, numbers. The solver is
never idle, so the bag is as full as one can be. The motion is a sum of sines; it obeys no
controller.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from lexstack.transition import Phase
from lexstack.types import Vector
from lexstack_bag.run.provenance import run_provenance
from lexstack_bag.storage.container import Progress
from lexstack_bag.storage.definitions import message_definition
from lexstack_bag.storage.metadata import Qos, Topic
from lexstack_bag.storage.writer import BagWriter
from lexstack_bag.topics import COMMAND, PLANT_STATE, SOLUTION, STREAMS, TOOLS, TRANSITION
from lexstack_config.parts import build_team, home_of
from lexstack_config.resolved import ResolvedScenario

_EPOCH = 1_700_000_000_000_000_000  # ns
_SWITCH, _BLEND = 6000, 100  # ticks between two switches, ticks of a blend
_SLOW = 2  # topics for tools come at every second tick
_TICK = 0x1122334455667788  # stands for the tick in a message that is a pattern
_STAMP = struct.Struct("<II")


def write_bag(
    folder: Path, resolved: ResolvedScenario, minutes: float, progress: Progress
) -> dict[str, int]:
    """Write a bag of so many simulated minutes; return its messages by topic."""
    maker = _Maker(resolved)
    ticks = round(minutes * 60.0 * resolved.scenario.rate)
    with BagWriter(folder, run_provenance(resolved)) as writer:
        for topic in maker.topics():
            writer.add_topic(topic)
        numbers = dict.fromkeys((topic.name for topic in maker.topics()), 0)
        now = _EPOCH
        for tick in range(ticks):
            for topic, data in maker.messages(tick):
                now += 100_000
                numbers[topic] += 1
                writer.write(topic, data, now, now - 50_000, numbers[topic])
            progress((tick + 1) / ticks)
        writer.close(dict.fromkeys(numbers, 0))
        return dict(writer.extent.counts)


@dataclass(slots=True)
class _Pattern:
    """A message's bytes, and where in them what changes stands."""

    data: bytearray
    tick: int | None
    vectors: dict[str, int]

    def at(self, stamp: float, tick: int, **vectors: Vector) -> bytes:
        """Return the message of a time [s] and tick, with these numbers."""
        _put_stamp(self.data, stamp)
        if self.tick is not None:
            struct.pack_into("<Q", self.data, self.tick, tick)
        for name, values in vectors.items():
            data, place = values.tobytes(), self.vectors[name]
            self.data[place : place + len(data)] = data
        return bytes(self.data)


class _Maker:
    """Makes the messages of a tick."""

    def __init__(self, resolved: ResolvedScenario) -> None:
        """Prepare the patterns."""
        scenario = resolved.scenario
        self._team = build_team(resolved)
        self._home = home_of(self._team, resolved)
        self._dt = 1.0 / scenario.rate
        self._stacks = [scenario.initial_stack, *[e.switch for e in scenario.events if e.switch]]
        n, names = self._team.n, list(self._team.names)
        phases = np.random.default_rng(0).uniform(0.0, 2.0 * np.pi, n)
        self._phases, self._swing = phases, np.full(n, 0.05)
        rows = {name: np.zeros(n) for name in ("q", "v", "q_star", "command")}
        self._plant = self._pattern("lexstack_interfaces/msg/PlantState", rows, robots=names)
        box = {name: np.zeros(n) for name in ("chi", "lower", "upper")}
        told = {"robots": names, "slacks": np.array([1e-6, 0.2, 0.4]), "solve_time": 3e-4}
        self._chi = {
            stack: self._pattern("lexstack_interfaces/msg/Chi", box, stack=stack, **told)
            for stack in self._stacks
        }
        self._limits = self._team.limits.velocity
        self._clock = self._pattern("rosgraph_msgs/msg/Clock", {})
        self._tools = {
            f"/{name}/{topic}": self._pattern(kind, {})
            for name in names
            for topic, kind in TOOLS.items()
        }

    def topics(self) -> list[Topic]:
        """Return the topics of the bag."""
        kinds = STREAMS | {topic: TOOLS[topic.rsplit("/", 1)[1]] for topic in self._tools}
        return [Topic(name, kind, (Qos(),)) for name, kind in kinds.items()]

    def messages(self, tick: int) -> Iterator[tuple[str, bytes]]:
        """Yield topic and content of every message of a tick."""
        time = tick * self._dt
        angle = 0.2 * time + self._phases
        q = self._home + self._swing * (np.sin(angle) - np.sin(self._phases))
        chi = 0.2 * self._swing * np.cos(angle)
        switch, since = divmod(tick, _SWITCH)
        stack = self._stacks[switch % len(self._stacks)]
        yield "/clock", self._clock.at(time, tick)
        yield PLANT_STATE, self._plant.at(time, tick, q=q, v=chi, q_star=q, command=chi)
        box = {"lower": -self._limits, "upper": self._limits}
        yield SOLUTION, self._chi[stack].at(time, tick, chi=chi, **box)
        yield COMMAND, self._chi[stack].at(time, tick, chi=chi, **box)
        yield TRANSITION, self._status(tick, switch, since, stack)
        if tick % _SLOW == 0:
            for topic, pattern in self._tools.items():
                yield topic, pattern.at(time, tick)

    def _status(self, tick: int, switch: int, since: int, stack: str) -> bytes:
        """Return how far the controller is on its way."""
        blending = bool(switch) and since <= _BLEND
        phase = (Phase.ADOPTING if since == _BLEND else Phase.BLENDING) if blending else Phase.IDLE
        data = _serialized(
            "lexstack_interfaces/msg/TransitionStatus",
            tick=tick,
            id=switch,
            from_stack=self._stacks[(switch - 1) % len(self._stacks)] if switch else stack,
            to_stack=stack,
            source="robot_b" if blending else "",
            method="bridge",
            phase=phase,
            alpha=min(since / _BLEND, 1.0) if switch else 1.0,
            duration=_BLEND * self._dt,
            robots=list(self._team.names),
        )
        _put_stamp(data, tick * self._dt)
        return bytes(data)

    def _pattern(self, kind: str, vectors: dict[str, Vector], **fields: Any) -> _Pattern:
        """Return a message as a pattern, its vectors found by their content."""
        marked = {
            name: np.full(values.shape, 1000.5 + i)
            for i, (name, values) in enumerate(vectors.items())
        }
        data = _serialized(kind, tick=_TICK, **marked, **fields)
        tick = data.find(struct.pack("<Q", _TICK))
        places = {name: data.index(values.tobytes()) for name, values in marked.items()}
        return _Pattern(data, None if tick < 0 else tick, places)


def _put_stamp(data: bytearray, stamp: float) -> None:
    """Write a time [s] to where every header has it, behind CDR's own head."""
    seconds, nanoseconds = divmod(round(stamp * 1e9), 10**9)
    _STAMP.pack_into(data, 4, seconds, nanoseconds)


def _serialized(kind: str, **fields: Any) -> bytearray:
    """Return a message in CDR; what is not given is zero or empty."""
    store = _store(kind)
    return bytearray(store.serialize_cdr(_filled(store, kind, fields), kind))


@cache
def _store(kind: str) -> Any:
    """Return a type store that knows a type and all that it needs."""
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(message_definition(kind), kind))
    return store


def _filled(store: Any, kind: str, given: dict[str, Any]) -> Any:
    """Return a message of a type with all fields set."""
    from rosbags.interfaces import Nodetype  # noqa: PLC0415

    values = {}
    for name, (node, detail) in store.fielddefs[kind][1]:
        if name in given:
            values[name] = given[name]
        elif kind == "builtin_interfaces/msg/Time":
            values[name] = 0
        elif node == Nodetype.NAME:
            values[name] = _filled(store, detail, {})
        elif node == Nodetype.BASE:
            values[name] = {"string": "", "bool": False}.get(
                detail[0], 0.0 if detail[0].startswith("float") else 0
            )
        else:
            (inner, of), length = detail
            count = length if node == Nodetype.ARRAY else 0
            numeric = inner == Nodetype.BASE and of[0] not in ("string", "bool")
            values[name] = np.zeros(count, dtype=of[0]) if numeric else []
    return store.types[kind](**values)
