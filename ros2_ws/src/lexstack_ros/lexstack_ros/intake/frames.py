"""Where the frames are that targets are told in: the robots' own, and those heard on /tf.

Of a robot NAME the frames are NAME/FRAME, FRAME being ``tool``, one of its ``tools``, any link or
joint of its description; ``NAME/base``, where it stands, the child frame of its odometry (also
``NAME/base_link`` where its description has none); and ``NAME/odom`` and ``NAME/world``,
which are the world, as the plant tells the pose of its base in it (REP-105).
"""

from __future__ import annotations

from functools import partial

import numpy as np
from std_msgs.msg import Header

from lexstack.errors import InputError, ModelError
from lexstack.options import shown
from lexstack.robots import Pose, Team, from_rpy
from lexstack.types import RobotState, Vector
from lexstack_ros.intake.transforms import EarlyError, History, Transforms, between
from lexstack_ros.messages.conversions import WORLD, to_stamp

_BASE, _BASE_LINK = "base", "base_link"
_FIXED = ("odom", WORLD)
_UPRIGHT_WORLD = Pose(np.zeros(3), np.eye(3))


class Frames:
    """Finds the pose of a message's frame at its stamp.

    Attributes:
        transforms: what was heard on /tf and /tf_static.
    """

    def __init__(self, team: Team) -> None:
        """Know nothing of the plant yet."""
        self._team = team
        self._states = History[RobotState]()
        self.transforms = Transforms()

    @property
    def state(self) -> RobotState | None:
        """The newest state of the plant."""
        return self._states.last

    def see(self, state: RobotState) -> None:
        """Keep a state."""
        self._states.add(state.stamp, state)

    def __call__(self, header: Header, where: str) -> Pose | None:
        """Return the pose of a message's frame in the world; None: it is the world.

        Raises:
            InputError: the frame is not known, or not at that time; ``EarlyError`` where that is
                still to come.
        """
        frame, stamp = header.frame_id.lstrip("/"), to_stamp(header, where)
        if frame in ("", WORLD):
            return None
        place = f"{where}: frame_id"
        now = 0.0 if self.state is None else self.state.stamp
        try:
            found = self.transforms.find(frame, stamp, now, partial(self._own, stamp))
        except EarlyError as error:
            raise EarlyError(f"{place}: {error}", error.ahead) from error
        except InputError as error:
            raise InputError(f"{place}: {error}") from error
        if found is None:
            raise InputError(f"{place}: unknown {shown(frame)}; known: {', '.join(self._known())}")
        return found

    def owns(self, frame: str) -> bool:
        """Return whether a frame is a robot's, so that the plant's states say where it is."""
        robot, _, name = frame.lstrip("/").partition("/")
        if robot not in self._team.names or not name:
            return False
        model = self._team.robots[self._team.names.index(robot)]
        if name in _FIXED or (model.has_base and name in (_BASE, _BASE_LINK)):
            return True
        try:
            model.frame(name)
        except ModelError:
            return False
        return True

    def _known(self) -> list[str]:
        """Return the frames that there are, for errors."""
        own = [f"{name}/FRAME (its tool, links and joints)" for name in self._team.names]
        return [WORLD, *own, *self.transforms.frames]

    def _own(self, stamp: float, frame: str) -> Pose | None:
        """Return the pose of a frame that is the world's or a robot's; None: it is neither's."""
        if frame == WORLD:
            return _UPRIGHT_WORLD
        robot, _, name = frame.partition("/")
        if robot not in self._team.names or not name:
            return None
        if name in _FIXED:
            return _UPRIGHT_WORLD
        i = self._team.names.index(robot)
        try:
            return self._at(stamp, i, name)
        except ModelError:
            return None

    def _at(self, stamp: float, robot: int, name: str) -> Pose:
        """Return the pose of a robot's frame at a time [s]; 0: the newest."""
        what = f"the pose of '{self._team.names[robot]}/{name}'"
        earlier, later, share = self._states.around(stamp, what)
        one, other = (self._pose(state, robot, name) for state in (earlier, later))
        return between(one, other, share)

    def _pose(self, state: RobotState, robot: int, name: str) -> Pose:
        """Return the pose of a robot's frame at a state; raises ModelError for one it has not."""
        model, q = self._team.robots[robot], state.q[self._team.q_slices[robot]]
        if model.has_base and name == _BASE:
            return _upright(model.base_pose(q))
        try:
            return model.at(q, model.frame(name))[0]
        except ModelError:
            if not model.has_base or name != _BASE_LINK:
                raise
        return _upright(model.base_pose(q))


def _upright(place: Vector) -> Pose:
    """Return x, y, yaw as a pose on the floor."""
    x, y, yaw = (float(value) for value in place)
    return Pose(np.array([x, y, 0.0]), from_rpy((0.0, 0.0, yaw)))
