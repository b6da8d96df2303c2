"""What rosbag2 writes about a bag: ``metadata.yaml``, version 9, and the QoS of its topics."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import yaml

VERSION = 9
_INFINITE = {"sec": 9223372036, "nsec": 854775807}


@dataclass(frozen=True, slots=True)
class Qos:
    """The quality of service that one publisher offers, in rosbag2's words (lower case)."""

    history: str = "unknown"
    depth: int = 0
    reliability: str = "reliable"
    durability: str = "volatile"
    deadline: Mapping[str, int] = field(default_factory=_INFINITE.copy)  # sec, nsec
    lifespan: Mapping[str, int] = field(default_factory=_INFINITE.copy)
    liveliness: str = "automatic"
    liveliness_lease_duration: Mapping[str, int] = field(default_factory=_INFINITE.copy)
    avoid_ros_namespace_conventions: bool = False

    def plain(self) -> dict[str, Any]:
        """Return it as the mapping that the YAML holds, keys in rosbag2's order."""
        keys = self.__dataclass_fields__
        values = {key: getattr(self, key) for key in keys}
        return {k: dict(v) if isinstance(v, Mapping) else v for k, v in values.items()}


@dataclass(frozen=True, slots=True)
class Topic:
    """A topic as a bag describes it."""

    name: str
    type: str  # pkg/msg/Type
    qos: tuple[Qos, ...] = ()  # one per publisher
    type_hash: str = ""  # RIHS01_...

    def qos_list(self) -> list[dict[str, Any]]:
        """Return the offered QoS profiles as plain data."""
        return [qos.plain() for qos in self.qos]


@dataclass(slots=True)
class Extent:
    """How much a bag holds: counts per topic and the span of the log times [ns since 1970]."""

    counts: dict[str, int] = field(default_factory=dict)
    total: int = 0
    start: int = 0
    end: int = 0

    def add(self, topic: str, log_time: int) -> None:
        """Count one message."""
        self.start = min(self.start, log_time) if self.total else log_time
        self.end = max(self.end, log_time)
        self.total += 1
        self.counts[topic] = self.counts.get(topic, 0) + 1


def bag_information(
    files: Mapping[str, Extent],
    topics: Sequence[Topic],
    extent: Extent,
    custom_data: Mapping[str, str],
    distro: str,
) -> dict[str, Any]:
    """Return what stands below ``rosbag2_bagfile_information`` in ``metadata.yaml``.

    Args:
        files: what each file holds, by its name, in recording order.
        topics: of the whole bag.
        extent: of the whole bag.
        custom_data: of our own.
        distro: name of the ROS distribution.
    """
    return {
        "version": VERSION,
        "storage_identifier": "mcap",
        **_span(extent),
        "message_count": extent.total,
        "topics_with_message_count": [_topic(t, extent.counts.get(t.name, 0)) for t in topics],
        "compression_format": "",
        "compression_mode": "",
        "relative_file_paths": list(files),
        "files": [
            {"path": name, **_file_span(part), "message_count": part.total}
            for name, part in files.items()
        ],
        "custom_data": dict(custom_data),
        "ros_distro": distro,
    }


def _span(extent: Extent) -> dict[str, dict[str, int]]:
    """Return duration and start of a bag, in the order of ``metadata.yaml``."""
    return {
        "duration": {"nanoseconds": extent.end - extent.start},
        "starting_time": {"nanoseconds_since_epoch": extent.start},
    }


def _file_span(extent: Extent) -> dict[str, dict[str, int]]:
    """Return start and duration of one file: the keys' order differs from that of a bag."""
    return dict(reversed(_span(extent).items()))


def _topic(topic: Topic, count: int) -> dict[str, Any]:
    """Return one entry of ``topics_with_message_count``."""
    return {
        "topic_metadata": {
            "name": topic.name,
            "type": topic.type,
            "serialization_format": "cdr",
            "offered_qos_profiles": topic.qos_list(),
            "type_description_hash": topic.type_hash,
        },
        "message_count": count,
    }


def to_yaml(data: Any) -> str:
    """Return block-style YAML with the keys in their order."""
    return yaml.dump(data, Dumper=_Dumper, sort_keys=False, default_flow_style=False)


class _Dumper(yaml.SafeDumper):
    """A dumper that never writes anchors: rosbag2's readers need none."""

    def ignore_aliases(self, _data: Any) -> bool:
        """Write every value in full."""
        return True
