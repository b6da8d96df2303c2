"""The pose of a platform from /tf, through any number of transforms, as tf2 finds the newest."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from lexstack.errors import InputError
from lexstack.options import shown
from lexstack.robots import to_quaternion
from lexstack_config.plant_file import BaseTransformConfig
from lexstack_plant.hardware.base_intake import BaseSample
from lexstack_ros.intake.transforms import Transforms


class TransformIntake:
    """Hears of the frames between a platform and the one that its pose is taken in."""

    def __init__(self, config: BaseTransformConfig) -> None:
        """Know nothing yet."""
        self._frame, self._parent = config.frame, config.parent.lstrip("/")
        self._transforms = Transforms()
        self._chain = {self._frame}

    def hear(
        self, entries: Sequence[Any], received: float, *, static: bool = False
    ) -> BaseSample | None:
        """Take a message's transforms; return the pose, at the newest time that all are known of.

        Args:
            entries: geometry_msgs/TransformStamped.
            received: s by the local clock.
            static: whether they do not move.

        Returns:
            the pose without a velocity; None: nothing is new, or not all is known.

        Raises:
            InputError: a transform of ours is none.
        """
        # Of what does not move all is kept, as it comes but once; else only what is on the way.
        mine = [e for e in entries if static or e.child_frame_id.lstrip("/") in self._chain]
        if not mine:
            return None
        refused = self._transforms.refused
        self._transforms.hear(mine, static=static)
        if self._transforms.refused > refused and not static:
            raise InputError(f"a transform between {self._names()} is none")
        self._chain = set(self._transforms.chain(self._frame))
        found = self._transforms.newest(self._frame, self._parent)
        if found is None:
            return None
        stamp, pose = found
        x, y, _ = pose.position.tolist()
        turn = to_quaternion(pose.rotation).tolist()
        return BaseSample(x, y, turn, None, stamp, received, self._parent)

    def _names(self) -> str:
        """Return the two frames, for errors."""
        return f"{shown(self._frame)} and {shown(self._parent)}"
