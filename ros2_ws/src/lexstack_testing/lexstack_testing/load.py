"""A load for ``./scripts/bench recorder``: publishes at a rate, or records as plainly as can be.

``python -m lexstack_testing.load publish --rate 10000 --bytes 500 --seconds 5 --topics 1``
``python -m lexstack_testing.load record FILE``
"""

from __future__ import annotations

import argparse
import json
import random
import signal
import struct
import sys
import time
from pathlib import Path
from typing import Any

import rclpy
from mcap.writer import Writer
from rclpy.duration import Duration
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.serialization import serialize_message
from rclpy.signals import SignalHandlerOptions
from std_msgs.msg import String

_DEPTH = 10_000  # a second of the load
_HEAD = 8  # bytes: CDR's encapsulation and the text's length
_PATIENCE = 20.0  # s of wall time for a listener
_DIFFERENT = 997  # contents, more than a chunk holds
_LETTERS = bytes(33 + value % 64 for value in range(256))
_ACK = 10.0  # s for the last acknowledgement
_TICK = 0.002  # s between two batches of messages


def topic(number: int) -> str:
    """Return the name of a topic of the load."""
    return f"/load_{number}"


def publish(rate: float, size: int, seconds: float, topics: int) -> dict[str, Any]:
    """Publish messages of ``size`` bytes, evenly in time and over the topics, once all are heard.

    Returns:
        How many were sent, in what time [s], and whether all were acknowledged in the end.
    """
    node = rclpy.create_node("load")
    qos = QoSProfile(depth=_DEPTH)
    publishers = [node.create_publisher(String, topic(i), qos) for i in range(topics)]
    end = time.monotonic() + _PATIENCE
    while not all(publisher.get_subscription_count() for publisher in publishers):
        if time.monotonic() > end:
            sys.exit("nobody listens")
        time.sleep(0.02)
    time.sleep(0.5)  # matching is mutual
    total = round(rate * seconds)
    contents = [_content(size, seed) for seed in range(_DIFFERENT)]
    begun, sent = time.monotonic(), 0
    while sent < total:
        due = min(total, int((time.monotonic() - begun) * rate) + 1)
        for number in range(sent, due):
            publishers[number % topics].publish(contents[number % _DIFFERENT])
        sent = due
        time.sleep(_TICK)
    spent = time.monotonic() - begun
    acked = [each.wait_for_all_acked(Duration(seconds=_ACK)) for each in publishers]
    node.destroy_node()
    return {"sent": total, "seconds": spent, "acked": all(acked)}


def _content(size: int, seed: int) -> bytes:
    """Return a text of ``size`` bytes in CDR that compresses to about two thirds."""
    length = size - _HEAD - 1
    text = random.Random(seed).randbytes(length).translate(_LETTERS)
    return struct.pack("<BBHI", 0, 1, 0, length + 1) + text + b"\0"


def record(path: Path) -> None:
    """Record /load_0 as a first attempt would: message by message, decoded, no numbers."""
    flag = [False]

    def stop(_number: int, _frame: object) -> None:
        flag[0] = True

    signal.signal(signal.SIGINT, stop)
    node = Node("plain_recorder")
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start("ros2", "plain")
        schema = writer.register_schema("std_msgs/msg/String", "ros2msg", b"string data\n")
        channel = writer.register_channel(topic(0), "cdr", schema)

        def write(message: String) -> None:
            now = time.time_ns()
            writer.add_message(channel, now, serialize_message(message), now)

        node.create_subscription(String, topic(0), write, QoSProfile(depth=_DEPTH))
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        print("ready", flush=True)
        while not flag[0]:
            executor.spin_once(timeout_sec=0.2)
        writer.finish()


def main() -> int:
    """Run the command."""
    parser = argparse.ArgumentParser(description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    load = commands.add_parser("publish")
    load.add_argument("--rate", type=float, default=10_000.0, help="messages per second")
    load.add_argument("--bytes", type=int, default=500, help="of each message, in CDR")
    load.add_argument("--seconds", type=float, default=5.0)
    load.add_argument("--topics", type=int, default=1)
    commands.add_parser("record").add_argument("file", type=Path)
    options = parser.parse_args()
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    if options.command == "record":
        record(options.file)
    else:
        sent = publish(options.rate, options.bytes, options.seconds, options.topics)
        print(json.dumps(sent), flush=True)
    rclpy.try_shutdown()
    return 0


if __name__ == "__main__":
    sys.exit(main())
