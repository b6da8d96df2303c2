"""Reads a bag, with the definitions that it carries itself, into a Run."""

from __future__ import annotations

from array import array
from bisect import bisect_right
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import replace
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from lexstack.errors import ConfigurationError, InputError
from lexstack.references import WIDTHS, Moving, Setting, decode
from lexstack.robots import Team
from lexstack.tasks import StackConfig
from lexstack_bag.errors import BagError
from lexstack_bag.run.columns import StreamBuilder, seconds
from lexstack_bag.run.loss import LossCounter
from lexstack_bag.run.partial_chi import ChiBuilder
from lexstack_bag.run.plan_topics import PlanTopicsCollector
from lexstack_bag.run.references import is_usable
from lexstack_bag.run.run import (
    PlantStream,
    Run,
    RunPart,
    StackRequested,
    Target,
    TransitionStream,
)
from lexstack_bag.run.stretches import Stretch, Stretches, without_strangers
from lexstack_bag.storage.container import Container, Progress, RawMessage, find_files
from lexstack_bag.storage.decoder import Decoder
from lexstack_bag.storage.writer import CLOSING_RECORD, SCENARIO_RECORD
from lexstack_bag.topics import (
    COMMAND,
    DECISIONS,
    PLANT_STATE,
    REQUEST,
    SCENARIO,
    SOLUTION,
    TRANSITION,
    role_names,
)
from lexstack_config.parts import build_team
from lexstack_config.resolved import ResolvedScenario
from lexstack_config.sent_stacks import read_stack

_BROUGHT = "lexstack_experiments"
"""Brings the methods and solvers that were the library's own when bags had no extensions."""

_TARGETS = {"ee_target": "ee", "base_target": "base"}


def read_run(path: Path, progress: Progress = lambda _part: None, *, plans: bool = True) -> Run:
    """Return the run in a bag; of a bag with resets of the plant the part after the last one.

    Args:
        path: a run folder, a bag folder or an .mcap file.
        progress: told how much has been read, from 0 to 1.
        plans: whether the plans of the HTMPC are wanted: they are large, replay needs them.

    Raises:
        BagError: nothing there, not readable, or not recorded by lexstack.
    """
    return read_parts(path, progress, plans=plans)[-1]


def read_parts(
    path: Path, progress: Progress = lambda _part: None, *, plans: bool = True
) -> tuple[Run, ...]:
    """Return the parts of a bag in their order: a reset of the plant begins a new one.

    Args and errors are those of ``read_run``.
    """
    files = find_files(path)
    container = Container(files)
    provenance, resolved = read_provenance(container)
    team = build_team(resolved)
    collector = _Collector(resolved, team, plans=plans)
    for message in container.messages(progress):
        collector.add(message)
    if len(collector.stretches.found) < 2:
        return (collector.run(files[0], provenance, container),)
    parts_found = without_strangers(collector.stretches.found)
    collectors = [_Collector(resolved, team, plans=plans, only=part) for part in parts_found]
    begins = np.maximum.accumulate([part.sent for part in parts_found]).tolist()
    for message in container.messages(progress):
        # Topics arrive in any order: the time of sending says which part a message belongs to.
        collectors[max(bisect_right(begins, message.publish_time) - 1, 0)].add(message)
    found = [each for each in collectors if each.stretches.found]  # clocks may have gone back
    runs = [each.run(files[0], provenance, container) for each in found]
    lost = _lost(container, collector.losses)
    if len(runs) == 1:
        return (replace(runs[0], lost=lost),)
    parts = tuple(
        RunPart(len(run.plant.tick), float(run.plant.stamp[0]), float(run.plant.stamp[-1]))
        for run in runs
    )
    return tuple(
        replace(run, part=number, parts=parts, lost=lost) for number, run in enumerate(runs, 1)
    )


def read_provenance(container: Container) -> tuple[dict[str, str], ResolvedScenario]:
    """Return what a bag says about its run, and the scenario.

    The scenario stands in a Metadata record if lexstack's recorder wrote the bag; in any other bag
    it is the message that the controller publishes. From then on the container tells topics
    without the namespace of the run.

    Raises:
        BagError: the bag has neither.
    """
    path = container.files[0]
    provenance = container.first_metadata(SCENARIO_RECORD)
    container.namespace = provenance.pop("namespace", "")
    text = provenance.pop("scenario", None) or _published_scenario(container)
    if text is None:
        raise BagError(
            f"{path}: not a lexstack bag: it holds neither a Metadata record {SCENARIO_RECORD!r} "
            f"nor a message of {SCENARIO}; record that topic too (ros2 bag record -a does)"
        )
    try:
        resolved = ResolvedScenario.from_yaml(text, f"{path}: scenario", _since())
    except ConfigurationError as error:
        raise BagError(str(error)) from error
    return provenance, resolved


def _since() -> dict[str, dict[str, object]]:
    """Return what stands for keys that older bags do not have.

    Their targets stepped, all methods and solvers were known: now some are where they can be
    loaded. The costs of their MPC were not compiled.
    """
    found = find_spec(_BROUGHT) is not None
    extensions = [f"{_BROUGHT}.{part}" for part in ("methods", "solvers") if found]
    return {
        "scenario": {"lead_in": 0.0, "extensions": extensions},
        "htmpc": {"evaluation": "plain"},
    }


def _published_scenario(container: Container) -> str | None:
    """Return the scenario that a controller published, or None; raises BagError.

    The container takes over its namespace. Of several cells that without a namespace counts; where
    all have one, the bag does not say which is meant.
    """
    cells = sorted(
        cell for cell in map(_cell_of, container.topics_of_all_files()) if cell is not None
    )
    if len(cells) > 1 and cells[0]:
        raise BagError(
            f"{container.files[0]}: holds the runs of {', '.join(cells)}; record each in a bag of "
            f"its own: ros2 bag record --regex '^{cells[0]}/'"
        )
    container.namespace = cells[0] if cells else ""
    decode = Decoder()
    for message in container.messages() if cells else ():
        if message.topic == SCENARIO:
            return str(getattr(decode(message), "data", ""))
    return None


def _cell_of(topic: str) -> str | None:
    """Return the namespace of a controller whose scenario is on a topic, None for other topics."""
    for name in (SCENARIO, role_names()[SCENARIO]):
        if topic.endswith(name):
            return topic.removesuffix(name)
    return None


class _Collector:
    """Sorts the messages of a part: takes apart what analysis needs, counts all of them."""

    def __init__(
        self,
        resolved: ResolvedScenario,
        team: Team,
        *,
        plans: bool,
        only: Stretch | None = None,
    ) -> None:
        """Start empty; ``plans`` as in ``read_run``; ``only``: whose states alone are taken."""
        self._only = only
        self.stretches = Stretches()
        self._resolved = resolved
        self._arms = [len(robot.mid_range) for robot in team.robots]
        self._counts: dict[str, int] = defaultdict(int)
        self.losses: dict[str, LossCounter] = defaultdict(LossCounter)
        self._plant = StreamBuilder(PlantStream, team.n, "first", team.nq)
        # Of every tick in the controller's chi; in older bags in the topic.
        self._transition = StreamBuilder(TransitionStream, team.n, "all")
        self._told = StreamBuilder(TransitionStream, team.n, "all")
        self._chi = {topic: ChiBuilder(team) for topic in (COMMAND, SOLUTION)}
        scenario = resolved.scenario
        self._plan_topics = PlanTopicsCollector(scenario.robots, scenario.rate, plans=plans)
        self._targets: list[Target] = []
        self._settings: list[Setting] = []
        self._requested: list[tuple[int, Any]] = []  # time of sending [ns], message
        self._commanded: tuple[array[int], array[int]] = array("q"), array("q")  # time, tick
        self._decode = Decoder()
        self._now = 0.0  # s, stamp of the last plant state

    def add(self, message: RawMessage) -> None:
        """Take one message."""
        topic = message.topic
        self._counts[topic] += 1
        if message.sequence:
            self.losses[topic].see(message.sequence)
        if topic == PLANT_STATE:
            self._add_state(self._decode(message), message.publish_time)
        elif topic in self._chi:
            chi = self._decode(message)
            self._chi[topic].add(chi, message.publish_time)
            if topic == COMMAND:
                self._commanded[0].append(message.publish_time)
                self._commanded[1].append(chi.tick)
                for status in getattr(chi, "transitions", ()):  # older bags have none
                    self._transition.add(status)
        elif topic == TRANSITION:
            self._told.add(self._decode(message))
        elif topic == DECISIONS:
            self._add_setting(message)
        elif topic == REQUEST:
            self._requested.append((message.publish_time, self._decode(message)))
        elif not self._plan_topics.add(topic, partial(self._decode, message), message.publish_time):
            self._add_target(message)

    def _add_state(self, state: Any, sent: int) -> None:
        """Take a state of the plant that was sent at a time [ns]."""
        if self._only is not None and not self._only.holds(state):
            return
        self._now = seconds(state.header.stamp)
        self.stretches.see(state, sent)
        if self._plant.add(state):
            self._begin_anew()

    def run(self, path: Path, provenance: dict[str, str], container: Container) -> Run:
        """Return the Run of all that was collected; raises BagError without a plant."""
        plant = self._plant.build()
        if not len(plant.tick):
            raise BagError(f"{path}: holds no message of {PLANT_STATE}")
        chi = {topic.split("/")[1]: builder.build() for topic, builder in self._chi.items()}
        requested = self._requests()
        return Run(
            path,
            provenance,
            with_sent(self._resolved, requested),
            plant,
            {node: last for node, (last, _) in chi.items()},
            self._transitions(),
            tuple(self._targets),
            dict(sorted(self._counts.items())),
            _lost(container, self.losses),
            container.complete,
            requested,
            {node: replaced for node, (_, replaced) in chi.items()},
            self._plan_topics.build(),
            tuple(self._settings),
        )

    def _transitions(self) -> TransitionStream:
        """Return where the transitions stood at every tick."""
        stream, told = self._transition.build(), self._told.build()
        return stream if len(stream.tick) else told

    def _begin_anew(self) -> None:
        """Forget what a reset of the plant makes void: requests, and references set by users."""
        self._requested.clear()
        self._targets.clear()
        self._plan_topics.begin_anew()
        for builder in self._chi.values():
            builder.begin_anew()

    def _add_setting(self, message: RawMessage) -> None:
        """Take a decision on references; one for an earlier time follows a reset of the plant."""
        value = self._decode(message)
        vectors = {name: getattr(value, name) for name in WIDTHS}
        names = list(self._resolved.scenario.robots)
        try:
            moving = [
                Moving(names.index(m.robot), m.of, m.kind, m.values, m.lead, m.frame)
                for m in getattr(value, "trajectories", ())  # older bags have none
                if m.robot in names
            ]
            at, where = seconds(value.header.stamp), DECISIONS
            rest = {"moving": moving, "arms": self._arms}
            setting = decode(at, value.revision, vectors, len(names), where, **rest)
        except InputError:
            return  # the solver refused it, too
        if self._settings and setting.at < self._settings[-1].at:
            self._settings.clear()
        self._settings.append(setting)

    def _add_target(self, message: RawMessage) -> None:
        """Take a reference: it holds from its stamp on, or at once if that has passed."""
        robot, _, name = message.topic[1:].partition("/")
        if name not in _TARGETS:
            return
        value = self._decode(message)
        place, turn = value.pose.position, value.pose.orientation
        target = Target(
            robot,
            _TARGETS[name],  # type: ignore[arg-type]
            max(seconds(value.header.stamp), self._now),
            np.array([place.x, place.y, place.z]),
            np.array([turn.x, turn.y, turn.z, turn.w]),
            message.log_time,
        )
        if value.header.frame_id in ("", "world") and is_usable(target):
            self._targets.append(target)

    def _requests(self) -> tuple[StackRequested, ...]:
        """Return the requests to the solver between the controller's commands, by its own clock."""
        times, ticks = (np.frombuffer(column, np.int64) for column in self._commanded)
        found = []
        for sent, message in sorted(self._requested, key=lambda entry: entry[0]):
            before = int(np.searchsorted(times, sent))
            after = int(ticks[before - 1]) if before else -1
            robots = tuple(getattr(message, "robots", ()))  # older bags have none
            entry = message.id, message.stack, message.start_tick, message.active, robots
            found.append(StackRequested(after, *entry, getattr(message, "stack_yaml", "")))
        return tuple(found)


def with_sent(resolved: ResolvedScenario, requested: Iterable[StackRequested]) -> ResolvedScenario:
    """Return a scenario with the stacks that users sent in its run beside its own."""
    stacks: dict[str, StackConfig] = dict(resolved.stacks)
    for request in requested:
        if request.text and request.stack not in stacks:
            try:
                stacks[request.stack] = read_stack(request.text)
            except ConfigurationError:
                continue  # the solver refused it, too
    return replace(resolved, stacks=stacks) if len(stacks) > len(resolved.stacks) else resolved


def _lost(container: Container, losses: dict[str, LossCounter]) -> int:
    """Return what the recorder counted, or without its closing word the gaps in the bag."""
    word = container.metadata.get(CLOSING_RECORD, {}).get("recorder_lost")
    return int(word) if word else sum(counter.lost for counter in losses.values())
