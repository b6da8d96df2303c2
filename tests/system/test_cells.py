"""Two cells side by side in one domain: each has names of its own, and neither hears the other."""

from __future__ import annotations

import json
import os
import subprocess
import sys

import pytest
from rosbags.highlevel import AnyReader

from lexstack_bag.commands import replay
from lexstack_bag.run.reader import read_run
from lexstack_bringup.domain import own_domain
from support.runs import chi_by_tick, short_scenario

pytestmark = pytest.mark.system
CELLS = {"cell1": ["--namespace", "cell1"], "cell2": ["--namespace", "/cell2", "--roles"]}
COMMAND = {"cell1": "/cell1/robot_a/chi", "cell2": "/cell2/controller/chi"}


@pytest.fixture(scope="module")
def cells(tmp_path_factory):
    """Play the same short scenario in both at the same time; return their folders."""
    folder = tmp_path_factory.mktemp("cells")
    path = folder / "short.yaml"
    path.write_text(short_scenario(duration=3.0).to_yaml(), encoding="utf-8")
    demo = [sys.executable, "-m", "lexstack_bringup.commands.demo", str(path), "--out"]
    with own_domain() as domain:
        environment = {**os.environ, "ROS_DOMAIN_ID": str(domain)}
        running = {
            name: subprocess.Popen(
                [*demo, str(folder / name), *how],
                env=environment,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
            )
            for name, how in CELLS.items()
        }
        printed = {name: process.communicate(timeout=100)[0] for name, process in running.items()}
    for name, process in running.items():
        assert process.returncode == 0, printed[name]
    return {name: folder / name for name in CELLS}


def recorded(folder):
    """Return all messages of a bag by the names that they had on the wire."""
    found = {}
    with AnyReader([folder / "bag"]) as reader:
        for connection, _, data in reader.messages():
            message = reader.deserialize(data, connection.msgtype)
            found.setdefault(connection.topic, []).append(message)
    return found


@pytest.mark.parametrize("name", CELLS)
def test_a_cell_has_names_of_its_own_and_one_sender_of_a_kind(cells, name):
    found = recorded(cells[name])
    assert all(topic.startswith(f"/{name}/") for topic in found)
    command = COMMAND[name]
    senders = {state.sender for state in found[f"/{name}/plant/state"]}
    commanders = {chi.sender for chi in found[command]}
    assert len(senders) == len(commanders) == 1
    told = {state.commander for state in found[f"/{name}/plant/state"]} - {""}
    assert told == commanders


@pytest.mark.parametrize("name", CELLS)
def test_nothing_of_the_other_cell_is_heard(cells, name):
    """A state or command of the other would be refused and counted: its sender is another one."""
    found = recorded(cells[name])
    statuses = [status for each in found[f"/{name}/diagnostics"] for status in each.status]
    assert {status.name.partition("/")[0] for status in statuses} == {name}
    refused = [
        (value.key, value.value)
        for status in statuses
        for value in status.values
        if value.key.startswith("refused")
    ]
    assert refused
    assert {value for _, value in refused} == {"0"}
    for log in (cells[name] / "logs").iterdir():
        assert "refused" not in log.read_text(encoding="utf-8"), log


def test_both_give_the_same_bits(cells):
    first, second = (chi_by_tick(cells[name] / "bag", COMMAND[name]) for name in CELLS)
    assert len(first) == 300
    assert first == second


@pytest.mark.parametrize("name", CELLS)
def test_their_bags_are_analysed_and_replayed_as_any_other(cells, name, capsys):
    metrics = json.loads((cells[name] / "metrics.json").read_text(encoding="utf-8"))
    assert metrics["ticks"] == 300
    assert metrics["missing_ticks"] == metrics["recorder_lost"] == 0
    assert (cells[name] / "report.html").is_file()
    run = read_run(cells[name])
    assert {"/plant/state", "/robot_a/chi", "/robot_b/chi", "/robot_a/transition"} <= set(
        run.messages
    )
    assert replay.main([str(cells[name])]) == 0
    assert capsys.readouterr().out.count("identical") == 2
