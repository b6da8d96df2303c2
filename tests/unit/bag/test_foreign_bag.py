"""Bags that another recorder wrote: the scenario is a message in them, not a Metadata record."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from rosbags.rosbag2 import StoragePlugin, Writer

from lexstack_bag.commands.analyze import analyze, main
from lexstack_bag.commands.replay import replay
from lexstack_bag.replay.changes import Changes
from lexstack_bag.run.reader import read_provenance, read_run
from lexstack_bag.storage.container import Container, find_files
from lexstack_bag.storage.definitions import message_definition
from lexstack_bag.topics import SCENARIO

STRING = "std_msgs/msg/String"


@pytest.fixture(autouse=True)
def no_pictures(monkeypatch):
    monkeypatch.setitem(sys.modules, "lexstack_sim.render", None)


def copied(synthetic, folder, scenario):
    """Copy the messages of a bag with a writer of rosbags' own, and a scenario if there is one."""
    messages = list(Container(find_files(synthetic.folder)).messages())
    with Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        if scenario is not None:
            store_data(writer, messages[0].log_time, scenario)
        known = {}
        for each in messages:
            if each.topic not in known:
                kind = each.schema.name
                known[each.topic] = writer.add_connection(
                    each.topic, kind, msgdef=message_definition(kind), rihs01="RIHS01_" + "0" * 64
                )
            writer.write(known[each.topic], each.log_time, each.data)
    return folder


def store_data(writer, time, text):
    """Write the scenario as the controller publishes it."""
    data = text.encode() + b"\0"
    cdr = b"\0\1\0\0" + len(data).to_bytes(4, "little") + data
    connection = writer.add_connection(
        SCENARIO, STRING, msgdef=message_definition(STRING), rihs01="RIHS01_" + "0" * 64
    )
    writer.write(connection, time, cdr)


@pytest.fixture(scope="module")
def foreign(synthetic, tmp_path_factory):
    folder = tmp_path_factory.mktemp("foreign") / "bag"
    return copied(synthetic, folder, synthetic.resolved.to_yaml())


def test_a_bag_of_another_recorder_is_analysed_with_the_published_scenario(
    foreign, synthetic, tmp_path
):
    container = Container(find_files(foreign))
    assert container.first_metadata("lexstack") == {}
    theirs, ours = analyze(foreign, tmp_path / "one"), analyze(synthetic.folder, tmp_path / "two")
    assert theirs.phases == ours.phases
    assert theirs.scenario == "transition-sequence"
    page = (tmp_path / "one" / "report.html").read_text(encoding="utf-8")
    assert "Made with versions that the bag does not name" in page


def test_a_bag_of_another_recorder_is_replayed(foreign, synthetic):
    run, outcomes = replay(foreign, Changes((), "", "", ""), ["robot_a"])
    _, expected = replay(synthetic.folder, Changes((), "", "", ""), ["robot_a"])
    assert run.resolved == synthetic.resolved
    assert np.array_equal(outcomes[0].replayed, expected[0].replayed, equal_nan=True)


def test_a_record_of_our_own_comes_before_the_message(synthetic):
    facts, resolved = read_provenance(Container(find_files(synthetic.folder)))
    assert facts["mode"] == "lockstep"
    assert resolved == synthetic.resolved


def test_a_bag_without_any_scenario_gets_one_clear_line(synthetic, tmp_path, capsys):
    folder = copied(synthetic, tmp_path / "bag", None)
    assert main([str(folder)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.endswith(
        "not a lexstack bag: it holds neither a Metadata record 'lexstack' nor a message of "
        "/robot_a/scenario; record that topic too (ros2 bag record -a does)"
    )


@pytest.mark.parametrize("text", ["", "no: scenario", "{"])
def test_a_published_scenario_that_is_none_gets_one_line(synthetic, tmp_path, capsys, text):
    folder = copied(synthetic, tmp_path / "bag", text)
    assert main([str(folder)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("analyze: ")


def test_the_states_of_such_a_bag_are_all_there(foreign):
    assert len(read_run(foreign).plant.tick) == 400
