"""Options: plain values as frozen dataclasses, strict in keys, types and ranges.

The type of a field says what it takes: ``Positive``, ``Name``, ``Annotated[float, Range(0, 1)]``.
What concerns several fields, a dataclass checks in ``validate(where)``. ``build`` makes an option
from mappings, lists, texts and numbers, and says in every error where it stood.
"""

from lexstack.options.build import OLD_NAMES, build, hints
from lexstack.options.registry import register, unknown
from lexstack.options.rules import (
    Finite,
    Finite3,
    Name,
    NotEmpty,
    NotNegative,
    Pattern,
    Positive,
    Range,
    RosName,
    same_length,
    shown,
)

__all__ = [
    "OLD_NAMES",
    "Finite",
    "Finite3",
    "Name",
    "NotEmpty",
    "NotNegative",
    "Pattern",
    "Positive",
    "Range",
    "RosName",
    "build",
    "hints",
    "register",
    "same_length",
    "shown",
    "unknown",
]
