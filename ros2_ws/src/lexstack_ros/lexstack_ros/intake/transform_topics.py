"""/tf and /tf_static as the controller hears them: of the plant's tree only what it has to know."""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence

from geometry_msgs.msg import TransformStamped
from rclpy.node import Node
from rclpy.serialization import deserialize_message
from tf2_msgs.msg import TFMessage

from lexstack_ros.intake.frames import Frames
from lexstack_ros.messages.cdr_layout import HEAD, CdrError, Layout, fields_of
from lexstack_ros.messages.qos import STATIC_TRANSFORMS, TRANSFORMS

Owns = Callable[[str], bool]


class _OtherFrames:
    """Of a tree that a plant tells, the few frames that are none of its robots' own.

    The plant tells the frames of all links, fifty times a second, and a message of them takes a
    millisecond to decode. Nearly all are known from its states; the others are read where they
    stand in the bytes.
    """

    def __init__(self, data: bytes, transforms: Sequence[TransformStamped], owns: Owns) -> None:
        """Look at a message; ``owns`` says of a frame whether it is known otherwise."""
        self._layout = layout = Layout(fields_of(TFMessage), data)
        places = {number.path: HEAD + number.place for number in layout.numbers}
        self._stamp, self._pose = (struct.Struct(layout.order + code) for code in ("iI", "7d"))
        self._others = [
            (
                each.header.frame_id,
                each.child_frame_id,
                places[f"transforms.{i}.header.stamp.sec"],
                places[f"transforms.{i}.transform.translation.x"],
            )
            for i, each in enumerate(transforms)
            if not owns(each.child_frame_id)
        ]

    def fits(self, data: bytes) -> bool:
        """Return whether another message tells the same frames."""
        return self._layout.fits(data)

    def read(self, data: bytes) -> list[TransformStamped]:
        """Return the transforms of a message of these frames that must be heard."""
        return [self._transform(data, *other) for other in self._others]

    def _transform(
        self, data: bytes, parent: str, child: str, stamp: int, pose: int
    ) -> TransformStamped:
        """Return one transform from where its numbers stand."""
        message = TransformStamped(child_frame_id=child)
        message.header.frame_id = parent
        time = message.header.stamp
        time.sec, time.nanosec = self._stamp.unpack_from(data, stamp)
        place, turn = message.transform.translation, message.transform.rotation
        place.x, place.y, place.z, *rest = self._pose.unpack_from(data, pose)
        turn.x, turn.y, turn.z, turn.w = rest
        return message


class _Hearing:
    """Takes the messages of /tf or /tf_static."""

    def __init__(self, frames: Frames, *, static: bool) -> None:
        """Hand transforms on to those of ``frames``."""
        self._frames = frames
        self._static = static
        self._plants: _OtherFrames | None = None  # of the last message that told robots' frames

    def __call__(self, data: bytes) -> None:
        """Take a message."""
        transforms = self._frames.transforms
        if self._plants is not None and self._plants.fits(data):
            transforms.hear(self._plants.read(data), static=self._static)
            return
        try:
            heard = deserialize_message(data, TFMessage).transforms
        except RuntimeError:  # bytes that are no message
            transforms.refused += 1
            return
        others = [each for each in heard if not self._frames.owns(each.child_frame_id)]
        if len(others) < len(heard):
            try:
                self._plants = _OtherFrames(data, heard, self._frames.owns)
            except CdrError:  # a name that is no UTF-8, or too many: decoded each time
                self._plants = None
        transforms.hear(others, static=self._static)


def listen(node: Node, frames: Frames) -> None:
    """Subscribe to /tf and /tf_static."""
    moving, static = (_Hearing(frames, static=static) for static in (False, True))
    node.create_subscription(TFMessage, "tf", moving, TRANSFORMS, raw=True)
    node.create_subscription(TFMessage, "tf_static", static, STATIC_TRANSFORMS, raw=True)
