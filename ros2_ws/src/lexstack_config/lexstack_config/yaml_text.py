"""YAML of the plain kind: mappings, lists, texts, numbers, booleans, null; nothing clever.

A configuration file may come from anywhere, so what YAML offers beyond that is refused: keys that
stand twice (the last would win silently), aliases (a few lines can stand for gigabytes), tags.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

from lexstack.errors import ConfigurationError

_LARGEST = 4_000_000  # bytes; the largest of ours has 20 kB
_TAGS = ("null", "bool", "int", "float", "str", "seq", "map")
_PREFIX = "tag:yaml.org,2002:"


class _PlainLoader(yaml.SafeLoader):
    """Builds plain values alone."""

    yaml_constructors = {  # noqa: RUF012 - PyYAML's way
        **{_PREFIX + tag: yaml.SafeLoader.yaml_constructors[_PREFIX + tag] for tag in _TAGS},
        None: yaml.SafeLoader.yaml_constructors[None],  # refuses every other tag
    }
    yaml_implicit_resolvers = {  # noqa: RUF012
        first: [(tag, form) for tag, form in forms if tag.removeprefix(_PREFIX) in _TAGS]
        for first, forms in yaml.SafeLoader.yaml_implicit_resolvers.items()
    }

    def compose_node(self, parent: yaml.Node | None, index: Any) -> yaml.Node | None:
        """Refuse aliases."""
        if self.check_event(yaml.AliasEvent):
            mark = self.get_mark()
            raise yaml.MarkedYAMLError(None, None, "aliases are not supported", mark)
        return super().compose_node(parent, index)

    def flatten_mapping(self, node: yaml.MappingNode) -> None:
        """Refuse a key that stands twice; merge keys are keys like all others."""
        seen = set()
        for key, _ in node.value:
            name = (key.tag, key.value) if isinstance(key, yaml.ScalarNode) else None
            if name in seen:
                problem = f"the key {key.value!r} stands here for the second time"
                raise yaml.MarkedYAMLError(None, None, problem, key.start_mark)
            seen.add(name or key)


def read_text(path: Path) -> str:
    """Return a file's text; raises ConfigurationError unless it is a file of UTF-8, not huge."""
    try:
        if path.exists() and not path.is_file():
            raise ConfigurationError(f"{path}: cannot be read: it is no regular file")
        with path.open("rb") as file:
            data = file.read(_LARGEST + 1)
        if len(data) > _LARGEST:
            raise ConfigurationError(f"{path}: cannot be read: more than {_LARGEST} bytes")
        return data.decode("utf-8")
    except (OSError, ValueError) as error:
        raise ConfigurationError(f"{str(path)!r}: cannot be read: {_line(error)}") from error


def parse_plain(text: str, where: str) -> dict[str, Any]:
    """Return the mapping in a YAML text; ``where`` names its origin in errors.

    Raises:
        ConfigurationError: it is no YAML of the plain kind, or no mapping.
    """
    try:
        data = yaml.load(text, Loader=_PlainLoader)  # noqa: S506 - builds less than SafeLoader
    except RecursionError as error:
        raise ConfigurationError(f"{where}: not valid YAML: nested too deeply") from error
    except (yaml.YAMLError, ValueError) as error:  # ValueError: a number of 5000 digits
        raise ConfigurationError(f"{where}: not valid YAML: {_line(error)}") from error
    if not isinstance(data, dict):
        raise ConfigurationError(f"{where}: expected a mapping of keys, got {type(data).__name__}")
    return data


def _line(error: Exception) -> str:
    """Return an error's text in one printable line."""
    text = " ".join(str(error).split())
    return "".join(letter if letter.isprintable() else "?" for letter in text)
