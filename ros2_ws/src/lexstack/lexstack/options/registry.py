"""Registries: what files name, by its name; extensions add to them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeVar, get_args

from lexstack.errors import ConfigurationError
from lexstack.options.rules import Name, Pattern, shown

_T = TypeVar("_T")
_NAME: Pattern = get_args(Name)[1]


def register(known: dict[str, _T], what: str, name: str, entry: _T) -> None:
    """Add an entry to a registry under a name.

    Args:
        known: the registry.
        what: it holds, for errors.
        name: letters, digits, _ and -.
        entry: replaces one of the same module, as when that is loaded again.

    Raises:
        ConfigurationError: it is no name, or one that another module has taken.
    """
    _NAME.check(name, f"{what} {shown(name)}: name")
    home, taken = _home(entry), _home(known.get(name, entry))
    if home != taken:
        raise ConfigurationError(f"{what} {name!r} of {home}: is registered already by {taken}")
    known[name] = entry


def _home(entry: object) -> str:
    """Return the module of a class, of a function, or of the class whose method it is."""
    return getattr(getattr(entry, "__self__", entry), "__module__", "")


def unknown(what: str, name: object, known: Iterable[str]) -> str:
    """Return a line that tells which names a registry knows, and where others come from."""
    more = f"{', '.join(known)}; extensions of the scenario add others"
    compared = {"method", "solver"}  # those of experiments are extensions, too
    such = f", such as lexstack_experiments.{what}s" if what in compared else ""
    return f"unknown {what} {shown(name)}; known: {more}{such}"
