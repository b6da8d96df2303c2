"""What a user chooses of a recording, named and meant as the options of ``ros2 bag record``.

As parameters of the recorder, and as arguments of the commands that start one.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import dataclass
from pathlib import Path

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.exceptions import InvalidParameterTypeException, ParameterException
from rclpy.node import Node

from lexstack.errors import ConfigurationError
from lexstack_bag.errors import BagError
from lexstack_bag.storage.presets import DEFAULT_PRESET, PRESETS, Storage
from lexstack_bag.storage.selection import Selection
from lexstack_ros.node.parameters import text_parameter

_LARGEST = 2**50  # bytes
_LONGEST = 1e7  # s
_LISTS = {
    "topics": "take these topics",
    "exclude_topics": "leave these topics out",
    "exclude_topic_types": "leave out topics of these types, pkg/msg/Type",
}
_EXPRESSIONS = {
    "regex": "take topics whose name contains this expression",
    "exclude_regex": "leave out topics whose name contains this expression",
}


@dataclass(frozen=True, slots=True)
class RecordingOptions:
    """What a user chooses of a recording.

    Attributes:
        output: folder of the bag.
        storage: compression and splitting.
        selection: which topics.
        expected: name and type of topics to subscribe to before anybody publishes.
    """

    output: Path
    storage: Storage
    selection: Selection
    expected: dict[str, str]

    @classmethod
    def of(cls, node: Node) -> RecordingOptions:
        """Declare and read the parameters; raises ConfigurationError for one that is wrong."""
        output = text_parameter(node, "output", "folder of the bag, must not hold anything")
        expected = text_parameter(
            node, "expected_topics", "topics to wait for besides lexstack's own: NAME:TYPE, ...", ""
        )
        lists = {
            key: _items(text_parameter(node, key, f"{what}, comma-separated", ""))
            for key, what in _LISTS.items()
        }
        expressions = {
            key: text_parameter(node, key, what, "") for key, what in _EXPRESSIONS.items()
        }
        try:
            return cls(
                Path(output), _storage(node), Selection(**lists, **expressions), _pairs(expected)
            )
        except (BagError, InvalidParameterTypeException) as error:
            raise ConfigurationError(f"{node.get_name()}: {error}") from error
        except ParameterException as error:
            raise ConfigurationError(
                f"{node.get_name()}: {' '.join(str(error).split())}"
            ) from error


def add_recording_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of ``ros2 bag record`` that the recorder knows."""
    group = parser.add_argument_group("recording, as with ros2 bag record")
    group.add_argument(
        "--storage-preset-profile",
        choices=tuple(PRESETS),
        default=DEFAULT_PRESET,
        help="compression (default: %(default)s, small chunks with zstd)",
    )
    group.add_argument(
        "--max-bag-size", type=int, default=0, metavar="BYTES", help="split files at this size"
    )
    group.add_argument(
        "--max-bag-duration", type=float, default=0.0, metavar="S", help="split files at this time"
    )
    for key, what in _LISTS.items():
        group.add_argument(_flag(key), nargs="+", default=[], metavar="NAME", help=what)
    for key, what in _EXPRESSIONS.items():
        group.add_argument(_flag(key), default="", metavar="EXPRESSION", help=what)


def recorder_parameters(options: argparse.Namespace) -> dict[str, str]:
    """Return the recorder's parameters for such arguments; raises ConfigurationError."""
    lists = {key: tuple(getattr(options, key)) for key in _LISTS}
    expressions = {key: getattr(options, key) for key in _EXPRESSIONS}
    try:
        Selection(**lists, **expressions)
        Storage(options.storage_preset_profile, options.max_bag_size, options.max_bag_duration)
    except BagError as error:
        raise ConfigurationError(f"recording: {error}") from error
    texts = {key: ",".join(names) for key, names in lists.items()} | expressions
    texts["storage_preset_profile"] = options.storage_preset_profile
    return {
        # In quotes: ROS reads what follows := as YAML.
        **{key: json.dumps(text) for key, text in texts.items() if text},
        "max_bag_size": str(options.max_bag_size),
        "max_bag_duration": repr(float(options.max_bag_duration)),
    }


def _flag(key: str) -> str:
    """Return the argument of a parameter."""
    return "--" + key.replace("_", "-")


def _storage(node: Node) -> Storage:
    """Return compression and splitting; raises BagError."""
    preset = text_parameter(
        node,
        "storage_preset_profile",
        f"one of: {', '.join(PRESETS)}",
        DEFAULT_PRESET,
    )
    size = ParameterDescriptor(
        description="bytes of a file after which the next one begins; 0: one file",
        read_only=True,
        integer_range=[IntegerRange(from_value=0, to_value=_LARGEST, step=1)],
    )
    duration = ParameterDescriptor(
        description="seconds of a file after which the next one begins; 0: one file",
        read_only=True,
        floating_point_range=[FloatingPointRange(from_value=0.0, to_value=_LONGEST, step=0.0)],
    )
    return Storage(
        preset,
        int(node.declare_parameter("max_bag_size", 0, size).value),
        float(node.declare_parameter("max_bag_duration", 0.0, duration).value),
    )


def _items(text: str) -> tuple[str, ...]:
    """Return the items of a comma-separated list."""
    return tuple(item.strip() for item in text.split(",") if item.strip())


def _pairs(text: str) -> dict[str, str]:
    """Return names and types of ``NAME:TYPE, ...``; raises BagError."""
    pairs = [item.split(":") for item in _items(text)]
    if any(len(pair) != 2 for pair in pairs):
        raise BagError(f"expected_topics: expected NAME:TYPE, ..., got {text!r}")
    return {pair[0]: pair[1] for pair in pairs}
