"""Distances to obstacles and other robots: an inequality on the speed of approach.

A pair is a sphere of the robot, center c_i, and an obstacle, or a sphere of another robot or of the
robot itself, center c_j. With n = (c_i - c_j) / |c_i - c_j|, and r = |c_i - c_j| - r_i - r_j -
margin, the room that is left:

    n.(J_i chi) - n.v_j >= -w(r)            v_j: J_j chi, or the obstacle's own velocity

w is the largest speed of approach from which the given deceleration still keeps r >= 0, damped in
front of the margin by a gain g, in steps of dt:

    w(r) = g r                                                      where |r| <= a / g^2
    w(r) = sgn(r) (-a dt + sqrt((a/g + a dt)^2 + 2 a (|r| - a/g^2)))     beyond

Like u of the bounds it is odd and increasing, and moving at w(r) leaves a room r' with
w(r') >= w(r) - a dt. So whoever keeps such a row needs to change n.J chi by at most a dt to keep it
at the next tick, and by what the obstacle's acceleration and the turning of n and J add. The joints
have that inside their acceleration box: a is at most half of what they give along the row,
sum_j |A_j| a_j, and the other half is for the rest. A room that is negative leads back out by the
same law. Rows that contradict each other or the velocity limits are relaxed like every task, as
little as can be, after all levels below have given way.

Since |c + d| >= n.(c + d), the row is on the safe side of how straight motions change a distance.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from lexstack.errors import ConfigurationError
from lexstack.options import NotNegative, Positive, Range, build
from lexstack.references import References
from lexstack.robots import Kinematics, Spheres, Team
from lexstack.robots.collision_geometry import Indices
from lexstack.types import LinearTask, Matrix, Vector

_GROUND = 1e6  # m, radius of the sphere that stands for the floor: flat to 5 um within 3 m
_SHARE = 0.5  # of the joints' acceleration that may be used up for the distance itself
_APART = 4  # joints along the chain; links nearer to each other than this cannot meet
_NEAR = 1e-9  # m, centers nearer than this have no direction between them


@dataclass(frozen=True, slots=True)
class CollisionAvoidanceParameters:
    """Parameters of the task ``collision_avoidance``."""

    margin: NotNegative = 0.05  # m, between the surfaces
    influence: Positive = 0.8  # m, between the surfaces: pairs further apart are not looked at
    deceleration: Positive = 1.0  # a [m/s2], with which an approach may end in front of the margin
    gain: Positive = 5.0  # g [1/s], of the last part of an approach
    rows: Annotated[int, Range(0, open=True)] = 10  # at most so many pairs, the nearest
    obstacles: tuple[str, ...] | None = None  # names in the team; default: all that it has
    robots: tuple[str, ...] = ()  # names of other robots
    ground: bool = False  # whether the arm keeps away from the floor too
    itself: bool = False  # whether its own links keep apart, those that can meet

    def validate(self, where: str) -> None:
        """Raise ConfigurationError for an influence that ends within the margin."""
        if self.influence <= self.margin:
            raise ConfigurationError(
                f"{where}: influence: must be > margin = {self.margin}, got {self.influence}"
            )


class CollisionAvoidance:
    """n.(J_i - J_j) chi >= n.v_j - w(r), one row for each of the nearest pairs."""

    def __init__(
        self,
        team: Team,
        robot: int,
        parameters: CollisionAvoidanceParameters,
        where: str = "collision_avoidance",
    ) -> None:
        """Make the task of the robot at place ``robot``; raises for names that are not there."""
        self.name = f"{team.names[robot]}/collision_avoidance"
        if parameters.gain * team.dt > 1.0:
            limit = f"must be <= {1.0 / team.dt:g} 1/s, one over the control period"
            raise ConfigurationError(f"{where}: gain: {limit}, got {parameters.gain}")
        self._parameters = parameters
        self._obstacles = team.obstacles
        self._influence = parameters.influence - parameters.margin  # of the room
        self._dt = team.dt
        self._able = _SHARE * team.limits.acceleration
        try:
            names = parameters.obstacles
            names = team.obstacles.names if names is None else names
            self._chosen = np.array([team.obstacles.index(name) for name in names], dtype=np.intp)
        except ConfigurationError as error:
            raise ConfigurationError(f"{where}: obstacles: {error}") from error
        others = _other_robots(team, robot, parameters.robots, where)
        self.robots = (robot, *others)
        self._own = spheres_of(team, robot)
        every = np.arange(sum(len(each.spheres.radii) for each in team.robots))
        parts = [every[spheres_of(team, other)] for other in others]
        parts += [every[self._own]] * parameters.itself
        self._others: Indices = np.concatenate([every[:0], *parts])
        self._fixed = len(names) + parameters.ground
        self._ground = np.array([[0.0, 0.0, -_GROUND]])[: int(parameters.ground)]
        self._reach = self._reaches(team, robot)
        # Which sphere and which other thing make each pair.
        first, second = np.indices(self._reach.shape)
        self._first: Indices = first.ravel() + self._own.start
        self._second: Indices = second.ravel()
        self._rows = min(parameters.rows, self._reach.size)
        self._all = np.arange(self._rows)
        self._open = np.full(self._rows, np.inf)
        # Nothing is near: 0 chi = 0. Solvers are quicker where no row is an inequality.
        nothing, zero = np.zeros((self._rows, team.n)), np.zeros(self._rows)
        for array in (nothing, zero, self._open):
            array.setflags(write=False)
        self._far = LinearTask.equality(self.name, nothing, zero)

    @classmethod
    def from_config(
        cls, team: Team, robot: int, parameters: dict[str, Any], where: str
    ) -> CollisionAvoidance:
        """Return the task that a stack file describes; raises ConfigurationError."""
        return cls(team, robot, build(CollisionAvoidanceParameters, parameters, where), where)

    def linearise(self, kinematics: Kinematics, references: References) -> LinearTask:
        """Return one row [m/s] for each of the nearest pairs, in an order that seldom changes.

        There are always equally many rows. Those beyond the influence are open on both sides; if
        all are, they are ``0 chi = 0``.
        """
        if self._rows == 0:
            return self._far
        spheres, stamp = kinematics.spheres, kinematics.state.stamp
        lines = spheres.centers[self._own, None] - self._points(spheres, stamp)
        lengths = np.sqrt(np.einsum("ijk,ijk->ij", lines, lines))
        room = (lengths - self._reach).ravel()
        pairs = self._nearest(room)
        room, other = room.take(pairs), self._second.take(pairs)
        beyond = room > self._influence
        if beyond.all():
            return self._far
        normals = lines.reshape(-1, 3).take(pairs, axis=0)
        normals /= np.maximum(lengths.take(pairs), _NEAR)[:, None]
        matrix = spheres.rows(self._first.take(pairs), normals)
        if len(self._others):
            self._subtract(matrix, spheres, other, normals)
        lower = -self._approach(room, matrix)
        if self._obstacles.moving:
            lower += np.einsum("ij,ij->i", normals, self._velocities(stamp).take(other, axis=0))
        lower[beyond] = -np.inf
        return LinearTask(self.name, matrix, lower, self._open)

    def _nearest(self, room: Vector) -> Indices:
        """Return which pairs become rows, ascending."""
        if self._rows == room.size:
            return self._all
        pairs: Indices = np.argpartition(room, self._rows - 1)[: self._rows]
        pairs.sort()
        return pairs

    def _approach(self, room: Vector, matrix: Matrix) -> Vector:
        """Return w(r) for each row, with the deceleration that its joints have."""
        able = np.abs(matrix) @ self._able
        np.minimum(able, self._parameters.deceleration, out=able)
        return damped_speed(room, able, self._parameters.gain, self._dt)

    def _points(self, spheres: Spheres, stamp: float) -> Matrix:
        """Return what distances are kept to, shape (k, 3), m: obstacles, floor, spheres."""
        here = self._obstacles.at(stamp).take(self._chosen, axis=0)
        if self._fixed == len(here) and not len(self._others):
            return here
        return np.concatenate([here, self._ground, spheres.centers.take(self._others, axis=0)])

    def _velocities(self, stamp: float) -> Matrix:
        """Return how fast the points move in this tick, shape (k, 3), m/s.

        Zero for the spheres of robots: their motion is part of chi.
        """
        moved = self._obstacles.at(stamp + self._dt) - self._obstacles.at(stamp)
        velocities = np.zeros((self._reach.shape[1], 3))
        velocities[: self._chosen.size] = moved.take(self._chosen, axis=0)
        velocities /= self._dt
        return velocities

    def _subtract(self, matrix: Matrix, spheres: Spheres, other: Indices, normals: Matrix) -> None:
        """Take the motion of the spheres that are kept away from off their rows."""
        robots = other >= self._fixed
        if robots.any():
            moving = self._others[other[robots] - self._fixed]
            matrix[robots] -= spheres.rows(moving, normals[robots])

    def _reaches(self, team: Team, robot: int) -> Matrix:
        """Return r_i + r_j + margin for all pairs, shape (own, others), m."""
        own = team.robots[robot].spheres
        all_radii = np.concatenate([each.spheres.radii for each in team.robots])
        grounds = np.full(len(self._ground), _GROUND)
        radii = np.concatenate(
            [team.obstacles.radii[self._chosen], grounds, all_radii[self._others]]
        )
        reach: Matrix = own.radii[:, None] + radii + self._parameters.margin
        if self._parameters.ground:
            on_base = ~own.moved_by[:, team.robots[robot].arm].any(axis=1)
            reach[on_base, len(self._chosen)] = -_GROUND  # the platform stands on it
        if self._parameters.itself:
            joints = own.moved_by.sum(axis=1)
            apart = joints[:, None] - joints >= _APART
            reach[:, -len(joints) :][~apart] = -_GROUND
        return reach


def damped_speed(room: Vector, deceleration: Vector, gain: float, dt: float) -> Vector:
    """Return w(r), the largest speed towards a distance that must be kept, shape (m,), m/s.

    Args:
        room: r, shape (m,), m.
        deceleration: a, shape (m,), m/s^2, not negative.
        gain: g [1/s], at most 1/dt to be reached without overshoot.
        dt: control period [s].
    """
    far = np.abs(room)
    last = deceleration / gain  # the speed at which the last part begins
    reach = deceleration * dt
    doubled = far - last / gain
    np.maximum(doubled, 0.0, out=doubled)
    doubled *= 2.0 * deceleration
    doubled += (last + reach) ** 2
    np.sqrt(doubled, out=doubled)
    doubled -= reach
    far *= gain
    np.minimum(far, doubled, out=far)
    return np.copysign(far, room)


def spheres_of(team: Team, robot: int) -> slice:
    """Return where a robot's own spheres are among those of its team."""
    counts = [len(each.spheres.radii) for each in team.robots]
    start = sum(counts[:robot])
    return slice(start, start + counts[robot])


def _other_robots(team: Team, robot: int, names: tuple[str, ...], where: str) -> list[int]:
    """Return the places of the named robots, in the team's order.

    Raises:
        ConfigurationError: a robot is unknown, or the task's own.
    """
    try:
        others = sorted({team.index(name) for name in names})
    except ConfigurationError as error:
        raise ConfigurationError(f"{where}: robots: {error}") from error
    if robot in others:
        raise ConfigurationError(
            f"{where}: robots: {team.names[robot]!r} is the task's own robot; name the others"
        )
    return others
