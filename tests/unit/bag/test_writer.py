"""The bag is one that other tools open: rosbags, mcap's own reader, and YAML readers."""

from __future__ import annotations

import errno

import pytest
import yaml
from mcap.reader import make_reader
from mcap.stream_reader import StreamReader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader

from lexstack_bag.errors import BagError
from lexstack_bag.storage.metadata import Topic
from lexstack_bag.storage.writer import BagWriter

INFINITE = {"sec": 9223372036, "nsec": 854775807}


@pytest.fixture(scope="module")
def mcap_file(synthetic):
    return synthetic.folder / "bag_0.mcap"


def test_rosbags_reads_every_message(synthetic):
    with AnyReader([synthetic.folder]) as reader:
        assert {c.topic: c.msgcount for c in reader.connections} == synthetic.counts
        seen = dict.fromkeys(synthetic.counts, 0)
        for connection, _, data in reader.messages():
            message = reader.deserialize(data, connection.msgtype)
            seen[connection.topic] += 1
            if connection.topic == "/plant/state" and message.tick == 200:
                assert message.header.stamp.sec == 2
                assert message.q[10] == pytest.approx(2.0288)
        assert seen == synthetic.counts


def test_mcap_finds_summary_statistics_index_and_checksums(synthetic, mcap_file):
    total = sum(synthetic.counts.values())
    with mcap_file.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        assert reader.get_header().profile == "ros2"
        summary = reader.get_summary()
        assert summary.statistics.message_count == total
        assert summary.statistics.chunk_count == len(summary.chunk_indexes) > 1
        assert all(index.message_index_offsets for index in summary.chunk_indexes)
        counts = {
            summary.channels[i].topic: n
            for i, n in summary.statistics.channel_message_counts.items()
        }
        assert counts == synthetic.counts
        assert sum(1 for _ in reader.iter_messages()) == total
        only = sum(1 for _ in reader.iter_messages(topics=["/robot_b/chi"]))
        assert only == synthetic.counts["/robot_b/chi"]


def test_mcaps_ros2_decoder_reads_the_definitions(mcap_file):
    with mcap_file.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        messages = reader.iter_decoded_messages(topics=["/robot_a/transition"])
        last = [decoded for _, _, _, decoded in messages][-1]
    assert (last.tick, last.to_stack, last.alpha) == (399, "reach_base", 1.0)


def test_every_chunk_has_a_checksum(mcap_file):
    with mcap_file.open("rb") as stream:
        records = StreamReader(stream, emit_chunks=True).records
        chunks = [record for record in records if type(record).__name__ == "Chunk"]
    assert chunks
    assert all(chunk.uncompressed_crc for chunk in chunks)


def test_channels_and_schemas_are_as_rosbag2_writes_them(mcap_file):
    with mcap_file.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    for channel in summary.channels.values():
        assert channel.message_encoding == "cdr"
        assert set(channel.metadata) == {"offered_qos_profiles", "topic_type_hash"}
        assert channel.metadata["topic_type_hash"].startswith("RIHS01_")
        (profile,) = yaml.safe_load(channel.metadata["offered_qos_profiles"])
        assert profile["reliability"] == "reliable"
        assert profile["durability"] == "volatile"
        assert profile["deadline"] == profile["liveliness_lease_duration"] == INFINITE
    for schema in summary.schemas.values():
        assert schema.encoding == "ros2msg"
        text = schema.data.decode()
        assert text.count("=" * 80 + "\nMSG: std_msgs/Header\n") == 1
        assert text.count("MSG: builtin_interfaces/Time\n") == 1


def test_metadata_records(synthetic, mcap_file):
    with mcap_file.open("rb") as stream:
        records = {m.name: m.metadata for m in make_reader(stream).iter_metadata()}
    assert records["lexstack"]["scenario"] == synthetic.resolved.to_yaml()
    assert records["lexstack"]["seed"] == "7"
    assert {"lexstack", "python", "ros_distro", "mujoco", "numpy", "daqp"} <= set(
        records["lexstack"]
    )
    assert records["lexstack_recorder"]["recorder_lost"] == "3"
    assert yaml.safe_load(records["rosbag2"]["serialized_metadata"])["version"] == 9


def test_metadata_yaml_has_every_key(synthetic):
    data = yaml.safe_load((synthetic.folder / "metadata.yaml").read_text())
    information = data["rosbag2_bagfile_information"]
    total = sum(synthetic.counts.values())
    assert list(information) == [
        "version",
        "storage_identifier",
        "duration",
        "starting_time",
        "message_count",
        "topics_with_message_count",
        "compression_format",
        "compression_mode",
        "relative_file_paths",
        "files",
        "custom_data",
        "ros_distro",
    ]
    assert information["message_count"] == total
    assert information["duration"]["nanoseconds"] == (total - 1) * 100_000
    assert information["relative_file_paths"] == ["bag_0.mcap"]
    assert information["custom_data"] == {"recorder_lost": "3"}
    for entry in information["topics_with_message_count"]:
        topic = entry["topic_metadata"]
        assert entry["message_count"] == synthetic.counts[topic["name"]]
        assert isinstance(topic["offered_qos_profiles"], list)


def test_a_folder_that_holds_something_is_refused(synthetic):
    with pytest.raises(BagError, match="is not empty"):
        BagWriter(synthetic.folder, {})


def test_an_unknown_type_is_refused_and_the_bag_goes_on(tmp_path):
    with BagWriter(tmp_path / "bag", {}) as writer:
        with pytest.raises(BagError, match="no_such_package/msg/Thing: no definition found"):
            writer.add_topic(Topic("/thing", "no_such_package/msg/Thing"))
        with pytest.raises(BagError, match="not a message type"):
            writer.add_topic(Topic("/thing", "std_srvs/srv/Trigger"))
        writer.add_topic(Topic("/text", "std_msgs/msg/String"))
        writer.write("/text", b"\x00\x01\x00\x00\x02\x00\x00\x00a\x00", 2, 1)
        writer.close()
        writer.close()
    with AnyReader([tmp_path / "bag"]) as reader:
        assert reader.message_count == 1


def test_a_full_disk_is_said_in_one_line(tmp_path, monkeypatch):
    writer = BagWriter(tmp_path / "bag", {})
    writer.add_topic(Topic("/text", "std_msgs/msg/String"))

    def refuse(*_arguments):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(writer._file, "add_message", refuse)
    with pytest.raises(BagError, match=r"bag_0.mcap: cannot be written: No space left on device"):
        writer.write("/text", b"", 2, 1)
