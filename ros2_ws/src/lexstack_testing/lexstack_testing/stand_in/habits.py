"""The habits of hardware, each switchable; without any the stand-in is a good simulator."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

from lexstack.errors import ConfigurationError


@dataclass(frozen=True, slots=True)
class Habits:
    """What robots and networks do; 0 and false: not at all.

    Attributes:
        rate: Hz, at which states are sent; inside everything runs at 1 kHz.
        jitter: s, by which a message may be late, equally distributed from 0.
        drop: share of messages, in both directions, that are lost.
        late: share of messages that are late by ``late_by``.
        late_by: s.
        repeat: share of states that are sent twice.
        reorder: whether the joints come in another order every time, and others between them.
        velocities: whether joint states have velocities.
        quantum: rad, resolution of the encoders.
        drift: share of its way and its turn by which the odometry is wrong.
        speed: of time at most, where /clock tells it: simulated s per s of the wall's.
        reflex: whether the drives stop at a step beyond their acceleration and jerk limits.
    """

    rate: float = 125.0
    jitter: float = 0.0
    drop: float = 0.0
    late: float = 0.0
    late_by: float = 0.03
    repeat: float = 0.0
    reorder: bool = False
    velocities: bool = True
    quantum: float = 0.0
    drift: float = 0.0
    speed: float = 1.0
    reflex: bool = True


ALL = Habits(
    jitter=0.002,
    drop=0.01,
    late=0.01,
    repeat=0.01,
    reorder=True,
    velocities=False,
    quantum=1e-4,
    drift=0.01,
)
"""All of them at once."""


_RANGES = {
    "rate": (1.0, 1000.0),
    "jitter": (0.0, 10.0),
    "late_by": (0.0, 10.0),
    "quantum": (0.0, 1.0),
    "drift": (-1.0, 1.0),
    "speed": (1e-3, 1000.0),
}
"""Of numbers other than shares, which are in [0, 1]."""


def parse_habits(text: str) -> Habits:
    """Return habits from a text like ``all`` or ``jitter=0.002,reorder=1``.

    Raises:
        ConfigurationError: a habit is unknown, or its value no number, or out of range.
    """
    habits = Habits()
    known = {field.name: field.type for field in fields(Habits)}
    for word in filter(None, (part.strip() for part in text.split(","))):
        if word == "all":
            habits = ALL
            continue
        name, _, value = word.partition("=")
        if name not in known:
            raise ConfigurationError(f"unknown habit {name!r}; known: all, {', '.join(known)}")
        try:
            number = float(value or 1.0)
        except ValueError as error:
            raise ConfigurationError(f"habit {name}: {value!r} is no number") from error
        least, most = _RANGES.get(name, (0.0, 1.0))
        if not least <= number <= most:
            raise ConfigurationError(
                f"habit {name}: must be in [{least:g}, {most:g}], got {number:g}"
            )
        habits = replace(habits, **{name: bool(number) if known[name] == "bool" else number})
    return habits
