"""Pictures of the robots, offscreen through EGL or OSMesa: no window, no GPU."""

from __future__ import annotations

import ctypes
import importlib
import itertools
import os
import sys
from collections.abc import Mapping, Sequence
from typing import Any, Self

import mujoco
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from lexstack.errors import LexstackError
from lexstack.robots import Pose, RobotModel, Team
from lexstack.types import Vector
from lexstack_config.parts import build_team
from lexstack_config.resolved import ResolvedScenario
from lexstack_sim.coordinates import Coordinates
from lexstack_sim.world import build_world

_SPHERE, _CAPSULE = mujoco.mjtGeom.mjGEOM_SPHERE, mujoco.mjtGeom.mjGEOM_CAPSULE
_BALL = np.array([0.95, 0.8, 0.1, 0.9], np.float32)
_AXIS = 0.16  # m, length of a drawn axis
_ARM_HEIGHT = 0.75  # m, of the elbow above the mount, at most about this
_LINK = 0.06  # m, half the thickness of a link
_MARGIN = 1.1

Image = NDArray[np.uint8]

_LIBRARIES = {"egl": "libEGL.so.1", "osmesa": "libOSMesa.so.8"}
_ADVICE = "install libegl1 libgl1-mesa-dri libgl1, or libosmesa6"


class RenderError(LexstackError):
    """Nothing on this machine renders offscreen; the text says what to install."""


def snapshots(
    resolved: ResolvedScenario,
    qs: Sequence[Vector],
    targets: Sequence[Mapping[str, Pose]] | None = None,
    stamps: Sequence[float] | None = None,
    size: tuple[int, int] = (960, 540),
) -> list[Image]:
    """Return one picture per configuration, all from the same place.

    Args:
        resolved: the scenario with its robots.
        qs: configurations, shape (n,) each.
        targets: for each picture the end-effector targets by robot, drawn as frames; None: none.
        stamps: for each picture its simulated time [s]: where obstacles are; None: at the start.
        size: width and height in pixels.

    Returns:
        arrays of shape (height, width, 3).

    Raises:
        RenderError: neither EGL nor OSMesa works here.
    """
    team = build_team(resolved)
    with Renderer(team, size) as renderer:
        renderer.frame(qs, [pose for poses in targets or () for pose in poses.values()])
        return [
            renderer.picture(q, targets[i] if targets else {}, stamps[i] if stamps else 0.0)
            for i, q in enumerate(qs)
        ]


class Renderer:
    """A camera in the world of a team; use it as a context manager."""

    def __init__(
        self, team: Team, size: tuple[int, int] = (960, 540), *, fast: bool = False
    ) -> None:
        """Build the world with all that the eye needs; raises RenderError.

        Shadows and smooth edges cost most of the time: ``fast`` goes without, for films.
        """
        width, height = size
        self._context = _gl_context(width, height)
        self._context.make_current()
        self._team = team
        self._world = build_world(team, visuals=True)
        self._data = mujoco.MjData(self._world)
        self._coordinates = Coordinates(self._world, team)
        self._camera = mujoco.MjvCamera()
        self._option = mujoco.MjvOption()
        self._option.geomgroup[:] = [0, 1, 0, 0, 0, 0]
        self._scene = mujoco.MjvScene(self._world, maxgeom=4000)
        self._scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = not fast
        if fast:
            self._world.vis.quality.offsamples = 0
        self._rect = mujoco.MjrRect(0, 0, width, height)
        self._world.vis.global_.offwidth, self._world.vis.global_.offheight = size
        self._gl = mujoco.MjrContext(self._world, mujoco.mjtFontScale.mjFONTSCALE_100)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._gl)

    def __enter__(self) -> Self:
        """Return the renderer."""
        return self

    def __exit__(self, *_error: object) -> None:
        """Give the graphics memory back."""
        self._gl.free()
        self._context.free()

    def frame(
        self,
        qs: Sequence[Vector],
        targets: Sequence[Pose] = (),
        azimuth: float = 108.0,
        elevation: float = -18.0,
    ) -> None:
        """Place the camera so that robots and targets are in the picture at all configurations.

        Args:
            qs: configurations, shape (n,) each.
            targets: poses that are drawn as frames.
            azimuth: direction of the view about the vertical [deg].
            elevation: of the view above the horizon, negative looks down [deg].
        """
        tips = [pose.position + _AXIS * axis for pose in targets for axis in pose.rotation.T]
        points = np.concatenate([self._corners(q) for q in qs] + ([np.array(tips)] if tips else []))
        turn, tilt = np.deg2rad([azimuth, elevation])
        ahead = np.array([np.cos(tilt) * np.cos(turn), np.cos(tilt) * np.sin(turn), np.sin(tilt)])
        right = np.array([np.sin(turn), -np.cos(turn), 0.0])
        up = np.cross(right, ahead)
        slope = np.tan(0.5 * np.deg2rad(self._world.vis.global_.fovy))
        aspect = self._rect.width / self._rect.height
        depth = points @ ahead
        x, wide = _fit(points @ right, depth, slope * aspect)
        y, high = _fit(points @ up, depth, slope)
        # The distance is counted from the origin's depth, at which the camera looks.
        self._camera.lookat[:] = x * right + y * up
        self._camera.azimuth, self._camera.elevation = azimuth, elevation
        self._camera.distance = _MARGIN * max(wide, high)

    def picture(
        self, q: Vector, targets: Mapping[str, Pose] | None = None, stamp: float = 0.0
    ) -> Image:
        """Return the robots at q, shape (n,), with frames at the targets of their tools.

        Obstacles are where they are at the simulated time ``stamp`` [s].
        """
        self._coordinates.put(self._data, q)
        self._data.mocap_pos[:] = self._team.obstacles.at(stamp)
        mujoco.mj_kinematics(self._world, self._data)
        mujoco.mj_camlight(self._world, self._data)
        mujoco.mjv_updateScene(
            self._world,
            self._data,
            self._option,
            None,
            self._camera,
            mujoco.mjtCatBit.mjCAT_ALL,
            self._scene,
        )
        for pose in (targets or {}).values():
            self._add_frame(pose)
        mujoco.mjr_render(self._rect, self._scene, self._gl)
        image = np.empty((self._rect.height, self._rect.width, 3), np.uint8)
        mujoco.mjr_readPixels(image, None, self._rect, self._gl)
        return image[::-1].copy()

    def _corners(self, q: Vector) -> Vector:
        """Return points between which the robots are at q, shape (m, 3), m."""
        points: list[Sequence[float] | Vector] = []
        for robot, at, tool in zip(
            self._team.robots, self._team.q_slices, self._team.tools(q), strict=True
        ):
            base = robot.config.base
            if base is None or not base.chassis_mass:
                points += [*_joints_of(robot, q[at]), tool.position]
                continue
            x, y, yaw = robot.base_pose(q[at])
            length, width, _ = base.chassis_size
            top = robot.config.arm.mount.xyz[2] + _ARM_HEIGHT
            for along, aside in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
                forward, left = 0.5 * along * length, 0.5 * aside * width
                corner_x = x + np.cos(yaw) * forward - np.sin(yaw) * left
                corner_y = y + np.sin(yaw) * forward + np.cos(yaw) * left
                points.append((corner_x, corner_y, 0.0))
            points += [(x, y, top), tool.position]
        return np.array(points)

    def _add_frame(self, pose: Pose) -> None:
        """Draw a pose: a ball, and its axes in red, green and blue."""
        ball = self._next_geom()
        mujoco.mjv_initGeom(
            ball, _SPHERE, np.full(3, 0.028), pose.position, np.eye(3).ravel(), _BALL
        )
        for axis in range(3):
            end = pose.position + _AXIS * pose.rotation[:, axis]
            color = np.array([*np.eye(3)[axis] * 0.9, 1.0], np.float32)
            bar = self._next_geom()
            mujoco.mjv_initGeom(bar, _CAPSULE, np.zeros(3), np.zeros(3), np.eye(3).ravel(), color)
            mujoco.mjv_connector(bar, _CAPSULE, 0.009, pose.position, end)

    def _next_geom(self) -> mujoco.MjvGeom:
        """Return a geom of the scene that is still free."""
        self._scene.ngeom += 1
        return self._scene.geoms[self._scene.ngeom - 1]


def _joints_of(robot: RobotModel, q: Vector) -> list[Vector]:
    """Return points around the joints of a robot and the links that do not move, at q, m."""
    model, data = robot.pinocchio, robot.pinocchio.createData()
    pin.framesForwardKinematics(model, data, robot.positions(q))
    return [
        pose.translation + _LINK * np.array(corner)
        for pose in data.oMf
        for corner in itertools.product((-1.0, 1.0), repeat=3)
    ]


def _fit(across: Vector, depth: Vector, slope: float) -> tuple[float, float]:
    """Return where to look and from what distance, so that all points are within the view.

    A point at ``across`` to the side and ``depth`` ahead of the place looked at is seen from the
    distance d and the place c where ``|across - c| <= slope (d + depth)``.
    """
    one, other = float(np.max(across - slope * depth)), float(np.max(-across - slope * depth))
    return 0.5 * (one - other), 0.5 * (one + other) / slope


def _gl_context(width: int, height: int) -> Any:
    """Return an offscreen context of the first library that works; MUJOCO_GL chooses one.

    MuJoCo's own choice is made when it is first imported, by an environment variable that must
    have been set before; this one is made when a picture is asked for.
    """
    wanted = os.environ.get("MUJOCO_GL", "").lower()
    reasons = []
    for name in (wanted,) if wanted in _LIBRARIES else _LIBRARIES:
        try:
            ctypes.CDLL(_LIBRARIES[name])
            # The one is read by PyOpenGL, the other by MuJoCo's own loader of OpenGL.
            os.environ["PYOPENGL_PLATFORM"] = os.environ["MUJOCO_GL"] = name
            return importlib.import_module(f"mujoco.{name}").GLContext(width, height)
        except Exception as error:  # noqa: BLE001 - OpenGL raises whatever it likes
            reasons.append(f"{name}: {error}")
            for variable in ("PYOPENGL_PLATFORM", "MUJOCO_GL"):
                os.environ.pop(variable, None)
            # PyOpenGL stays with the platform it was first imported for.
            for module in [key for key in sys.modules if key.partition(".")[0] == "OpenGL"]:
                del sys.modules[module]
    raise RenderError(f"no offscreen rendering ({_ADVICE}): {'; '.join(reasons)}")
