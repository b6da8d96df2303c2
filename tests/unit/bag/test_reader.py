"""Reading: what was written comes back; what is broken or foreign is said in one line."""

from __future__ import annotations

import numpy as np
import pytest
from mcap.reader import make_reader

from lexstack_bag.errors import BagError
from lexstack_bag.run.reader import read_run
from lexstack_bag.storage.container import Container, find_files
from lexstack_bag.storage.writer import BagWriter


def one_line(error: pytest.ExceptionInfo[BagError]) -> str:
    text = str(error.value)
    assert "\n" not in text
    return text


def test_a_run_comes_back(synthetic):
    run = read_run(synthetic.folder)
    assert run.complete
    assert run.lost == 3
    assert run.messages == synthetic.counts
    assert run.robots == ("robot_a", "robot_b")
    assert run.resolved == synthetic.resolved
    assert run.plant.q.shape == (400, 20)
    assert np.array_equal(run.plant.tick, np.arange(400))
    assert len(run.chi["robot_a"].tick) == 399
    assert run.chi["robot_b"].tick.tolist() == list(range(100, 200))
    assert np.isnan(run.chi["robot_b"].chi[20]).all()  # the solve that failed has no chi
    assert run.chi["robot_a"].reason[60] == "braking"
    assert [(t.robot, t.kind, t.time) for t in run.targets] == [
        ("robot_a", "ee", 0.5),
        ("robot_b", "base", 1.0),
        ("robot_b", "ee", 2.0),
    ]
    assert np.isnan(run.transition.gap[0])


def test_arrays_are_read_only(synthetic):
    run = read_run(synthetic.folder)
    with pytest.raises(ValueError, match="read-only"):
        run.plant.q[0, 0] = 1.0


@pytest.mark.parametrize("part", ["", "bag", "bag/bag_0.mcap"])
def test_run_folder_bag_folder_and_file_are_the_same(synthetic, part):
    assert find_files(synthetic.folder.parent / part) == [synthetic.folder / "bag_0.mcap"]


def test_a_bag_without_its_end_is_read_up_to_there(killed):
    run = read_run(killed.folder)
    assert not run.complete
    assert run.lost == 0  # nobody counted: the numbers of the messages have no gap
    assert 100 < len(run.plant.tick) < 400


def test_a_file_that_was_cut_is_read_up_to_there(synthetic, tmp_path):
    whole = (synthetic.folder / "bag_0.mcap").read_bytes()
    (tmp_path / "cut.mcap").write_bytes(whole[: len(whole) // 2])
    run = read_run(tmp_path / "cut.mcap")
    assert not run.complete
    assert len(run.plant.tick) > 10


def test_a_damaged_chunk_is_an_error(synthetic, tmp_path):
    path = synthetic.folder / "bag_0.mcap"
    with path.open("rb") as stream:
        chunk = make_reader(stream).get_summary().chunk_indexes[1]
    data = bytearray(path.read_bytes())
    data[chunk.chunk_start_offset + chunk.chunk_length // 2] ^= 0xFF
    (tmp_path / "damaged.mcap").write_bytes(data)
    with pytest.raises(BagError) as error:
        read_run(tmp_path / "damaged.mcap")
    assert "not a readable MCAP file" in one_line(error)


@pytest.mark.parametrize("content", [b"", b"hello, world: this is no bag at all"])
def test_a_file_of_another_kind(tmp_path, content):
    (tmp_path / "other.mcap").write_bytes(content)
    with pytest.raises(BagError) as error:
        read_run(tmp_path / "other.mcap")
    assert "MCAP file" in one_line(error)


def test_nothing_there(tmp_path):
    with pytest.raises(BagError, match="no such file or folder"):
        read_run(tmp_path / "missing")
    with pytest.raises(BagError, match=r"no \.mcap file"):
        read_run(tmp_path)


def test_a_bag_of_somebody_else(tmp_path):
    BagWriter(tmp_path / "bag", {}).close()
    with pytest.raises(BagError) as error:
        read_run(tmp_path)
    assert "not a lexstack bag" in one_line(error)


def test_a_bag_of_before_extensions_knows_the_methods_that_were_the_library_s(write, tmp_path):
    """Then they need not be listed; a bag that has the key lists them."""
    facts = {"scenario": "".join(lines_without_extensions(write(tmp_path / "new").resolved))}
    write(tmp_path / "old", facts=facts)
    old, new = (read_run(tmp_path / name).resolved.scenario for name in ("old", "new"))
    assert old.extensions == ("lexstack_experiments.methods", "lexstack_experiments.solvers")
    assert new.extensions == ()


def lines_without_extensions(resolved):
    """Return a resolved scenario's lines as bags had them before."""
    lines = resolved.to_yaml().splitlines(keepends=True)
    left = [line for line in lines if line != "  extensions: []\n"]
    assert len(left) == len(lines) - 1
    return left


def test_a_bag_without_a_plant(tmp_path, resolved):
    BagWriter(tmp_path / "bag", {"scenario": resolved.to_yaml()}).close()
    with pytest.raises(BagError, match="holds no message of /plant/state"):
        read_run(tmp_path)


def test_metadata_of_the_container(synthetic):
    container = Container(find_files(synthetic.folder))
    assert sum(1 for _ in container.messages()) == sum(synthetic.counts.values())
    assert container.metadata["lexstack_recorder"]["recorder_lost_by_topic"] == '{"/clock": 3}'
