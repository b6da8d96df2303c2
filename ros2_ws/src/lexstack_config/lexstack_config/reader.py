"""From YAML to frozen dataclasses: strict keys, checked types, the file and key in every error."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path
from typing import Any, TypeVar

from lexstack import options
from lexstack.errors import ConfigurationError, NotANumberError
from lexstack_config.yaml_text import parse_plain, read_text

T = TypeVar("T")

# A number for everybody but YAML 1.1: there an exponent needs its sign, and a point before it.
_ALMOST = re.compile(r"([-+]?)(\d{0,30})(\.\d{0,30})?[eE]([-+]?)(\d{1,4})")


def read_yaml(path: Path) -> dict[str, Any]:
    """Return the mapping in a YAML file; raises ConfigurationError naming file and line."""
    return parse_yaml(read_text(path), str(path))


def parse_yaml(text: str, where: str) -> dict[str, Any]:
    """Return the mapping in a YAML text; ``where`` names its origin in errors."""
    return parse_plain(text, where)


def build(kind: type[T], data: object, where: str) -> T:
    """Return a mapping of a YAML text as ``lexstack.options.build`` does, with advice in errors."""
    try:
        return options.build(kind, data, where)
    except NotANumberError as error:
        raise ConfigurationError(advised(error)) from error


def advised(error: ConfigurationError) -> str:
    """Return an error's text, with what to write where YAML takes a number for a text."""
    return f"{error}{_number_advice(error.found) if isinstance(error, NotANumberError) else ''}"


def plain(value: object) -> Any:
    """Return a dataclass tree as plain dictionaries and lists, ready for ``yaml.safe_dump``."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {f.name: plain(getattr(value, f.name)) for f in dataclasses.fields(value)}
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, tuple | list):
        return [plain(item) for item in value]
    return value


def _number_advice(value: object) -> str:
    """Return what to write where YAML takes a number for a text, as it does 1.0e9; else ''."""
    found = _ALMOST.fullmatch(value) if isinstance(value, str) else None
    if found is None:
        return ""
    sign, whole, fraction, turn, exponent = found.groups()
    if not whole and fraction in (None, "."):
        return ""
    fraction = fraction if fraction not in (None, ".") else ".0"
    number = f"{sign}{whole or '0'}{fraction}e{turn or '+'}{exponent}"
    return f", which YAML reads as text: write {number}"
