"""References: where frames, bases and arms shall be, and how fast they shall move, at any time.

Each is a ``Trajectory``: a set-point that is led in, poses at times, a spline, a stream of twists,
or one of the user's own. The controller decides at which tick a target takes effect
(``ReferenceSchedule``); whoever else needs the references follows its decisions
(``ReferenceTimeline``).
"""

from typing import TYPE_CHECKING

from lexstack import on_demand

if TYPE_CHECKING:
    from lexstack.references.base_twist import BaseTwist, BaseTwistStream
    from lexstack.references.encoding import WIDTHS, decode, encode, encode_moving
    from lexstack.references.fading import Fading
    from lexstack.references.moving import Moving
    from lexstack.references.path import path_at_speed
    from lexstack.references.point_to_point import PointToPoint
    from lexstack.references.retaking import targets_between
    from lexstack.references.schedule import ReferenceSchedule
    from lexstack.references.set_point import Led, SetPoint
    from lexstack.references.spaces import BASES, JOINTS, POSES
    from lexstack.references.spline import Spline, base_spline, load
    from lexstack.references.timeline import ROUNDING, ReferenceTimeline, Setting
    from lexstack.references.trajectory import Trajectory
    from lexstack.references.twist_stream import Twist, TwistStream
    from lexstack.references.values import (
        TOOL,
        Frame,
        Hold,
        Motion,
        References,
        Target,
        combined,
        measured,
    )
    from lexstack.references.waypoints import MotionLimits, Waypoints, timed_waypoints
else:
    __getattr__ = on_demand(
        __name__,
        {
            "base_twist": "BaseTwist BaseTwistStream",
            "encoding": "WIDTHS decode encode encode_moving",
            "fading": "Fading",
            "moving": "Moving",
            "path": "path_at_speed",
            "retaking": "targets_between",
            "point_to_point": "PointToPoint",
            "schedule": "ReferenceSchedule",
            "set_point": "Led SetPoint",
            "spaces": "BASES JOINTS POSES",
            "spline": "Spline base_spline load",
            "timeline": "ROUNDING ReferenceTimeline Setting",
            "trajectory": "Trajectory",
            "twist_stream": "Twist TwistStream",
            "values": "TOOL Frame Hold Motion References Target combined measured",
            "waypoints": "MotionLimits Waypoints timed_waypoints",
        },
    )

__all__ = [
    "BASES",
    "JOINTS",
    "POSES",
    "ROUNDING",
    "TOOL",
    "WIDTHS",
    "BaseTwist",
    "BaseTwistStream",
    "Fading",
    "Frame",
    "Hold",
    "Led",
    "Motion",
    "MotionLimits",
    "Moving",
    "PointToPoint",
    "ReferenceSchedule",
    "ReferenceTimeline",
    "References",
    "SetPoint",
    "Setting",
    "Spline",
    "Target",
    "Trajectory",
    "Twist",
    "TwistStream",
    "Waypoints",
    "base_spline",
    "combined",
    "decode",
    "encode",
    "encode_moving",
    "load",
    "measured",
    "path_at_speed",
    "targets_between",
    "timed_waypoints",
]
