"""The robots, what they are to do and what is in their way, in three dimensions."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import viser

from lexstack.robots import Team, to_quaternion
from lexstack.types import Matrix, Vector
from lexstack_ros.view.picture import Picture
from lexstack_sim.drawing import Drawing

COLORS = ((213, 94, 0), (0, 114, 178), (0, 158, 115), (204, 121, 167), (230, 159, 0))
"""Of the robots in their order, as in reports."""
FIELD = np.deg2rad(50.0)
"""What the camera sees from top to bottom [rad]."""
_BALL = (240, 200, 40)
_EYE = np.array([0.2, -0.9, 0.45])  # direction from which the page looks at first
_FAR = 4.2  # radii of what is looked at: the window may be higher than wide
_LEAST = 1.2  # m


class Scene:
    """Draws pictures into viser's scene; names of nodes are numbers, so that no text is a path."""

    def __init__(self, server: viser.ViserServer, team: Team) -> None:
        """Send the shapes of everything; they stay hidden before the first picture."""
        self._scene, self._camera, self._team = server.scene, server.initial_camera, team
        self._drawing = Drawing(team)
        server.scene.configure_environment_map(None)
        server.scene.add_light_ambient("/light", intensity=1.2)
        server.scene.configure_default_lights(cast_shadow=False)
        server.scene.add_grid("/floor", 20.0, 20.0, cell_size=0.5, section_size=1.0)
        self._links = [self._add_link(i) for i in range(len(self._drawing.surfaces))]
        self._balls = [
            server.scene.add_icosphere(
                f"/obstacles/{i}", float(radius), color=_BALL, opacity=0.85, visible=False
            )
            for i, radius in enumerate(team.obstacles.radii)
        ]
        self._references = [
            server.scene.add_frame(
                f"/references/{i}", axes_length=0.16, axes_radius=0.006, visible=False
            )
            for i in range(len(team.robots))
        ]
        self._horizons: dict[int, viser.LineSegmentsHandle] = {}
        self._shown: Vector | None = None

    def look_at(self, q: Vector) -> None:
        """Let pages that are opened look at the robots as they stand at q, shape (nq,)."""
        position, target = camera_for(self._team, q)
        self._camera.position, self._camera.look_at = tuple(position), tuple(target)
        self._camera.fov = FIELD

    def show(self, picture: Picture) -> None:
        """Draw a picture; robots at rest cost nothing."""
        if self._shown is None or not np.array_equal(self._shown, picture.q):
            self._place_links(picture.q)
        for handle, center in zip(self._balls, picture.obstacles, strict=True):
            handle.position, handle.visible = tuple(center), True
        for handle, pose in zip(self._references, picture.references.ee, strict=True):
            handle.position, handle.wxyz = tuple(pose.position), wxyz(pose.rotation)
            handle.visible = True
        for robot in self._horizons.keys() - picture.horizons.keys():
            self._horizons.pop(robot).remove()
        for robot, points in picture.horizons.items():
            self._draw_horizon(robot, points)

    def _place_links(self, q: Vector) -> None:
        """Move all links to where they are at q."""
        self._shown = q
        for handle, place, turn in zip(self._links, *self._drawing.poses(q), strict=True):
            handle.position, handle.wxyz, handle.visible = tuple(place), tuple(turn), True

    def _add_link(self, number: int) -> viser.FrameHandle:
        """Send the shapes of one link; return the frame that carries them."""
        name = f"/links/{number}"
        frame = self._scene.add_frame(name, show_axes=False, visible=False)
        for i, surface in enumerate(self._drawing.surfaces[number]):
            red, green, blue, alpha = surface.color
            self._scene.add_mesh_simple(
                f"{name}/{i}",
                surface.mesh.vertices,
                surface.mesh.faces,
                color=(red, green, blue),
                opacity=alpha if alpha < 1.0 else None,
                flat_shading=True,
                side="double",
            )
        return frame

    def _draw_horizon(self, robot: int, points: Matrix) -> None:
        """Draw where the tool goes by the plan."""
        segments = np.array(list(pairwise(points))).reshape(-1, 2, 3)
        known = self._horizons.get(robot)
        if known is None:
            self._horizons[robot] = self._scene.add_line_segments(
                f"/horizons/{robot}", segments, color_of(robot), thickness=0.012
            )
        else:
            known.points = segments


def color_of(robot: int) -> tuple[int, int, int]:
    """Return the colour of the robot at a place in the team."""
    return COLORS[robot % len(COLORS)]


def wxyz(rotation: Matrix) -> tuple[float, float, float, float]:
    """Return a rotation matrix as viser has it."""
    x, y, z, w = to_quaternion(rotation).tolist()
    return w, x, y, z


def camera_for(team: Team, q: Vector) -> tuple[Vector, Vector]:
    """Return from where all tools and bases at q, shape (nq,), are seen, and the middle of them."""
    bases = [np.array([*base[:2], 0.0]) for base in team.base_poses(q)]
    points = np.array([*bases, *(pose.position for pose in team.tools(q))])
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    radius = max(_LEAST, float(np.linalg.norm(points - middle, axis=1).max()))
    return middle + _FAR * radius * _EYE / np.linalg.norm(_EYE), middle
