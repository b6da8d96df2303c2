"""Targets that one drags: a gizmo at the goal of every tool and, on the floor, of every base.

Frames that tasks of the stacks in effect move have one too, for as long as they do.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import viser

from lexstack.errors import InputError
from lexstack.references import TOOL, Frame, References
from lexstack.robots import Pose, Team, from_rpy
from lexstack_ros.view.orders import Known, Order
from lexstack_ros.view.page.scene import color_of, wxyz

_TOOL, _FRAME, _BASE = 0.28, 0.2, 0.5  # m, length of the gizmos' arrows
_STREAM = 0.05  # s of wall time between two targets of one drag
_PATIENCE = 1.5  # s of wall time for a goal to come into effect, before a gizmo goes back to it
_HELD = 30.0  # s of wall time after which a hand that has not moved counts as gone with its page
_LEAST = 1e-9
_OF_BASE = ""
_NONE: Mapping[Frame, Pose] = {}


@dataclass
class _Grip:
    """One gizmo.

    Attributes:
        handle: viser's.
        robot: place in the team.
        frame: that it is of, one of the robot's; '': of the base.
        busy_until: wall time until which it stays where the user has put it [s].
        sent: wall time of the last target of the drag [s].
    """

    handle: viser.TransformControlsHandle
    robot: int
    frame: str
    busy_until: float = 0.0
    sent: float = 0.0


class Targets:
    """The gizmos of a team.

    Attributes:
        streams: whether a target follows the hand; otherwise it is sent when it is let go.
        visible: whether the gizmos are to be seen.
    """

    def __init__(
        self,
        server: viser.ViserServer,
        team: Team,
        known: Known,
        ask: Callable[[Order], None],
        refuse: Callable[[str], None],
    ) -> None:
        """Make them, hidden before the first goals.

        Args:
            server: viser's.
            team: the robots.
            known: checks what browsers send.
            ask: takes a target that a user has set; called by viser's threads.
            refuse: takes the reason why one cannot be; as well.
        """
        self.streams, self.visible = False, True
        self._team, self._known, self._ask, self._refuse = team, known, ask, refuse
        self._scene, self._made = server.scene, 0
        self._grips = [
            self._make(robot, frame)
            for robot, model in enumerate(team.robots)
            for frame in ((TOOL, _OF_BASE) if model.has_base else (TOOL,))
        ]
        self._frames: dict[Frame, _Grip] = {}

    def show(self, goals: References, frames: Mapping[Frame, Pose] = _NONE) -> None:
        """Put all gizmos at the goals, but those that are in somebody's hand.

        Args:
            goals: of tools and bases.
            frames: goals of the further frames that have one now.
        """
        for gone in self._frames.keys() - frames.keys():
            self._frames.pop(gone).handle.remove()
        for frame in frames.keys() - self._frames.keys():
            self._frames[frame] = self._make(*frame)
        for grip in self._grips:
            if grip.frame == TOOL:
                self._place(grip, goals.ee[grip.robot])
            else:
                x, y, yaw = map(float, goals.base[grip.robot])
                self._place(grip, Pose(np.array([x, y, 0.0]), from_rpy((0.0, 0.0, yaw))))
        for frame, pose in frames.items():
            self._place(self._frames[frame], pose)

    def _place(self, grip: _Grip, pose: Pose) -> None:
        """Put a gizmo somewhere, unless it is in somebody's hand."""
        if time.monotonic() < grip.busy_until:
            return
        grip.handle.position, grip.handle.wxyz = tuple(pose.position), wxyz(pose.rotation)
        grip.handle.visible = self.visible

    def _make(self, robot: int, frame: str) -> _Grip:
        """Return one gizmo; that of a base moves on the floor and turns about the vertical."""
        flat = {} if frame else {"active_axes": (True, True, False)}
        self._made += 1
        handle = self._scene.add_transform_controls(
            f"/targets/{self._made}",  # no name of a robot or frame: no text is a path
            scale=_TOOL if frame == TOOL else _FRAME if frame else _BASE,
            depth_test=False,
            opacity=0.9,
            visible=False,
            **flat,
        )
        red, green, blue = color_of(robot)
        radius = 0.022 if frame in (TOOL, _OF_BASE) else 0.014
        self._scene.add_icosphere(f"{handle.name}/mark", radius, color=(red, green, blue))
        grip = _Grip(handle, robot, frame)

        @handle.on_update
        async def _(event: viser.TransformControlsEvent) -> None:  # in the order of the hand
            self._moved(grip, event.phase)

        return grip

    def _moved(self, grip: _Grip, phase: str) -> None:
        """Take a step of a drag: ``start``, ``update`` or ``end``."""
        now = time.monotonic()
        grip.busy_until = now + (_PATIENCE if phase == "end" else _HELD)
        follows = self.streams and phase == "update" and now - grip.sent >= _STREAM
        if phase != "end" and not follows:
            return
        grip.sent = now
        try:
            self._ask(self._order(grip))
        except InputError as error:
            self._refuse(str(error))

    def _order(self, grip: _Grip) -> Order:
        """Return where a gizmo is as a target; raises InputError."""
        name = self._team.names[grip.robot]
        position = grip.handle.position
        w, x, y, z = grip.handle.wxyz.tolist()
        norm = max(float(np.linalg.norm([w, x, y, z])), _LEAST)
        w, x, y, z = (value / norm for value in (w, x, y, z))
        if grip.frame:
            return self._known.tool_target(name, position, (x, y, z, w), grip.frame)
        yaw = float(np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)))
        return self._known.base_target(name, (*position[:2].tolist(), yaw))
