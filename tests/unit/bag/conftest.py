"""A small run made by hand, in a bag: every figure of it can be computed on paper."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from lexstack.tasks import LevelConfig, StackConfig, TaskConfig
from lexstack.transition import TransitionConfig
from lexstack_bag.run.provenance import run_provenance
from lexstack_bag.storage.definitions import message_definition
from lexstack_bag.storage.metadata import Qos, Topic
from lexstack_bag.storage.presets import Storage
from lexstack_bag.storage.writer import BagWriter
from lexstack_config.parts import build_team, home_of
from lexstack_config.resolved import ResolvedScenario, load_robot
from lexstack_config.scenario import PlacementConfig, ScenarioConfig

ROOT = Path(__file__).parents[3]
RATE, TICKS, TRIGGER, ADOPTED, MISSING = 100, 400, 100, 200, 300
EPOCH = 1_700_000_000_000_000_000  # ns, when the recording begins


def stack(name: str, *types: str) -> StackConfig:
    levels = tuple(LevelConfig((TaskConfig(kind),)) for kind in types)
    return StackConfig(name, "for tests", levels)


@pytest.fixture(scope="session")
def resolved() -> ResolvedScenario:
    """Two robots, two stacks, 4 s at 100 Hz."""
    scenario = ScenarioConfig(
        name="transition-sequence",
        description="A run made by hand.",
        robots={
            "robot_a": PlacementConfig("panda_summit", (0.0, 0.0, 0.0)),
            "robot_b": PlacementConfig("panda_summit", (2.0, 0.0, 0.0)),
        },
        rate=RATE,
        duration=TICKS / RATE,
        initial_stack="track",
        transition=TransitionConfig(1.0),
        seed=7,
    )
    return ResolvedScenario(
        scenario,
        {"panda_summit": load_robot(ROOT / "config/robots/panda_summit.yaml")},
        {
            "track": stack("track", "ee_pose", "velocity_damping"),
            "reach_base": stack("reach_base", "ee_pose", "base", "velocity_damping"),
        },
    )


class Messages:
    """Makes messages in CDR from the definitions that a bag would carry."""

    def __init__(self) -> None:
        self._stores: dict[str, Any] = {}

    def store(self, type_name: str) -> Any:
        if type_name not in self._stores:
            store = get_typestore(Stores.EMPTY)
            store.register(get_types_from_msg(message_definition(type_name), type_name))
            self._stores[type_name] = store
        return self._stores[type_name]

    def type_hash(self, type_name: str) -> str:
        return str(self.store(type_name).hash_rihs01(type_name))

    def cdr(self, type_name: str, **fields: Any) -> bytes:
        store = self.store(type_name)
        if "stamp" in fields:
            seconds, nanoseconds = divmod(round(fields.pop("stamp") * 1e9), 10**9)
            time = store.types["builtin_interfaces/msg/Time"](seconds, nanoseconds)
            fields["header"] = store.types["std_msgs/msg/Header"](time, "world")
        if "position" in fields:
            geometry = "geometry_msgs/msg"
            point = store.types[f"{geometry}/Point"](*map(float, fields.pop("position")))
            turn = store.types[f"{geometry}/Quaternion"](*map(float, fields.pop("quaternion")))
            fields["pose"] = store.types[f"{geometry}/Pose"](point, turn)
        if type_name == "lexstack_interfaces/msg/Chi":
            fields.setdefault("transitions", [])
        message = store.types[type_name](**fields)
        return bytes(store.serialize_cdr(message, type_name))


@dataclass
class Synthetic:
    """The bag, and what was put into it."""

    folder: Path
    resolved: ResolvedScenario
    counts: dict[str, int]
    lost: dict[str, int]


class Maker:
    """Writes the run, tick by tick."""

    def __init__(self, writer: BagWriter, resolved: ResolvedScenario) -> None:
        self.writer = writer
        self.messages = Messages()
        self.counts: dict[str, int] = {}
        self.team = build_team(resolved)
        self.home = home_of(self.team, resolved)
        self.log_time = EPOCH

    def put(self, topic: str, type_name: str, **fields: Any) -> None:
        if topic not in self.counts:
            type_hash = self.messages.type_hash(type_name)
            self.writer.add_topic(Topic(topic, type_name, (Qos(),), type_hash))
        self.counts[topic] = self.counts.get(topic, 0) + 1
        self.log_time += 100_000
        data = self.messages.cdr(type_name, **fields)
        sequence = self.counts[topic]
        self.writer.write(topic, data, self.log_time, self.log_time - 50_000, sequence)

    def target(self, robot: str, kind: str, stamp: float, position: Any, yaw: float = 0.0) -> None:
        turn = (0.0, 0.0, np.sin(yaw / 2), np.cos(yaw / 2))
        self.put(
            f"/{robot}/{kind}_target",
            "geometry_msgs/msg/PoseStamped",
            stamp=stamp,
            position=position,
            quaternion=turn,
        )

    def targets(self) -> None:
        """Three references, told at the start, that hold from a later time on."""
        tool_a, tool_b = (pose.position for pose in self.team.tools(self.home))
        base_b = self.home[10:13]
        self.target("robot_a", "ee", 0.5, np.add(tool_a, (0.003, 0.0, 0.004)))
        self.target("robot_b", "base", 1.0, np.add(base_b, (0.03, 0.04, 0.0)), yaw=0.01)
        self.target("robot_b", "ee", 2.0, np.add(tool_b, (0.0288, 0.0384, 0.001)))

    def q(self, tick: int) -> np.ndarray:
        """Robot B's base moves by 48 mm of the 50 mm at tick 200."""
        q = self.home.copy()
        if tick >= 200:
            q[10:12] += [0.0288, 0.0384]
        return q

    def chi(self, tick: int) -> np.ndarray:
        chi = np.zeros(20)
        chi[1] = 0.006  # from the first tick on: 0.6 m/s2, ratio 0.1
        if tick == 50:
            chi[0] = 0.03  # 3 m/s2, ratio 0.5; then back: jerk 600 m/s3, ratio 1
        if tick >= 150:
            chi[13] = 0.015  # 1.5 rad/s2, ratio 0.1
        if tick > MISSING:
            chi[0] = 0.06  # would be ratio 1, but for the gap
        return chi

    def state(self, tick: int) -> dict[str, Any]:
        return {
            "stamp": tick / RATE,
            "tick": tick,
            "robots": ["robot_a", "robot_b"],
            "q": self.q(tick),
            "v": np.zeros(20),
            "q_star": self.q(tick),
            "command": self.chi(tick - 1) if tick else np.zeros(20),
            "commander": "robot_a@host/1/0",
            "sender": "plant@host/1/0",
            "resets": 0,
            "status": 0,
            "late_ticks": 2 if tick > 350 else 0,
            "missing_ticks": 0,
        }

    def plant(self, tick: int, **fields: Any) -> None:
        kind = "lexstack_interfaces/msg/PlantState"
        self.put("/plant/state", kind, **(self.state(tick) | fields))

    def solution(self, robot: str, tick: int, **fields: Any) -> None:
        defaults = {
            "stack": "track" if tick < TRIGGER else "reach_base",
            "transition_id": int(tick >= TRIGGER),
            "chi": self.chi(tick),
            "lower": np.full(20, -1.0),
            "upper": np.full(20, 1.0),
            "slacks": np.zeros(2),
            "status": 0,
            "empty_bounds": 0,
            "solve_time": 0.0,
            "reason": "",
        }
        self.put(
            f"/{robot}/chi",
            "lexstack_interfaces/msg/Chi",
            stamp=tick / RATE,
            tick=tick,
            sender=f"{robot}@host/1/0",
            references=1,
            robots=["robot_a", "robot_b"],
            **(defaults | fields),
        )

    def solutions(self, tick: int) -> None:
        if tick != MISSING:
            fields: dict[str, Any] = {"solve_time": 1e-6 * (tick % 100 + 1)}
            if tick == 30:
                fields["lower"] = np.full(20, 1.5)
            if tick == 31:
                fields["empty_bounds"] = 1
            if tick == 60:
                fields |= {"status": 1, "reason": "braking"}
            self.solution("robot_a", tick, **fields)
        if TRIGGER <= tick < ADOPTED:
            failed = {"status": 2, "chi": np.zeros(0)} if tick == 120 else {}
            self.solution("robot_b", tick, solve_time=500e-6, **failed)

    def transition(self, tick: int, **fields: Any) -> None:
        phase = int(
            np.searchsorted([90, TRIGGER, TRIGGER + 1, ADOPTED, ADOPTED + 1], tick, "right")
        )
        phase = (0, 1, 2, 3, 4, 0)[phase]
        defaults = {
            "stamp": tick / RATE,
            "tick": tick,
            "id": int(tick >= 90),
            "from_stack": "track",
            "to_stack": "reach_base" if tick >= 90 else "track",
            "source": "robot_b" if TRIGGER <= tick <= ADOPTED else "",
            "method": "bridge",
            "phase": phase,
            "alpha": float(np.clip((tick - TRIGGER) / 100, 0, 1)) if tick >= 90 else 1.0,
            "duration": 1.0,
            "gap": 0.0 if phase else np.nan,
            "reason": "",
            "robots": ["robot_a", "robot_b"],
        }
        kind = "lexstack_interfaces/msg/TransitionStatus"
        self.put("/robot_a/transition", kind, **(defaults | fields))

    def tick(self, tick: int) -> None:
        """All messages of one tick."""
        self.plant(tick)
        self.solutions(tick)
        self.transition(tick)


def write_bag(
    folder: Path,
    resolved: ResolvedScenario,
    *,
    close: bool = True,
    storage: Storage | None = None,
    kind: type[Maker] = Maker,
    facts: dict[str, str] | None = None,
) -> Synthetic:
    writer = BagWriter(
        folder, run_provenance(resolved) if facts is None else facts, storage or Storage()
    )
    maker = kind(writer, resolved)
    maker.targets()
    for tick in range(TICKS):
        maker.tick(tick)
        if tick % 40 == 39:
            writer.flush()
    lost = {"/clock": 3, "/plant/state": 0}
    if close:
        writer.close(lost)
    return Synthetic(folder, resolved, maker.counts, lost)


@pytest.fixture(scope="session")
def synthetic(tmp_path_factory: pytest.TempPathFactory, resolved: ResolvedScenario) -> Synthetic:
    """The complete bag."""
    return write_bag(tmp_path_factory.mktemp("run") / "bag", resolved)


@pytest.fixture(scope="session")
def write(resolved: ResolvedScenario) -> Callable[..., Synthetic]:
    """Write the run to a folder, stored as wished: ``write(folder, storage=..., close=...)``."""
    return lambda folder, **options: write_bag(folder, resolved, **options)


@pytest.fixture(scope="session")
def maker() -> type[Maker]:
    """What writes the run, to be changed: ``write(folder, kind=...)``."""
    return Maker


@pytest.fixture(scope="session")
def killed(tmp_path_factory: pytest.TempPathFactory, resolved: ResolvedScenario) -> Synthetic:
    """The same bag without an end, as a killed recorder leaves it."""
    return write_bag(tmp_path_factory.mktemp("killed") / "bag", resolved, close=False)


@pytest.fixture(scope="session")
def plant_alone(tmp_path_factory: pytest.TempPathFactory, resolved: ResolvedScenario) -> Synthetic:
    """A bag with the plant's states and nothing else: the controller died at once."""
    folder = tmp_path_factory.mktemp("alone") / "bag"
    with BagWriter(folder, run_provenance(resolved)) as writer:
        maker = Maker(writer, resolved)
        for tick in range(20):
            maker.plant(tick)
    return Synthetic(folder, resolved, maker.counts, {})
