"""References and targets as values."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from lexstack.references.base_twist import BaseTwist
from lexstack.references.trajectory import Trajectory
from lexstack.references.twist_stream import Twist
from lexstack.robots import Pose, Team
from lexstack.types import Vector

TOOL = "tool"
"""Names the default tool among the frames of a robot."""

Frame = tuple[int, str]
"""A robot's place in the team, and the name of one of its frames."""


@dataclass(frozen=True, slots=True)
class Motion:
    """What tasks ask for besides poses of tools and bases, empty where nothing is given.

    Attributes:
        twists: velocity of the reference of a frame, shape (6,): m/s, then rad/s, world frame;
            ``TOOL`` is the default tool. None is in it of a reference at rest.
        bases: velocity of the reference of a base, shape (3,), m/s and rad/s, by robot.
        frames: poses of further frames.
        postures: of arms, shape (n_arm,), rad, by robot.
        posture_rates: their velocities, shape (n_arm,), rad/s, by robot.
    """

    twists: Mapping[Frame, Vector] = field(default_factory=dict)
    bases: Mapping[int, Vector] = field(default_factory=dict)
    frames: Mapping[Frame, Pose] = field(default_factory=dict)
    postures: Mapping[int, Vector] = field(default_factory=dict)
    posture_rates: Mapping[int, Vector] = field(default_factory=dict)

    @property
    def feeds(self) -> bool:
        """Whether some reference has a velocity that is added to what tasks ask for."""
        return bool(self.twists or self.bases or self.posture_rates)


STILL = Motion()
"""Nothing is given, and nothing moves."""


@dataclass(frozen=True, slots=True)
class References:
    """The references of all robots at one time, in the team's order, in the world frame.

    Attributes:
        ee: pose of each tool frame.
        base: x [m], y [m], yaw [rad] of each base, shape (3,) each; a robot without one has none
            that leads anywhere, and its mounting stands here.
        revision: number of the decision that they follow from; 0: of none. While a reference
            moves, as a set-point that is led in or a trajectory, the revision stays.
        motion: the velocities of references, and references of further frames and of postures.
    """

    ee: tuple[Pose, ...]
    base: tuple[Vector, ...]
    revision: int = 0
    motion: Motion = STILL

    def pose(self, robot: int, frame: str = TOOL) -> Pose | None:
        """Return the reference of a frame; None: it has none."""
        return self.ee[robot] if frame == TOOL else self.motion.frames.get((robot, frame))

    def twist(self, robot: int, frame: str = TOOL) -> Vector | None:
        """Return the velocity of a frame's reference, shape (6,); None: it rests."""
        return self.motion.twists.get((robot, frame))

    def same_motion(self, before: References) -> bool:
        """Return whether these are references of the same decision that move on from earlier ones.

        Only those count whose velocity is added to what tasks ask for.
        """
        return self.motion.feeds and self.revision == before.revision


def combined(parts: Iterable[tuple[tuple[int, ...], References]], every: References) -> References:
    """Return references of which each robot's are taken from another one.

    Args:
        parts: robots, and the references that count for them.
        every: for the robots that are in no part.
    """
    ee, base, revisions = list(every.ee), list(every.base), []
    source = [every.motion] * len(ee)
    for robots, references in parts:
        for robot in robots:
            ee[robot], base[robot] = references.ee[robot], references.base[robot]
            source[robot] = references.motion
        revisions.append(references.revision)
    return References(tuple(ee), tuple(base), max(revisions), _mixed(source))


def _mixed(source: list[Motion]) -> Motion:
    """Return the motion in which each robot's is its own."""
    if all(motion is source[0] for motion in source):
        return source[0]
    return Motion(
        {key: v for i, m in enumerate(source) for key, v in m.twists.items() if key[0] == i},
        {i: m.bases[i] for i, m in enumerate(source) if i in m.bases},
        {key: v for i, m in enumerate(source) for key, v in m.frames.items() if key[0] == i},
        {i: m.postures[i] for i, m in enumerate(source) if i in m.postures},
        {i: m.posture_rates[i] for i, m in enumerate(source) if i in m.posture_rates},
    )


@dataclass(frozen=True, slots=True)
class Hold:
    """In place of a goal: the reference comes to rest near where it is, without a jump."""


@dataclass(frozen=True, slots=True)
class Target:
    """One new reference of one robot, from a time on: exactly one of the three is given.

    Attributes:
        at: simulated time from which it holds [s].
        robot: the robot's place in the team.
        ee: of a frame: a pose, a trajectory of poses, a twist, or ``Hold``; or None.
        base: of the base: x, y, yaw, shape (3,), a trajectory of these, a twist, or ``Hold``; or
            None.
        posture: of the arm: shape (n_arm,), rad, a trajectory of these, or ``Hold``; or None.
        frame: the name of the frame that ``ee`` is for; default: the tool.
        begin: where the reference begins if there was none until then: a pose, or shape (n_arm,);
            None: at the goal.
        duration: in which it moves to a set-point, and is followed by its velocity too, or onto a
            trajectory if that is longer than the lead-in [s]; None: the lead-in of the schedule,
            and a set-point is followed by the gain alone.
    """

    at: float
    robot: int
    ee: Pose | Trajectory[Pose] | Twist | Hold | None = None
    base: Vector | Trajectory[Vector] | BaseTwist | Hold | None = None
    posture: Vector | Trajectory[Vector] | Hold | None = None
    frame: str = TOOL
    begin: Pose | Vector | None = None
    duration: float | None = None

    @property
    def kind(self) -> str:
        """What it is a reference of, in words of topics."""
        if self.ee is not None:
            return "ee_target" if self.frame == TOOL else f"ee_target of {self.frame}"
        return "base_target" if self.posture is None else "posture_target"


def measured(team: Team, q: Vector) -> References:
    """Return the poses at the stacked configuration q, shape (n,), as references."""
    return References(team.tools(q), team.base_poses(q))
