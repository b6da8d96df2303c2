"""What the eye sees: coloured arms, platforms with mecanum wheels, floor and light."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np
import pinocchio as pin

from lexstack.robots import AnyBase, RobotModel, WheelsConfig
from lexstack.types import Matrix, Vector
from lexstack_sim.collada import Color, clustered, read_collada
from lexstack_sim.meshes import Mesh, Shape, arm_shapes

TINTS = ((0.95, 0.42, 0.08), (0.07, 0.42, 0.85), (0.15, 0.6, 0.25), (0.6, 0.25, 0.7))
"""Colours by which robots are told apart, in the order of chi."""

_GROUP = 1  # of geoms that are visible and touch nothing
_ONLY_SEEN = {"contype": 0, "conaffinity": 0, "group": _GROUP, "mass": 0.0}
_DARK, _BLACK = (0.16, 0.17, 0.19, 1.0), (0.05, 0.05, 0.055, 1.0)
_STEEL, _GLASS = (0.62, 0.64, 0.67, 1.0), (0.9, 0.95, 1.0, 1.0)
_RED: Color = (0.7, 0.05, 0.05, 1.0)
_WHITE: Color = (0.95, 0.95, 0.95, 1.0)
_TINTED = 0.15  # how much of its tint the white of an arm takes
_BOX, _CYLINDER = mujoco.mjtGeom.mjGEOM_BOX, mujoco.mjtGeom.mjGEOM_CYLINDER
_CAPSULE = mujoco.mjtGeom.mjGEOM_CAPSULE
_ROLLERS = 10  # of a mecanum wheel
_CELL = 0.004  # m, details smaller than this vanish
_MANY = 5000  # triangles, above which a mesh is made coarser


def add_visuals(
    spec: mujoco.MjSpec, robot: RobotModel, bodies: dict[int, mujoco.MjsBody], index: int
) -> None:
    """Add a robot's visible parts to its bodies; they weigh nothing and touch nothing."""
    tint = TINTS[index % len(TINTS)]
    base = robot.config.base
    if base is not None and base.chassis_mass:
        body = bodies[robot.pinocchio.frames[robot.pinocchio.getFrameId("base")].parentJoint]
        _add_chassis(spec, body, robot, base, (*tint, 1.0))
        for x in (base.wheels.x, -base.wheels.x):
            for y in (base.wheels.y, -base.wheels.y):
                _add_wheel(body, base.wheels, x, y, rollers=not robot.differential)
    for shape in arm_shapes(robot, pin.GeometryType.VISUAL):
        _add_link(spec, bodies[shape.joint], robot, shape, tint)


def add_scene(spec: mujoco.MjSpec) -> None:
    """Add sky, light and floor."""
    spec.visual.headlight.ambient = (0.38, 0.38, 0.4)
    spec.visual.headlight.diffuse = (0.25, 0.25, 0.25)
    spec.visual.headlight.specular = (0.1, 0.1, 0.1)
    spec.visual.global_.fovy = 32.0
    spec.visual.quality.shadowsize = 2048
    spec.visual.quality.offsamples = 4
    spec.visual.map.znear, spec.visual.map.zfar = 0.03, 15.0
    spec.stat.extent, spec.stat.center = 3.0, (0.0, 0.0, 0.5)
    spec.add_texture(
        name="sky",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=(0.86, 0.9, 0.95),
        rgb2=(0.98, 0.98, 0.98),
        width=256,
        height=256,
    )
    for position, strength in (((-2.0, -4.0, 6.0), 0.55), ((5.0, 3.0, 5.0), 0.2)):
        spec.worldbody.add_light(
            type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
            pos=position,
            dir=[-value for value in position],
            diffuse=(strength,) * 3,
            specular=(0.2,) * 3,
            castshadow=strength > 0.5,
        )
    _add_floor(spec)


def _add_floor(spec: mujoco.MjSpec) -> None:
    """Add a floor with a line every metre."""
    spec.add_texture(
        name="tiles",
        type=mujoco.mjtTexture.mjTEXTURE_2D,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_FLAT,
        mark=mujoco.mjtMark.mjMARK_EDGE,
        rgb1=(0.78, 0.79, 0.8),
        markrgb=(0.6, 0.61, 0.63),
        width=512,
        height=512,
    )
    tiles = spec.add_material(name="tiles", texrepeat=(1, 1), texuniform=True)
    tiles.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "tiles"
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_PLANE, size=(20, 20, 1), material="tiles", **_ONLY_SEEN
    )


def _add_chassis(
    spec: mujoco.MjSpec, body: mujoco.MjsBody, robot: RobotModel, base: AnyBase, tint: Color
) -> None:
    """Add a rounded dark hull above the wheels, coloured skirts, a top plate, lamps in front."""
    length, width, _ = base.chassis_size
    top = base.chassis_height + 0.5 * base.chassis_size[2]
    bottom = 1.8 * base.wheels.radius  # the hull covers the wheels' upper part
    plate = 0.012
    hull = f"{robot.name}/look/hull"
    size = (length, width, top - plate - bottom)
    spec.add_mesh(name=hull, uservert=_rounded_box(size, 0.06).ravel())
    middle = 0.5 * (top - plate + bottom)
    body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_MESH, meshname=hull, pos=(0, 0, middle), rgba=_DARK, **_ONLY_SEEN
    )
    inner = base.wheels.y - 0.6 * base.wheels.width
    _box(body, (0, 0, 0.6 * bottom), (0.92 * length, 2 * inner, 0.8 * bottom), _BLACK)
    _box(body, (0, 0, top - 0.5 * plate), (0.86 * length, 0.86 * width, plate), _STEEL)
    height = middle + 0.02
    for y in (0.5 * width, -0.5 * width):
        _box(body, (0, y, height), (0.74 * length, 0.014, 0.09), tint)
        _box(body, (0.5 * length, 0.6 * y, height), (0.012, 0.1, 0.035), _GLASS)
        _box(body, (-0.5 * length, 0.6 * y, height), (0.012, 0.1, 0.03), _RED)
    _box(body, (0.5 * length, 0, height), (0.014, 0.2, 0.06), tint)


def _add_wheel(
    body: mujoco.MjsBody, wheels: WheelsConfig, x: float, y: float, *, rollers: bool
) -> None:
    """Add a wheel: hub and discs; of mecanum with rollers at 45 degrees, mirrored like the real."""
    radius, half = wheels.radius, 0.5 * wheels.width
    sideways = (np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0)
    center = np.array([x, y, radius])
    for size, color in (
        ((0.72 * radius if rollers else radius, 0.8 * half, 0), _BLACK),
        ((0.36 * radius, 1.02 * half, 0), _STEEL),
    ):
        body.add_geom(
            type=_CYLINDER, size=size, pos=center, quat=sideways, rgba=color, **_ONLY_SEEN
        )
    if not rollers:
        return
    slant = np.sign(x * y)
    thick = 0.2 * radius
    for angle in np.arange(_ROLLERS) * 2.0 * np.pi / _ROLLERS:
        out = np.array([np.cos(angle), 0.0, np.sin(angle)])
        along = np.array([-np.sin(angle), 0.0, np.cos(angle)])
        axis = np.sqrt(0.5) * (np.array([0.0, 1.0, 0.0]) + slant * along)
        middle = center + (radius - thick) * out
        ends = np.concatenate([middle - 0.85 * half * axis, middle + 0.85 * half * axis])
        body.add_geom(
            type=mujoco.mjtGeom.mjGEOM_CAPSULE,
            fromto=ends,
            size=(thick, 0, 0),
            rgba=_DARK,
            **_ONLY_SEEN,
        )


def _add_link(
    spec: mujoco.MjSpec,
    body: mujoco.MjsBody,
    robot: RobotModel,
    shape: Shape,
    tint: Sequence[float],
) -> None:
    """Add one link's meshes in their own colours, the white mixed with the robot's tint."""
    if shape.is_primitive:
        shape.add_primitive(body, rgba=shape.color or _WHITE, **_ONLY_SEEN)
        return
    for i, (color, mesh) in enumerate(_coloured(shape).items()):
        share = _TINTED if min(color[:3]) > 0.8 else 0.0
        mixed = (1.0 - share) * np.array(color[:3]) + share * np.array(tint)
        asset = f"look/{robot.config.name}/{shape.name}_{i}"
        shape.add_mesh(spec, body, asset, mesh, rgba=(*mixed, color[3]), **_ONLY_SEEN)


def _coloured(shape: Shape) -> dict[Color, Mesh]:
    """Return a mesh by colour, in metres; one colour where its file has none that we can read."""
    whole = shape.mesh()
    if shape.path.suffix == ".dae" and shape.color is None:
        found = _scaled(read_collada(shape.path), shape.scale)
        if found and np.abs(_box_of(*found.values()) - _box_of(whole)).max() < _CELL:
            return found
    if len(whole.faces) > _MANY:
        whole = clustered(whole.vertices[whole.faces.ravel()], _CELL)
    return {shape.color or _WHITE: whole}


def _scaled(meshes: dict[Color, Mesh], scale: Vector) -> dict[Color, Mesh]:
    """Return meshes as the URDF scales them."""
    return {color: Mesh(scale * mesh.vertices, mesh.faces) for color, mesh in meshes.items()}


def _box_of(*meshes: Mesh) -> Matrix:
    """Return the box that holds all used corners of meshes: least and most, shape (2, 3), m."""
    points = np.concatenate([mesh.vertices[mesh.faces.ravel()] for mesh in meshes])
    return np.array([points.min(axis=0), points.max(axis=0)])


def _box(
    body: mujoco.MjsBody, center: Sequence[float], sides: Sequence[float], color: Color
) -> None:
    """Add a box that is only seen."""
    half = [0.5 * side for side in sides]
    body.add_geom(type=_BOX, pos=center, size=half, rgba=color, **_ONLY_SEEN)


def _rounded_box(sides: Sequence[float], radius: float) -> Matrix:
    """Return points whose convex hull is a box with round edges, shape (m, 3)."""
    around = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False) + np.pi / 24
    up = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 12)
    azimuth, height = (grid.ravel() for grid in np.meshgrid(around, up))
    sphere = np.column_stack(
        [np.cos(height) * np.cos(azimuth), np.cos(height) * np.sin(azimuth), np.sin(height)]
    )
    return np.sign(sphere) * (0.5 * np.array(sides) - radius) + radius * sphere
