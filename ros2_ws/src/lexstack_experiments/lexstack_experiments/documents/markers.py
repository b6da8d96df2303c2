"""What stands between two markers of a document comes from a field.

``<!-- from NAME -->old<!-- / -->`` becomes ``<!-- from NAME -->new<!-- / -->``. A text of one line
stays in its sentence, longer ones stand apart.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping

from lexstack.errors import ConfigurationError

_MARKED = re.compile(r"<!-- from ([\w.-]+) -->(.*?)<!-- / -->", re.DOTALL)
_BEGIN = re.compile(r"<!-- from ")


def filled(text: str, fields: Mapping[str, Callable[[], str]], where: str) -> str:
    """Return a document with every marked place filled.

    Args:
        text: of the document.
        fields: what each name stands for.
        where: the document's name, for errors.

    Raises:
        ConfigurationError: a name that no field has, or a marker without its end.
    """

    def value(match: re.Match[str]) -> str:
        name = match.group(1)
        if name not in fields:
            known = ", ".join(sorted(fields))
            raise ConfigurationError(f"{where}: no field {name!r}; known: {known}")
        new = fields[name]()
        new = f"\n\n{new}\n\n" if "\n" in new else new
        return f"<!-- from {name} -->{new}<!-- / -->"

    if len(_BEGIN.findall(text)) != len(_MARKED.findall(text)):
        raise ConfigurationError(f"{where}: a marker '<!-- from ... -->' has no '<!-- / -->'")
    return _MARKED.sub(value, text)


def names_in(text: str) -> list[str]:
    """Return the names of the fields that a document shows, in order."""
    return [name for name, _ in _MARKED.findall(text)]
