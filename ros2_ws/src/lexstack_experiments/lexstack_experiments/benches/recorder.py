"""The recorder over DDS: messages of 500 bytes, and what it costs to keep them.

Each row is a recorder process of its own, a publisher process, and a bag that is read afterwards:
lost is what was sent and is not in the bag. The CPU share is that of the recorder's process while
messages come, in percent of one core. The baseline records as a first attempt would: one callback
per message, decoded and encoded again, the mcap package's writer.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from lexstack.errors import LexstackError
from lexstack_bag.storage.container import Container, find_files
from lexstack_experiments.experiment import Experiment, Options
from lexstack_experiments.results import Cell, Figure, Goal, Peer, Results, Table, zero
from lexstack_experiments.runs import scenario_of

NAME = "recorder"
RATE, BYTES, SECONDS = 10_000, 500, 5.0
_FAST = 15_000  # messages/s, to see what is in reserve
_PATIENCE = 60.0  # s of wall time for a process
_MODULE = "lexstack_testing.load"
_DOMAIN = 130  # plus the process id modulo 100: beyond those that runs choose from


@dataclass(frozen=True, slots=True)
class Case:
    """One row: who records what load."""

    name: str
    rate: int = RATE
    topics: int = 1
    preset: str = "default"
    plain: bool = False


CASES = (
    Case("lexstack", RATE),
    Case("plain rclpy", RATE, plain=True),
    Case("lexstack", RATE, topics=10),
    Case("lexstack", RATE, preset="none"),
    Case("lexstack", RATE, preset="fastwrite"),
    Case("lexstack", RATE, preset="zstd_fast"),
    Case("lexstack", RATE, preset="zstd_small"),
    Case("lexstack", _FAST),
)


@dataclass(frozen=True, slots=True)
class Outcome:
    """What came of a case."""

    case: Case
    sent: int
    rate: float  # messages/s as published
    lost: int
    counted: int | None  # lost, as the recorder itself says
    acked: bool  # whether the publisher left after all was delivered
    share: float  # of one core, percent
    size: float  # MB on the disk


def run(options: Options) -> Results:
    """Record every case."""
    outcomes = []
    scenario = options.out / "scenario.yaml"
    scenario.write_text(scenario_of(options.config).to_yaml(), encoding="utf-8")
    for number, case in enumerate(CASES[: options.cases]):
        outcome = _measured(case, options.out / f"case_{number}", scenario)
        outcomes.append(outcome)
        options.say(
            f"{case.name}, {case.preset}, {case.topics} topics, {outcome.rate:.0f} messages/s: "
            f"{outcome.lost} of {outcome.sent} lost, {outcome.share:.0f} % of a core"
        )
    return options.results(
        NAME,
        _figures(outcomes),
        Table.of(_row(outcome) for outcome in outcomes),
        {"bytes": BYTES, "seconds": SECONDS, "qos": "reliable"},
        (
            "Publisher and recorder share the machine's cores.",
            "zstd_small compresses more slowly than such a load comes: losses must be counted.",
            "What a publisher had not delivered when it left cannot be counted: left out there.",
        ),
    )


def _figures(outcomes: list[Outcome]) -> list[Figure]:
    """Return what has a goal; the plain recorder is the peer."""
    plain = next((outcome for outcome in outcomes if outcome.case.plain), None)

    def peer(value: float | None) -> Peer | None:
        return None if plain is None else Peer("plain rclpy", value)

    first = outcomes[0]
    figures = [
        Figure("Rate of the load", first.rate, "messages/s", Goal(">=", RATE, 0.02 * RATE)),
        Figure(
            "Messages lost",
            first.lost,
            "",
            Goal("==", 0.0),
            peer=peer(plain.lost if plain else None),
        ),
        Figure(
            "CPU of the recorder",
            first.share,
            "% of a core",
            peer=peer(plain.share if plain else None),
        ),
    ]
    missed = sum(abs(o.lost - o.counted) for o in outcomes if o.counted is not None and o.acked)
    figures.append(zero("Losses that were not counted", missed))
    return figures


def _row(outcome: Outcome) -> dict[str, Cell]:
    """Return a line of the table."""
    case = outcome.case
    return {
        "recorder": case.name,
        "preset": "–" if case.plain else case.preset,
        "topics": case.topics,
        "messages/s": round(outcome.rate),
        "sent": outcome.sent,
        "lost": outcome.lost,
        "of them counted": outcome.counted,
        "% of a core": outcome.share,
        "us per message": 1e4 * outcome.share / outcome.rate,
        "MB": outcome.size,
    }


def _measured(case: Case, folder: Path, scenario: Path) -> Outcome:
    """Run one case in processes of its own; raises LexstackError where one does not answer."""
    folder.mkdir()
    environment = os.environ | {"ROS_DOMAIN_ID": str(_DOMAIN + os.getpid() % 100)}
    recorder = _start(_recorder(case, folder, scenario), environment)
    try:
        _expect(recorder, "ready\n")
        load = ["publish", f"--rate={case.rate}", f"--bytes={BYTES}", f"--seconds={SECONDS}"]
        before = _cpu(recorder.pid)
        publisher = _start([_MODULE, *load, f"--topics={case.topics}"], environment)
        answer, errors = publisher.communicate(timeout=_PATIENCE)
        if publisher.returncode:
            raise LexstackError(f"the publisher ended: {errors.strip().splitlines()[-1]}")
        spent = _cpu(recorder.pid) - before
    finally:
        recorder.send_signal(signal.SIGINT)
        recorder.communicate(timeout=_PATIENCE)
    sent = json.loads(answer)
    container = Container(find_files(folder))
    counts = Counter(m.topic for m in container.messages() if m.topic.startswith("/load_"))
    word = container.metadata.get("lexstack_recorder", {}).get("recorder_lost")
    return Outcome(
        case,
        sent["sent"],
        sent["sent"] / sent["seconds"],
        sent["sent"] - counts.total(),
        None if word is None else int(word),
        bool(sent["acked"]),
        100.0 * spent / sent["seconds"],
        sum(path.stat().st_size for path in find_files(folder)) / 1e6,
    )


def _recorder(case: Case, folder: Path, scenario: Path) -> list[str]:
    """Return module and arguments of a case's recorder."""
    if case.plain:
        return [_MODULE, "record", str(folder / "plain.mcap")]
    topics = ",".join(f"/load_{i}:std_msgs/msg/String" for i in range(case.topics))
    parameters = {
        "output": folder / "bag",
        "scenario": scenario,
        "storage_preset_profile": case.preset,
        "expected_topics": f"'{topics}'",
    }
    pairs = [word for key, value in parameters.items() for word in ("-p", f"{key}:={value}")]
    return ["lexstack_ros.recorder.node", "--ros-args", *pairs]


def _start(module: list[str], environment: dict[str, str]) -> subprocess.Popen[str]:
    """Start a Python module."""
    return subprocess.Popen(
        [sys.executable, "-m", *module],
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def _expect(process: subprocess.Popen[str], word: str) -> None:
    """Wait for a line; raises LexstackError when the process ends without it."""
    assert process.stdout is not None
    if process.stdout.readline() != word:
        _, errors = process.communicate(timeout=_PATIENCE)
        raise LexstackError(f"the recorder ended: {errors.strip().splitlines()[-1]}")


def _cpu(pid: int) -> float:
    """Return the processor time that a process has used so far [s] (Linux)."""
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


EXPERIMENT = Experiment(
    "10 000 messages/s of 500 bytes over DDS: losses and CPU", "cases", len(CASES), run
)
