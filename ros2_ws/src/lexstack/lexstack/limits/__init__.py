"""Limits of joints, and the bounds on the commanded velocity that keep them."""

from lexstack.limits.jerk_bounds import JerkLaw
from lexstack.limits.joint_limits import LIMITS, Bounds, JointLimits
from lexstack.limits.limit_timing import Motion
from lexstack.limits.limit_transition import LimitBlend
from lexstack.limits.limits_in_force import BoundsProvider, LimitOptions, LimitsInForce
from lexstack.limits.stopping import approach_speed
from lexstack.limits.travel import travel_time
from lexstack.limits.viable_bounds import is_viable, target_bounds, viable_bounds

__all__ = [
    "LIMITS",
    "Bounds",
    "BoundsProvider",
    "JerkLaw",
    "JointLimits",
    "LimitBlend",
    "LimitOptions",
    "LimitsInForce",
    "Motion",
    "approach_speed",
    "is_viable",
    "target_bounds",
    "travel_time",
    "viable_bounds",
]
