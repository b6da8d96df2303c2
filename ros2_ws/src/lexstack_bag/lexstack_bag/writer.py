"""Writes a bag exactly as ``ros2 bag record -s mcap`` does, and with it what analysis needs."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType

from mcap.writer import CompressionType, Writer

from lexstack_bag.definitions import message_definition
from lexstack_bag.errors import BagError
from lexstack_bag.metadata import Extent, Topic, bag_information, to_yaml

SCENARIO_RECORD = "lexstack"  # name of the Metadata record with the scenario and the versions
CLOSING_RECORD = "lexstack_recorder"  # name of the one with the losses; only a closed bag has it

# Small chunks: what a killed recorder takes with it is at most this much.
_CHUNK_BYTES = 256 * 1024


class BagWriter:
    """One rosbag2 folder that is being written: ``FOLDER/FOLDER_0.mcap`` and ``metadata.yaml``.

    The scenario and all definitions stand before the messages and full chunks go to the disk as
    they fill, so that a bag without its end can still be read. ``close`` adds index, summary and
    ``metadata.yaml``; it may be called twice.
    """

    def __init__(self, folder: Path, facts: Mapping[str, str]) -> None:
        """Create the bag.

        Args:
            folder: must not exist, or be empty.
            facts: stored in the Metadata record ``lexstack``: ``scenario`` (resolved, YAML),
                ``seed``, ``mode`` and versions.

        Raises:
            BagError: the folder holds something, or cannot be made.
        """
        self.folder = folder
        self.path = folder / f"{folder.name}_0.mcap"
        self.extent = Extent()
        self._distro = facts.get("ros_distro", "jazzy")
        self._topics: dict[str, Topic] = {}
        self._channels: dict[str, int] = {}
        self._schemas: dict[str, int] = {}
        with _writing(folder):
            folder.mkdir(parents=True, exist_ok=True)
            if any(folder.iterdir()):
                raise BagError(f"{folder}: is not empty; a bag is never overwritten")
            self._file = self.path.open("xb")
        self._writer = Writer(self._file, chunk_size=_CHUNK_BYTES, compression=CompressionType.ZSTD)
        self._writer.start(profile="ros2", library="lexstack_bag")
        self._writer.add_metadata(SCENARIO_RECORD, dict(facts))

    def __enter__(self) -> BagWriter:
        """Return itself."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Close the bag."""
        self.close()

    @property
    def closed(self) -> bool:
        """Whether the bag is complete."""
        return self._file.closed

    def add_topic(self, topic: Topic) -> None:
        """Announce a topic; its messages may follow. A topic that is known stays as it is.

        Raises:
            BagError: the definition of its type is not installed.
        """
        if topic.name in self._topics:
            return
        if topic.type not in self._schemas:
            text = message_definition(topic.type)
            self._schemas[topic.type] = self._writer.register_schema(
                topic.type, "ros2msg", text.encode()
            )
        self._channels[topic.name] = self._writer.register_channel(
            topic.name,
            "cdr",
            self._schemas[topic.type],
            {
                "offered_qos_profiles": to_yaml(topic.qos_list()),
                "topic_type_hash": topic.type_hash,
            },
        )
        self._topics[topic.name] = topic

    def write(
        self, topic: str, data: bytes, received: int, published: int, sequence: int = 0
    ) -> None:
        """Append one message.

        Args:
            topic: one that was announced.
            data: the message in CDR, with its encapsulation header.
            received: when it arrived [ns since 1970]: the log time.
            published: when it was sent [ns since 1970].
            sequence: the publisher's number of it, from 1; 0: unknown.

        Raises:
            BagError: the disk is full, or the like.
        """
        # The container's field has 32 bits.
        channel, number = self._channels[topic], sequence & 0xFFFFFFFF
        with _writing(self.path):
            self._writer.add_message(channel, received, data, published, number)
        self.extent.add(topic, received)

    def flush(self) -> None:
        """Hand every complete chunk to the operating system; raises BagError."""
        with _writing(self.path):
            self._file.flush()

    def close(self, lost: Mapping[str, int] | None = None) -> None:
        """Complete the bag: losses, index, summary and ``metadata.yaml``.

        Args:
            lost: messages that never arrived, by topic; None: not counted.

        Raises:
            BagError: the disk is full, or the like.
        """
        if self.closed:
            return
        custom: dict[str, str] = {}
        if lost is not None:
            custom["recorder_lost"] = str(sum(lost.values()))
            by_topic = {topic: count for topic, count in lost.items() if count}
            self._writer.add_metadata(
                CLOSING_RECORD, {**custom, "recorder_lost_by_topic": json.dumps(by_topic)}
            )
        information = bag_information(
            self.path.name, list(self._topics.values()), self.extent, custom, self._distro
        )
        with _writing(self.folder):
            self._writer.add_metadata("rosbag2", {"serialized_metadata": to_yaml(information)})
            self._writer.finish()
            self._file.close()
            # Renamed into place: whoever sees metadata.yaml sees all of it, and a whole .mcap.
            draft = self.folder / ".metadata.yaml"
            text = to_yaml({"rosbag2_bagfile_information": information})
            draft.write_text(text, encoding="utf-8")
            draft.replace(self.folder / "metadata.yaml")


@contextmanager
def _writing(path: Path) -> Iterator[None]:
    """Turn what the disk refuses into a BagError."""
    try:
        yield
    except OSError as error:
        raise BagError(f"{path}: cannot be written: {error.strerror}") from error
