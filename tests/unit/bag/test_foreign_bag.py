"""Bags that another recorder wrote: the scenario is a message in them, not a Metadata record."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from rosbags.rosbag2 import StoragePlugin, Writer

from lexstack_bag.commands.analyze import analyze, main
from lexstack_bag.commands.replay import replay
from lexstack_bag.errors import BagError
from lexstack_bag.replay.changes import Changes
from lexstack_bag.run.reader import read_provenance, read_run
from lexstack_bag.storage.container import Container, find_files
from lexstack_bag.storage.definitions import message_definition
from lexstack_bag.topics import SCENARIO

STRING = "std_msgs/msg/String"


@pytest.fixture(autouse=True)
def no_pictures(monkeypatch):
    monkeypatch.setitem(sys.modules, "lexstack_sim.render", None)


def copied(synthetic, folder, scenario, cells=("",)):
    """Copy the messages of a bag with a writer of rosbags' own, and a scenario if there is one.

    With namespaces as ``cells`` every message stands there once below each of them.
    """
    messages = list(Container(find_files(synthetic.folder)).messages())
    with Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        if scenario is not None:
            for cell in cells:
                store_data(writer, messages[0].log_time, scenario, cell)
        known = {}
        for each, cell in ((each, cell) for each in messages for cell in cells):
            topic = f"{cell}{each.topic}"
            if topic not in known:
                kind = each.schema.name
                known[topic] = writer.add_connection(
                    topic, kind, msgdef=message_definition(kind), rihs01="RIHS01_" + "0" * 64
                )
            writer.write(known[topic], each.log_time, each.data)
    return folder


def store_data(writer, time, text, cell=""):
    """Write the scenario as the controller publishes it."""
    data = text.encode() + b"\0"
    cdr = b"\0\1\0\0" + len(data).to_bytes(4, "little") + data
    connection = writer.add_connection(
        f"{cell}{SCENARIO}", STRING, msgdef=message_definition(STRING), rihs01="RIHS01_" + "0" * 64
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


@pytest.mark.parametrize("cells", [["/cell1"], ["/cell1", ""], ["/hall/cell2"]])
def test_a_cell_in_a_namespace_is_analysed_as_one_without(synthetic, tmp_path, cells):
    folder = copied(synthetic, tmp_path / "bag", synthetic.resolved.to_yaml(), cells)
    theirs, ours = read_run(folder), read_run(synthetic.folder)
    assert np.array_equal(theirs.chi["robot_a"].chi, ours.chi["robot_a"].chi)
    assert theirs.messages.items() >= ours.messages.items()
    assert any(topic.startswith("/cell1") for topic in theirs.messages) == (cells[-1] == "")


def test_a_bag_of_two_cells_is_refused_with_what_to_do(synthetic, tmp_path):
    cells = ["/cell1", "/cell2"]
    folder = copied(synthetic, tmp_path / "bag", synthetic.resolved.to_yaml(), cells)
    with pytest.raises(BagError, match=r"runs of /cell1, /cell2; .* --regex '\^/cell1/'"):
        read_run(folder)


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
