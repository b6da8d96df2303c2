"""What RViz and Foxglove draw: a MarkerArray of spheres, obstacles, references, paths, horizons."""

from __future__ import annotations

from collections import deque

import numpy as np
from geometry_msgs.msg import Point
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from lexstack.robots import Pose, Team, from_rpy, to_quaternion
from lexstack.types import Matrix, Vector
from lexstack_ros.messages.conversions import stamped
from lexstack_ros.view.page.scene import COLORS
from lexstack_ros.view.picture import WINDOW, Picture

MARKERS = "/markers"
_AXIS, _THIN, _THICK = 0.16, 0.008, 0.015  # m
_ARROW = (0.4, 0.03, 0.03)  # m
_APART = 0.005  # m between two points of a path
_MOST = 1000  # points of a path
_AXES = tuple(ColorRGBA(**{axis: 0.9}, a=1.0) for axis in "rgb")
_BALL = (0.94, 0.78, 0.16, 0.8)


class Markers:
    """Makes the messages of pictures, and remembers the paths of the tools."""

    def __init__(self, team: Team) -> None:
        """Start without a path."""
        self._team = team
        self._framed: set[tuple[str, int]] = set()  # further frames whose references are drawn
        self._paths: list[deque[tuple[float, Vector]]] = [deque(maxlen=_MOST) for _ in team.robots]

    def message(self, picture: Picture) -> MarkerArray:
        """Return all markers of a picture; each keeps its name and number from one to the next."""
        self._go_on(picture)
        found = [
            *self._spheres(picture),
            *(
                _ball("obstacles", i, center, radius, _BALL)
                for i, (center, radius) in enumerate(
                    zip(picture.obstacles, self._team.obstacles.radii, strict=True)
                )
            ),
        ]
        for robot, model in enumerate(self._team.robots):
            found.append(_frame(robot, picture.references.ee[robot]))
            if model.has_base:
                found.append(_place(robot, picture.references.base[robot]))
            path = np.array([position for _, position in self._paths[robot]])
            found.append(_line("paths", robot, path, _THIN))
            found.append(_line("horizons", robot, picture.horizons.get(robot), _THICK))
        found += self._frames(picture)
        return MarkerArray(markers=[stamped(marker, picture.time) for marker in found])

    def _frames(self, picture: Picture) -> list[Marker]:
        """Return the references of further frames, and what takes those away that are gone."""
        found = []
        for (robot, frame), pose in picture.references.motion.frames.items():
            marker = _frame(robot, pose)
            marker.ns = f"reference of {self._team.names[robot]}/{frame}"
            found.append(marker)
        shown = {(marker.ns, marker.id) for marker in found}
        gone = [
            Marker(ns=name, id=robot, action=Marker.DELETE)
            for name, robot in sorted(self._framed - shown)
        ]
        self._framed = shown
        return found + gone

    def _go_on(self, picture: Picture) -> None:
        """Take where the tools are; a time that goes back begins the paths again."""
        for path, tool in zip(self._paths, self._team.tools(picture.q), strict=True):
            if path and path[-1][0] > picture.time:
                path.clear()
            if not path or np.linalg.norm(path[-1][1] - tool.position) > _APART:
                path.append((picture.time, tool.position))
            while path and path[0][0] < picture.time - WINDOW:
                path.popleft()

    def _spheres(self, picture: Picture) -> list[Marker]:
        """Return the spheres by which distances of the robots are measured."""
        spheres = self._team.spheres(picture.q)
        return [
            _ball(f"spheres of {self._team.names[owner]}", i, center, radius, _color(owner, 0.3))
            for i, (center, radius, owner) in enumerate(
                zip(spheres.centers, spheres.radii, spheres.owners, strict=True)
            )
        ]


def _ball(
    name: str, number: int, center: Vector, radius: float, color: tuple[float, ...]
) -> Marker:
    """Return a sphere."""
    marker = Marker(ns=name, id=number, type=Marker.SPHERE)
    marker.pose.position = _point(center)
    marker.scale.x = marker.scale.y = marker.scale.z = 2.0 * float(radius)
    marker.color = _rgba(color)
    return marker


def _frame(robot: int, pose: Pose) -> Marker:
    """Return the reference of a tool: its three axes."""
    marker = Marker(ns="tool references", id=robot, type=Marker.LINE_LIST)
    marker.scale.x = _THIN
    marker.color = _rgba(_color(robot, 1.0))
    for axis, color in zip(pose.rotation.T, _AXES, strict=True):
        marker.points += [_point(pose.position), _point(pose.position + _AXIS * axis)]
        marker.colors += [color, color]
    return marker


def _place(robot: int, base: Vector) -> Marker:
    """Return the reference of a base: an arrow on the floor."""
    x, y, yaw = map(float, base)
    marker = Marker(ns="base references", id=robot, type=Marker.ARROW)
    marker.pose.position = Point(x=x, y=y)
    turn = marker.pose.orientation
    turn.x, turn.y, turn.z, turn.w = to_quaternion(from_rpy((0.0, 0.0, yaw))).tolist()
    marker.scale.x, marker.scale.y, marker.scale.z = _ARROW
    marker.color = _rgba(_color(robot, 1.0))
    return marker


def _line(name: str, robot: int, points: Matrix | None, thickness: float) -> Marker:
    """Return a line through points, shape (m, 3); without two of them what takes the last away."""
    marker = Marker(ns=name, id=robot, type=Marker.LINE_STRIP)
    if points is None or len(points) < 2:
        marker.action = Marker.DELETE
        return marker
    marker.scale.x = thickness
    marker.color = _rgba(_color(robot, 0.9))
    marker.points = [_point(point) for point in points]
    return marker


def _point(position: Vector) -> Point:
    """Return a position [m] as a message."""
    x, y, z = map(float, position)
    return Point(x=x, y=y, z=z)


def _color(robot: int, alpha: float) -> tuple[float, ...]:
    """Return a robot's colour, as on the page."""
    red, green, blue = (value / 255.0 for value in COLORS[robot % len(COLORS)])
    return red, green, blue, alpha


def _rgba(color: tuple[float, ...]) -> ColorRGBA:
    """Return a colour as a message."""
    red, green, blue, alpha = color
    return ColorRGBA(r=red, g=green, b=blue, a=alpha)
