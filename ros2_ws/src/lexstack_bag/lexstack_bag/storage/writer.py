"""Writes a bag exactly as ``ros2 bag record -s mcap`` does, and with it what analysis needs."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

from lexstack_bag.errors import BagError
from lexstack_bag.storage.definitions import message_definition
from lexstack_bag.storage.folders import writing
from lexstack_bag.storage.mcap_file import McapFile
from lexstack_bag.storage.metadata import Extent, Topic, bag_information, to_yaml
from lexstack_bag.storage.presets import PRESETS, Storage

SCENARIO_RECORD = "lexstack"  # name of the Metadata record with the scenario and the versions
CLOSING_RECORD = "lexstack_recorder"  # name of the one with the losses; only a closed bag has it

_PLAIN = Storage()


class BagWriter:
    """One rosbag2 folder that is being written: ``FOLDER_0.mcap`` and on, ``metadata.yaml``.

    Every file has the scenario and all definitions before its messages, and full chunks go to the
    disk as they fill: each file says by itself what it is, and one without its end can still be
    read. ``close`` adds index, summary and ``metadata.yaml``; it may be called twice.
    """

    def __init__(
        self, folder: Path, provenance: Mapping[str, str], storage: Storage = _PLAIN
    ) -> None:
        """Create the bag.

        Args:
            folder: must not exist, or be empty.
            provenance: stored in the Metadata record ``lexstack``: ``scenario`` (resolved, YAML),
                ``seed``, ``mode`` and versions.
            storage: compression, and when a new file begins.

        Raises:
            BagError: the folder holds something, or cannot be made.
        """
        self.folder = folder
        self.extent = Extent()
        self._provenance = dict(provenance)
        self._storage = storage
        self._topics: dict[str, Topic] = {}
        self._channels: dict[str, int] = {}  # of the present file
        self._schemas: dict[str, int] = {}
        self._extents: dict[str, Extent] = {}  # by file name
        with writing(folder):
            folder.mkdir(parents=True, exist_ok=True)
            if any(folder.iterdir()):
                raise BagError(f"{folder}: is not empty; a bag is never overwritten")
        self._open()

    def __enter__(self) -> BagWriter:
        """Return itself."""
        return self

    def __exit__(self, *_error: object) -> None:
        """Close the bag."""
        self.close()

    @property
    def closed(self) -> bool:
        """Whether the bag is complete."""
        return self._file.closed

    @property
    def files(self) -> tuple[Path, ...]:
        """The files so far, in order; the last is being written."""
        return tuple(self.folder / name for name in self._extents)

    def add_topic(self, topic: Topic) -> None:
        """Announce a topic; its messages may follow. A topic that is known stays as it is.

        Raises:
            BagError: the definition of its type is not installed.
        """
        if topic.name not in self._topics:
            self._define(topic)
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
        with writing(self._path):
            begun = self._extent.start if self._extent.total else received
            if self._storage.is_full(self._file.size, 1e-9 * (received - begun)):
                self._split()
            # The container's field has 32 bits.
            number = sequence & 0xFFFFFFFF
            self._file.add_message(self._channels[topic], number, received, published, data)
        self._extent.add(topic, received)
        self.extent.add(topic, received)

    def flush(self) -> None:
        """Hand to the operating system what has waited long enough; raises BagError."""
        with writing(self._path):
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
            self._file.add_metadata(
                CLOSING_RECORD, {**custom, "recorder_lost_by_topic": json.dumps(by_topic)}
            )
        with writing(self.folder):
            information = self._end_file(custom)
            # Renamed into place: whoever sees metadata.yaml sees all of it, and a whole .mcap.
            draft = self.folder / ".metadata.yaml"
            text = to_yaml({"rosbag2_bagfile_information": information})
            draft.write_text(text, encoding="utf-8")
            draft.replace(self.folder / "metadata.yaml")

    def _open(self) -> None:
        """Begin the next file, with all that it needs to be understood alone."""
        self._path = self.folder / f"{self.folder.name}_{len(self._extents)}.mcap"
        self._extent = self._extents[self._path.name] = Extent()
        self._schemas = {}
        with writing(self._path):
            self._file = McapFile(self._path, PRESETS[self._storage.preset])
            self._file.add_metadata(SCENARIO_RECORD, self._provenance)
            for topic in self._topics.values():
                self._define(topic)

    def _split(self) -> None:
        """Complete the present file and begin the next."""
        self._end_file({})
        self._open()

    def _end_file(self, custom: Mapping[str, str]) -> dict[str, object]:
        """Complete the present file and return what there is to say about the bag so far."""
        information = bag_information(
            self._extents,
            list(self._topics.values()),
            self.extent,
            custom,
            self._provenance.get("ros_distro", "jazzy"),
        )
        self._file.add_metadata("rosbag2", {"serialized_metadata": to_yaml(information)})
        self._file.close()
        return information

    def _define(self, topic: Topic) -> None:
        """Describe a topic in the present file."""
        if topic.type not in self._schemas:
            text = message_definition(topic.type)
            self._schemas[topic.type] = self._file.add_schema(topic.type, text)
        self._channels[topic.name] = self._file.add_channel(
            topic.name,
            self._schemas[topic.type],
            {
                "offered_qos_profiles": to_yaml(topic.qos_list()),
                "topic_type_hash": topic.type_hash,
            },
        )
