"""References: where the end effectors and the bases shall be, and from when on.

Robot A decides at which tick a target takes effect (``ReferenceSchedule``); whoever else needs the
references follows its decisions (``ReferenceTimeline``).
"""

from lexstack_core.references.schedule import ReferenceSchedule
from lexstack_core.references.set_point import Fading, SetPoint
from lexstack_core.references.timeline import ReferenceTimeline, Setting
from lexstack_core.references.values import References, Target, measured, pose_from_config

__all__ = [
    "Fading",
    "ReferenceSchedule",
    "ReferenceTimeline",
    "References",
    "SetPoint",
    "Setting",
    "Target",
    "measured",
    "pose_from_config",
]
