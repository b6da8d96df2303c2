"""The recorder as a process: it misses nothing, and leaves a complete bag whatever stops it."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
import yaml
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader

from lexstack_bag.run.reader import read_run
from lexstack_bringup.domain import own_domain
from lexstack_config.resolved import load_scenario

ROOT = Path(__file__).resolve().parents[2]
COUNT = 1500
CARELESS = "/found/by/itself"  # best effort: while the machine stalls, messages may be lost

pytestmark = pytest.mark.system


@pytest.fixture
def environment() -> Iterator[dict[str, str]]:
    """A ROS domain of this test's own."""
    with own_domain() as domain:
        own = {"ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
        yield {**os.environ, **own}


@pytest.fixture
def scenario(tmp_path) -> Path:
    path = tmp_path / "scenario.yaml"
    source = ROOT / "config/scenarios/transition-sequence.yaml"
    path.write_text(load_scenario(source).to_yaml(), encoding="utf-8")
    return path


def start(command: list[str], environment: dict[str, str]) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, *command],
        env=environment,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def recorder_command(output: Path, scenario: Path, **values: object) -> list[str]:
    given = {"output": output, "scenario": scenario, **values}
    pairs = [word for key, value in given.items() for word in ("-p", f"{key}:={value}")]
    return ["-m", "lexstack_ros.recorder.node", "--ros-args", *pairs]


@pytest.fixture
def recorder(request, tmp_path, scenario, environment) -> Iterator[subprocess.Popen[str]]:
    """A recorder that has said that it is ready; a test may give parameters."""
    values = getattr(request, "param", {})
    process = start(recorder_command(tmp_path / "bag", scenario, **values), environment)
    assert process.stdout is not None
    assert process.stdout.readline() == "ready\n"
    yield process
    process.kill()
    process.communicate()


@pytest.fixture
def sent(request, recorder, environment) -> Iterator[dict[str, int]]:
    """What was published and has arrived at the recorder, by topic; a test may name topics."""
    script = str(ROOT / "tests/system/recorder_publisher.py")
    process = start([script, str(COUNT), *getattr(request, "param", [])], environment)
    assert process.stdout is not None
    line = process.stdout.readline()
    assert line, process.communicate()[1]
    yield json.loads(line)
    process.communicate("stop\n", timeout=20)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_leaves_a_complete_bag(recorder, sent, tmp_path, number):
    for _ in range(3):  # the impatient press Ctrl-C more than once
        recorder.send_signal(number)
        time.sleep(0.05)
    _, log = recorder.communicate(timeout=20)
    assert recorder.returncode == 0, log
    assert "Traceback" not in log

    with AnyReader([tmp_path / "bag"]) as reader:  # checks the hashes of the types
        counts = {c.topic: c.msgcount for c in reader.connections}
        ticks = [
            reader.deserialize(data, connection.msgtype).tick
            for connection, _, data in reader.messages()
            if connection.topic == "/plant/state"
        ]
    careless = counts.pop(CARELESS), sent.pop(CARELESS)
    assert 0 < careless[0] <= careless[1]
    assert {topic: counts[topic] for topic in sent} == sent
    assert ticks == list(range(COUNT))
    with (tmp_path / "bag/bag_0.mcap").open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        assert sum(1 for _ in reader.iter_messages()) == sum(counts.values()) + careless[0]
        messages = list(reader.iter_messages(["/robot_a/chi"]))
        numbers = [m.sequence for _, _, m in reader.iter_messages([CARELESS])]
    assert [m.sequence for _, _, m in messages] == list(range(1, COUNT + 1))
    assert all(m.publish_time <= m.log_time for _, _, m in messages)
    lost = numbers[-1] - numbers[0] + 1 - len(numbers)
    assert f", {lost} lost" in log, "what is missing is told"

    information = yaml.safe_load((tmp_path / "bag/metadata.yaml").read_text())
    information = information["rosbag2_bagfile_information"]
    assert information["custom_data"] == {"recorder_lost": str(lost)}
    offered = {
        topic["topic_metadata"]["name"]: topic["topic_metadata"]["offered_qos_profiles"][0]
        for topic in information["topics_with_message_count"]
    }
    assert offered["/robot_a/robot_description"]["durability"] == "transient_local"
    assert offered[CARELESS]["reliability"] == "best_effort"
    # The recorder had asked for reliable before this publisher came.
    assert offered["/robot_b/ee_target"]["reliability"] == "best_effort"
    assert read_run(tmp_path / "bag").lost == lost


def test_a_killed_recorder_leaves_a_readable_bag(recorder, sent, tmp_path):
    time.sleep(1.2)  # it hands complete chunks over once a second
    recorder.kill()
    recorder.communicate(timeout=20)
    run = read_run(tmp_path / "bag")
    assert not run.complete
    assert list(run.plant.tick) == list(range(len(run.plant.tick))), "nothing between is missing"
    assert COUNT // 2 < len(run.plant.tick) <= COUNT


@pytest.mark.parametrize(
    "recorder",
    [
        {"storage_preset_profile": preset, "max_bag_size": 60_000}
        for preset in ("none", "fastwrite", "zstd_fast")
    ],
    indirect=True,
    ids=lambda values: values["storage_preset_profile"],
)
def test_a_kill_leaves_a_readable_bag_also_split_and_compressed(recorder, sent, tmp_path):
    time.sleep(1.2)
    recorder.kill()
    recorder.communicate(timeout=20)
    assert len(list((tmp_path / "bag").glob("bag_*.mcap"))) > 2
    run = read_run(tmp_path / "bag")
    assert not run.complete
    assert list(run.plant.tick) == list(range(len(run.plant.tick))), "nothing between is missing"
    assert COUNT // 2 < len(run.plant.tick) <= COUNT


@pytest.mark.parametrize(
    "recorder",
    [{"regex": '"state|chi$|found"', "exclude_topics": "/robot_a/chi", "max_bag_duration": 0.2}],
    indirect=True,
)
@pytest.mark.parametrize("sent", [["/plant/state", CARELESS]], indirect=True)
def test_topics_are_selected_and_files_split_by_time(recorder, sent, tmp_path):
    recorder.send_signal(signal.SIGINT)
    _, log = recorder.communicate(timeout=20)
    assert "/robot_a/chi is left out: the bag cannot be analysed" in log
    with AnyReader([tmp_path / "bag"]) as reader:
        counts = {c.topic: c.msgcount for c in reader.connections}
        seen = sum(1 for _ in reader.messages())
    assert counts.keys() == {"/plant/state", CARELESS}
    assert counts["/plant/state"] == sent["/plant/state"]
    assert 0 < counts[CARELESS] <= sent[CARELESS]
    assert seen == sum(counts.values())
    information = yaml.safe_load((tmp_path / "bag/metadata.yaml").read_text())
    files = information["rosbag2_bagfile_information"]["files"]
    assert len(files) > 2
    assert all(entry["duration"]["nanoseconds"] <= 0.2e9 for entry in files)
