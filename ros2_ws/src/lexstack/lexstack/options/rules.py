"""What a field of an option takes: ranges of numbers, forms of texts, how many entries."""

from __future__ import annotations

import math
import re
import reprlib
from collections.abc import Sized
from dataclasses import dataclass
from typing import Annotated

from lexstack.errors import ConfigurationError

_BRIEF = reprlib.Repr()
_BRIEF.maxstring = _BRIEF.maxother = 80


@dataclass(frozen=True, slots=True)
class Range:
    """Which numbers a field takes: finite ones within both ends.

    Attributes:
        least: lower end.
        most: upper end.
        open: whether the ends themselves are excluded.
    """

    least: float = -math.inf
    most: float = math.inf
    open: bool = False

    def check(self, value: float, where: str) -> None:
        """Raise ConfigurationError for a number that is infinite or out of range."""
        inside = self.least <= value <= self.most
        at_end = self.open and value in (self.least, self.most)
        if at_end or not (inside and math.isfinite(value)):
            text = str(self).removeprefix("finite and ") if isinstance(value, int) else self
            raise ConfigurationError(f"{where}: must be {text}, got {value}")

    def __str__(self) -> str:
        """Return what a number must be."""
        if math.isinf(self.least):
            return "finite" if math.isinf(self.most) else f"at most {self.most:g}"
        if math.isinf(self.most):
            return f"finite and {'>' if self.open else '>='} {self.least:g}"
        ends = "()" if self.open else "[]"
        return f"in {ends[0]}{self.least:g}, {self.most:g}{ends[1]}"


@dataclass(frozen=True, slots=True)
class Pattern:
    """Texts that match ``form`` from end to end; ``text`` says it in words."""

    form: str
    text: str

    def check(self, value: str, where: str) -> None:
        """Raise ConfigurationError for a text that does not match."""
        if not re.fullmatch(self.form, value):
            raise ConfigurationError(f"{where}: {self.text}, got {shown(value)}")


@dataclass(frozen=True, slots=True)
class NotEmpty:
    """A list or mapping needs an entry; ``text`` says it in words."""

    text: str

    def check(self, value: Sized, where: str) -> None:
        """Raise ConfigurationError for nothing."""
        if not value:
            raise ConfigurationError(f"{where}: {self.text}")


def _name(letters: str, form: str) -> Pattern:
    """Return the pattern of a name."""
    text = f"a name has {letters}, begins with a letter and has at most 64 characters"
    return Pattern(rf"[A-Za-z][{form}]{{0,63}}", text)


Finite = Annotated[float, Range()]
"""A finite number."""
Positive = Annotated[float, Range(0.0, open=True)]
"""A finite number > 0."""
NotNegative = Annotated[float, Range(0.0)]
"""A finite number >= 0."""
Finite3 = tuple[Finite, Finite, Finite]
"""Along x, y, z; of a platform x, y, yaw."""
Name = Annotated[str, _name("letters, digits, _ and -", "A-Za-z0-9_-")]
"""May be (a part of) a file's name."""
RosName = Annotated[str, _name("letters, digits and _", "A-Za-z0-9_")]
"""May be (a part of) a topic's name."""


def same_length(where: str, length: int, **values: tuple[float, ...]) -> None:
    """Raise ConfigurationError unless every list has ``length`` entries."""
    for name, value in values.items():
        if len(value) != length:
            raise ConfigurationError(f"{where}: {name}: expected {length} values, got {len(value)}")


def shown(value: object) -> str:
    """Return a value as it may stand in an error: one line, not long, whatever it is."""
    try:
        return _BRIEF.repr(value)
    except ValueError:  # an integer of more digits than Python prints
        return f"a {type(value).__name__} that is too long to show"
