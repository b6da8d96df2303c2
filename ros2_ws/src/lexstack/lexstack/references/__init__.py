"""References: where the end effectors and the bases shall be, and from when on.

Robot A decides at which tick a target takes effect (``ReferenceSchedule``); whoever else needs the
references follows its decisions (``ReferenceTimeline``).
"""

from lexstack.references.encoding import WIDTHS, decode, encode
from lexstack.references.schedule import ReferenceSchedule
from lexstack.references.set_point import BASES, POSES, Fading, SetPoint
from lexstack.references.timeline import ROUNDING, ReferenceTimeline, Setting
from lexstack.references.values import References, Target, measured

__all__ = [
    "BASES",
    "POSES",
    "ROUNDING",
    "WIDTHS",
    "Fading",
    "ReferenceSchedule",
    "ReferenceTimeline",
    "References",
    "SetPoint",
    "Setting",
    "Target",
    "decode",
    "encode",
    "measured",
]
