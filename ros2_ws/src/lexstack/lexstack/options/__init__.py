"""Options: plain values as frozen dataclasses, strict in keys, types and ranges.

The type of a field says what it takes: ``Positive``, ``Name``, ``Annotated[float, Range(0, 1)]``.
What concerns several fields, a dataclass checks in ``validate(where)``. ``build`` makes an option
from mappings, lists, texts and numbers, and says in every error where it stood.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

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

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Numbers = Sequence[float] | NDArray[np.float64]
else:
    Numbers = tuple[Finite, ...]
"""Finite numbers: a list in files; programs may give an array, which becomes a tuple."""

__all__ = [
    "OLD_NAMES",
    "Finite",
    "Finite3",
    "Name",
    "NotEmpty",
    "NotNegative",
    "Numbers",
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
