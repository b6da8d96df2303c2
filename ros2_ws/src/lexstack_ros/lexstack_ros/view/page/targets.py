"""Targets that one drags: a gizmo at the goal of every tool and, on the floor, of every base."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import viser

from lexstack.errors import InputError
from lexstack.references import References
from lexstack.robots import Team, from_rpy
from lexstack_ros.view.orders import Known, Order
from lexstack_ros.view.page.scene import color_of, wxyz

_TOOL, _BASE = 0.28, 0.5  # m, length of the gizmos' arrows
_STREAM = 0.05  # s of wall time between two targets of one drag
_PATIENCE = 1.5  # s of wall time for a goal to come into effect, before a gizmo goes back to it
_LEAST = 1e-9


@dataclass
class _Grip:
    """One gizmo.

    Attributes:
        handle: viser's.
        robot: place in the team.
        tool: whether it is that of the tool, not of the base.
        busy_until: wall time until which it stays where the user has put it [s].
        sent: wall time of the last target of the drag [s].
    """

    handle: viser.TransformControlsHandle
    robot: int
    tool: bool
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
        self._grips = [
            self._make(server.scene, robot, tool=tool)
            for robot, model in enumerate(team.robots)
            for tool in ((True, False) if model.has_base else (True,))
        ]

    def show(self, goals: References) -> None:
        """Put all gizmos at the goals, but those that are in somebody's hand."""
        now = time.monotonic()
        for grip in self._grips:
            if now < grip.busy_until:
                continue
            if grip.tool:
                pose = goals.ee[grip.robot]
                position, rotation = tuple(pose.position), pose.rotation
            else:
                x, y, yaw = goals.base[grip.robot]
                position, rotation = (x, y, 0.0), from_rpy((0.0, 0.0, float(yaw)))
            grip.handle.position, grip.handle.wxyz = position, wxyz(rotation)
            grip.handle.visible = self.visible

    def _make(self, scene: viser.SceneApi, robot: int, *, tool: bool) -> _Grip:
        """Return one gizmo; that of a base moves on the floor and turns about the vertical."""
        flat = {} if tool else {"active_axes": (True, True, False)}
        handle = scene.add_transform_controls(
            f"/targets/{robot}/{'tool' if tool else 'base'}",
            scale=_TOOL if tool else _BASE,
            depth_test=False,
            opacity=0.9,
            visible=False,
            **flat,
        )
        red, green, blue = color_of(robot)
        scene.add_icosphere(f"{handle.name}/mark", 0.022, color=(red, green, blue))
        grip = _Grip(handle, robot, tool)

        @handle.on_update
        async def _(event: viser.TransformControlsEvent) -> None:  # in the order of the hand
            self._moved(grip, event.phase)

        return grip

    def _moved(self, grip: _Grip, phase: str) -> None:
        """Take a step of a drag: ``start``, ``update`` or ``end``."""
        now = time.monotonic()
        grip.busy_until = now + (_PATIENCE if phase == "end" else np.inf)
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
        if grip.tool:
            return self._known.tool_target(name, position, (x, y, z, w))
        yaw = float(np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)))
        return self._known.base_target(name, (*position[:2].tolist(), yaw))
