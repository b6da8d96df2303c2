"""Message definitions as rosbag2 stores them: the .msg text, then that of every type it needs."""

from __future__ import annotations

import os
import re
import sys
from functools import cache
from pathlib import Path

from lexstack_bag.errors import BagError

_SEPARATOR = "=" * 80
_FIELD = re.compile(r"^\s*([A-Za-z][\w/]*)(?:<=\d+)?(?:\[[^\]]*\])?\s+\w+")


@cache
def message_definition(type_name: str) -> str:
    """Return the full ``ros2msg`` definition of a message type.

    Args:
        type_name: as ROS names it, e.g. ``std_msgs/msg/Header``.

    Returns:
        The type's text; then for each type that it needs, directly or not, once: a line of 80
        ``=``, a line ``MSG: pkg/Type`` and that type's text.

    Raises:
        BagError: the name is not that of a message, or no text of it is installed.
    """
    texts: dict[str, str] = {}
    waiting = [type_name]
    while waiting:
        name = waiting.pop(0)
        if name in texts:
            continue
        texts[name] = _message_text(name)
        waiting += _needed_types(texts[name], name.split("/", 1)[0])
    first, *rest = texts.items()
    return first[1] + "".join(
        f"\n{_SEPARATOR}\nMSG: {name.replace('/msg/', '/')}\n{text}" for name, text in rest
    )


@cache
def type_hash(type_name: str) -> str:
    """Return the installed type's hash, ``RIHS01_...``; raises BagError.

    Two types of one name have the same hash where their fields are the same.
    """
    # 0.05 s that a recorder, which hashes nothing, does not spend before it is ready.
    from rosbags.typesys import (  # noqa: PLC0415
        Stores,
        get_types_from_msg,
        get_typestore,
    )

    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(message_definition(type_name), type_name))
    return str(store.hash_rihs01(type_name))


def _message_text(type_name: str) -> str:
    """Return the .msg text of one type, searched in the ament prefixes."""
    package, _, kind = type_name.partition("/msg/")
    if not kind:
        raise BagError(f"{type_name}: not a message type")
    for prefix in _prefixes():
        path = prefix / "share" / package / "msg" / f"{kind}.msg"
        if path.is_file():
            return path.read_text(encoding="utf-8")
    raise BagError(f"{type_name}: no definition found; is its package installed and sourced?")


def _prefixes() -> list[Path]:
    """Return where packages are installed: the sourced prefixes, then this environment."""
    sourced = os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
    return [Path(prefix) for prefix in sourced if prefix] + [Path(sys.prefix)]


def _needed_types(text: str, package: str) -> list[str]:
    """Return the full names of the message types that a .msg text's fields have."""
    needed = []
    for line in text.splitlines():
        match = _FIELD.match(line.split("#", 1)[0])
        if match is None:
            continue
        owner, _, kind = match[1].replace("/msg/", "/").rpartition("/")
        if kind[0].islower():  # a primitive: the names of messages are in camel case
            continue
        needed.append(f"{owner or package}/msg/{kind}")
    return needed
