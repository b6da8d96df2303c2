"""References: where the end effectors and the bases shall be, and from when on.

The controller decides at which tick a target takes effect (``ReferenceSchedule``); whoever else
needs the references follows its decisions (``ReferenceTimeline``).
"""

from typing import TYPE_CHECKING

from lexstack import on_demand

if TYPE_CHECKING:
    from lexstack.references.encoding import WIDTHS, decode, encode
    from lexstack.references.schedule import ReferenceSchedule
    from lexstack.references.set_point import BASES, POSES, Fading, SetPoint
    from lexstack.references.timeline import ROUNDING, ReferenceTimeline, Setting
    from lexstack.references.values import References, Target, measured
else:
    __getattr__ = on_demand(
        __name__,
        {
            "encoding": "WIDTHS decode encode",
            "schedule": "ReferenceSchedule",
            "set_point": "BASES POSES Fading SetPoint",
            "timeline": "ROUNDING ReferenceTimeline Setting",
            "values": "References Target measured",
        },
    )

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
