"""How a bag is stored: rosbag2's presets, files split by size and time, what a kill leaves."""

from __future__ import annotations

import contextlib
from types import SimpleNamespace

import numpy as np
import pytest
import yaml
from mcap.exceptions import EndOfFile, McapError
from mcap.reader import make_reader
from mcap.records import Channel, Message, Metadata, Schema
from mcap.stream_reader import StreamReader
from mcap.writer import Writer
from rosbags.highlevel import AnyReader

from lexstack_bag.errors import BagError
from lexstack_bag.run.reader import read_run
from lexstack_bag.storage.metadata import Topic
from lexstack_bag.storage.presets import PRESETS, Storage
from lexstack_bag.storage.writer import BagWriter


@pytest.fixture(scope="module")
def whole(synthetic):
    return read_run(synthetic.folder)


class Clock:
    """The wall's clock as the writer sees it: it stands, or goes a step at every look."""

    now, step = 100.0, 0.0

    def __call__(self):
        self.now += self.step
        return self.now


@pytest.fixture
def clock(monkeypatch):
    clock = Clock()
    monkeypatch.setattr("lexstack_bag.storage.mcap_file.time", SimpleNamespace(monotonic=clock))
    return clock


def chunks_of(path):
    with path.open("rb") as stream:
        records = StreamReader(stream, emit_chunks=True).records
        return [record for record in records if type(record).__name__ == "Chunk"]


def recovered(path, out):
    """Do as ``mcap recover`` does, with the public package: all whole records into a new file."""
    with path.open("rb") as source, out.open("wb") as target:
        writer = Writer(target)
        writer.start("ros2", "recovery")
        schemas, channels, count = {}, {}, 0
        with contextlib.suppress(EndOfFile, McapError):
            for record in StreamReader(source).records:
                if isinstance(record, Schema):
                    schemas[record.id] = writer.register_schema(
                        record.name, record.encoding, record.data
                    )
                elif isinstance(record, Channel):
                    channels[record.id] = writer.register_channel(
                        record.topic,
                        record.message_encoding,
                        schemas[record.schema_id],
                        record.metadata,
                    )
                elif isinstance(record, Message):
                    writer.add_message(
                        channels[record.channel_id],
                        record.log_time,
                        record.data,
                        record.publish_time,
                        record.sequence,
                    )
                    count += 1
                elif isinstance(record, Metadata):
                    writer.add_metadata(record.name, record.metadata)
        writer.finish()
    return count


@pytest.mark.parametrize("preset", PRESETS)
def test_every_preset_is_read_by_all(preset, write, whole, tmp_path):
    made = write(tmp_path / "bag", storage=Storage(preset))
    total = sum(made.counts.values())
    run = read_run(made.folder)
    assert run.complete
    assert run.messages == made.counts
    assert np.array_equal(run.plant.q, whole.plant.q)
    with AnyReader([made.folder]) as reader:
        read = sum(1 for c, _, data in reader.messages() if reader.deserialize(data, c.msgtype))
    assert read == total
    with (made.folder / "bag_0.mcap").open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        summary = reader.get_summary()
        assert summary.statistics.message_count == total
        assert sum(summary.statistics.channel_message_counts.values()) == total
        assert sum(1 for _ in reader.iter_messages()) == total
        assert {m.name for m in reader.iter_metadata()} >= {"lexstack", "rosbag2"}
    chunks = chunks_of(made.folder / "bag_0.mcap")
    choice = PRESETS[preset]
    assert bool(chunks) == bool(choice.chunk_bytes)
    assert {chunk.compression for chunk in chunks} <= {"" if choice.level is None else "zstd"}
    assert {chunk.uncompressed_crc != 0 for chunk in chunks} <= {choice.chunk_crc}


def test_presets_differ_in_size_as_they_promise(write, tmp_path):
    def size(preset):
        folder = write(tmp_path / preset, storage=Storage(preset)).folder
        return (folder / f"{preset}_0.mcap").stat().st_size

    sizes = {preset: size(preset) for preset in PRESETS}
    assert sizes["zstd_small"] < sizes["default"] < sizes["zstd_fast"] < 0.5 * sizes["none"]
    assert sizes["fastwrite"] < 1.1 * sizes["none"]


@pytest.mark.parametrize("preset", PRESETS)
@pytest.mark.parametrize("split", [0, 200_000])
def test_what_a_kill_leaves_is_recovered_by_mcap_and_read_by_us(
    preset, split, write, whole, tmp_path, clock
):
    clock.step = 1.0  # a second passes at every look
    made = write(tmp_path / "bag", storage=Storage(preset, split), close=False)
    files = sorted(made.folder.iterdir())
    assert not (made.folder / "metadata.yaml").exists()
    assert len(files) == 1 or split
    run = read_run(made.folder)
    assert not run.complete
    assert run.provenance["seed"] == "7"
    held = len(run.plant.tick)
    assert np.array_equal(run.plant.q, whole.plant.q[:held])
    assert held > (300 if preset == "zstd_small" else 350)
    count = sum(recovered(file, tmp_path / f"again_{file.name}") for file in files)
    assert count == sum(run.messages.values())
    (tmp_path / "again").mkdir()
    for file in files:
        (tmp_path / f"again_{file.name}").rename(tmp_path / "again" / file.name)
    again = read_run(tmp_path / "again")
    assert again.complete
    assert again.messages == run.messages
    assert np.array_equal(again.plant.q, run.plant.q)


@pytest.mark.parametrize("cut", [1, 9, 40, 300])
def test_a_file_cut_anywhere_keeps_what_is_before(cut, write, tmp_path):
    made = write(tmp_path / "bag", storage=Storage("fastwrite"), close=False)
    path = made.folder / "bag_0.mcap"
    data = path.read_bytes()
    path.write_bytes(data[:-cut])
    run = read_run(made.folder)
    assert not run.complete
    assert 300 < len(run.plant.tick) <= 400


def test_files_are_split_by_size_as_rosbag2_does(write, whole, tmp_path):
    made = write(tmp_path / "bag", storage=Storage("fastwrite", max_bag_size=100_000))
    names = [f"bag_{i}.mcap" for i in range(12)]
    information = yaml.safe_load((made.folder / "metadata.yaml").read_text())
    information = information["rosbag2_bagfile_information"]
    paths = information["relative_file_paths"]
    assert paths == names[: len(paths)]
    assert len(paths) > 4
    assert {p.name for p in made.folder.iterdir()} == {*paths, "metadata.yaml"}
    assert [entry["path"] for entry in information["files"]] == paths
    assert (
        sum(entry["message_count"] for entry in information["files"])
        == (information["message_count"])
    )
    ends = [
        entry["starting_time"]["nanoseconds_since_epoch"] + entry["duration"]["nanoseconds"]
        for entry in information["files"]
    ]
    begins = [e["starting_time"]["nanoseconds_since_epoch"] for e in information["files"]]
    assert all(end < begin for end, begin in zip(ends[:-1], begins[1:], strict=True))
    for path in paths[:-1]:
        assert 100_000 <= (made.folder / path).stat().st_size < 130_000
    run = read_run(made.folder)
    assert run.complete
    assert run.messages == made.counts
    assert run.lost == 3
    assert np.array_equal(run.plant.q, whole.plant.q)
    with AnyReader([made.folder]) as reader:
        assert {c.topic: c.msgcount for c in reader.connections} == made.counts
        assert sum(1 for _ in reader.messages()) == sum(made.counts.values())


def test_every_file_says_by_itself_what_it_is(write, tmp_path):
    made = write(tmp_path / "bag", storage=Storage(max_bag_duration=0.05))
    files = sorted(made.folder.glob("*.mcap"))
    assert len(files) == -(-sum(made.counts.values()) // 501)  # messages are 0.1 ms apart
    for file in files:
        with file.open("rb") as stream:
            reader = make_reader(stream, validate_crcs=True)
            first, *_, last = reader.iter_messages()
            assert last[2].log_time - first[2].log_time <= 0.05e9
            provenance = {m.name: m.metadata for m in reader.iter_metadata()}["lexstack"]
        assert provenance["scenario"] == made.resolved.to_yaml()
        alone = read_run(file)
        assert 0 < len(alone.plant.tick) < 400


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"preset": "zip"}, "unknown storage preset 'zip'; known: default, none, fastwrite"),
        ({"max_bag_size": 5}, "max_bag_size: must be 0"),
        ({"max_bag_size": -1}, "max_bag_size: must be 0"),
        ({"max_bag_duration": -0.1}, "max_bag_duration: must be 0"),
        ({"max_bag_duration": float("nan")}, "max_bag_duration: must be 0"),
    ],
)
def test_a_wrong_choice_is_refused(values, message):
    with pytest.raises(BagError) as error:
        Storage(**values)
    assert message in str(error.value)
    assert "\n" not in str(error.value)


def test_a_chunk_is_not_held_longer_than_promised(tmp_path, clock):
    writer = BagWriter(tmp_path / "bag", {})
    writer.add_topic(Topic("/text", "std_msgs/msg/String"))
    writer.write("/text", b"\x00\x01\x00\x00\x02\x00\x00\x00a\x00", 2, 1)

    def written():
        records = StreamReader(writer.files[0].open("rb"), emit_chunks=True).records
        count = 0
        with contextlib.suppress(EndOfFile):
            for record in records:
                count += type(record).__name__ == "Chunk"
        return count

    writer.flush()
    assert written() == 0
    clock.now += 1.0
    writer.flush()
    assert written() == 1
    writer.close()
