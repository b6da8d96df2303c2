"""The values that all parts of the library share: vectors, a state, and a task made linear."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from lexstack.errors import InputError

Vector = NDArray[np.float64]
"""An array of one dimension."""
Matrix = NDArray[np.float64]
"""An array of two dimensions."""


class PlantStatus(IntEnum):
    """What a plant did in its last tick: ``status`` of ``PlantState``."""

    FOLLOWING = 0  # executed the command of the tick
    HOLDING = 1  # no command came: kept the one before
    BRAKING = 2  # no command for the watchdog's time: slows all joints down within their limits
    PAUSED = 3  # simulated time stands still


@dataclass(frozen=True, slots=True)
class RobotState:
    """All robots at one tick, stacked in the configured order; arrays are not to be written.

    Positions, per robot: base x [m], y [m], yaw [rad] in the world frame, then the arm joints
    [rad]. Velocities, as chi: the same of a holonomic base, forward speed [m/s] and yaw rate
    [rad/s] of a differential one, then the arm joints.

    Attributes:
        tick: number of the control period, counted by the plant.
        stamp: simulated time [s].
        q: measured positions, shape (nq,).
        v: measured velocities, shape (n,), m/s and rad/s.
        q_star: integral of the commands that the plant has accepted, each constant over its
            period (``Team.integrate``), shape (nq,).
        command: the last chi that the plant has accepted, shape (n,).
    """

    tick: int
    stamp: float
    q: Vector
    v: Vector
    q_star: Vector
    command: Vector

    @classmethod
    def at_rest(cls, q: Vector, n: int | None = None) -> RobotState:
        """Return the state of tick 0 at a configuration, shape (nq,); n: of chi, default nq."""
        still = np.zeros(q.size if n is None else n)
        return cls(0, 0.0, q, still, q, still)

    def after(self, chi: Vector, dt: float) -> RobotState:
        """Return the next tick's state of robots that follow a command exactly for dt [s].

        ``Team.after`` is for all robots; this is for those whose chi is the derivative of q.
        """
        if self.q.size != chi.size:
            raise InputError("RobotState.after: chi is not the derivative of q: use Team.after")
        tick = self.tick + 1
        return RobotState(tick, tick * dt, self.q + dt * chi, chi, self.q_star + dt * chi, chi)


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """What a task's rows leave out: how they turn while the robots move.

    The rows are ``scale`` times the derivative of a function f of the joints, and ask for
    ``scale K e`` with e the error that is left of it, and for the velocity of the reference, see
    ``LinearTask.feed``. Made once per task: it holds nothing that changes from tick to tick.

    Attributes:
        gain: K [1/s]; an equality row divided by it is the error that the row asks to remove.
        robots: places in the team of the robots whose joints have a column in the rows.
        columns: the joints of each of these robots in chi.
        signs: per robot +1 or -1: the rows are that many times the Jacobian of a frame that it
            moves; empty where f is linear in the joints.
        limits: per three rows the length that K e is shortened to, see ``saturated``; may be empty.
        scale: root of the task's weight.
        sizes: of how many rows each of ``limits`` is; empty: of three.
    """

    gain: float
    robots: tuple[int, ...]
    columns: tuple[slice, ...]
    signs: tuple[float, ...] = ()
    limits: tuple[float, ...] = ()
    scale: float = 1.0
    sizes: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class FrameRows:
    """How the rows of a task come from the Jacobian of a frame: ``scale * axes @ jacobian``.

    Attributes:
        axes: shape (m, 6): linear, then angular.
        jacobian: shape (6, n_robot), at the frame's origin, axes parallel to the world
            (LOCAL_WORLD_ALIGNED), of the last robot of the curve.
        end: None, or that of where the frame belongs on another one, on the first robot of the
            curve; the rows are then ``scale * axes @ (jacobian - end)``.
        turning: None, or how the axes turn with the frame, shape (m, 6, 6), symmetric: with the
            frame's twist t, B has t^T Q_r t besides, for each row r, times its error.
        tree: None, or of rows that joints of several branches move: which joints, see ``Tree``.
    """

    axes: Matrix
    jacobian: Matrix
    end: Matrix | None = None
    turning: NDArray[np.float64] | None = None
    tree: Tree | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Tree:
    """How the joints of a robot carry each other.

    Attributes:
        carries: 1 where joint i carries what joint j moves, and for i = j, shape (n_all, n_all);
            upper triangular.
        follows: E, velocities of all joints by those of the controlled ones, shape (n_all, n);
            None: they are the same. Columns of Jacobians are those of all joints.
    """

    carries: Matrix
    follows: Matrix | None = None


@dataclass(frozen=True, slots=True)
class LinearTask:
    """One task made linear at the present state: ``lower <= matrix @ chi <= upper``.

    Rows with ``lower == upper`` are the equality objective ``A chi -> b`` of T(8); the others are
    inequality objectives, +-inf allowed on one side. The residual of a row is its distance to
    ``[lower, upper]``; a level minimises the sum of squared residuals of its tasks.

    Attributes:
        name: unique within its stack, e.g. ``robot_a/ee_pose``.
        matrix: A, shape (m, n) with n the length of chi.
        lower: shape (m,), in the unit of ``matrix @ chi``.
        upper: shape (m,), ``lower <= upper``.
        curve: of equality rows that ask to remove an error; None: nothing is known of it.
        feed: of such rows, the part of ``lower`` that is no error but the velocity of the reference
            (x_dot^d of T(16)), shape (m,); None: zero.
        frame: of such rows, where they are not all six, or the first three, of the Jacobian of the
            robot's tool in the axes of the world.
    """

    name: str
    matrix: Matrix
    lower: Vector
    upper: Vector
    curve: Curve | None = None
    feed: Vector | None = None
    frame: FrameRows | None = None

    @classmethod
    def equality(
        cls,
        name: str,
        matrix: Matrix,
        target: Vector,
        curve: Curve | None = None,
        feed: Vector | None = None,
        frame: FrameRows | None = None,
    ) -> LinearTask:
        """Return the task ``matrix @ chi -> target + feed``."""
        both = target if feed is None else target + feed
        return cls(name, matrix, both, both, curve, feed, frame)

    @property
    def correction(self) -> Vector:
        """What equality rows with a curve ask for to remove their error, K e, shape (m,)."""
        return self.lower if self.feed is None else self.lower - self.feed

    def residual(self, chi: Vector) -> Vector:
        """Return the signed distance of ``matrix @ chi`` to ``[lower, upper]``, shape (m,)."""
        value: Vector = self.matrix.dot(chi)
        if self.lower is self.upper:
            return value - self.lower
        return value - np.minimum(np.maximum(value, self.lower), self.upper)
