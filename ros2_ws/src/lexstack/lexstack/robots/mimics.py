"""Which joints of a URDF mimic another one, and how."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from dataclasses import dataclass

from lexstack.errors import ModelError


@dataclass(frozen=True, slots=True)
class Mimic:
    """A joint whose position is ``multiplier * q + offset``, q that of another joint."""

    joint: str
    multiplier: float
    offset: float  # rad, or m


def followed(name: str, mimics: Mapping[str, Mimic]) -> Mimic:
    """Return the independent joint that a joint follows, through others that follow too."""
    joint, multiplier, offset = name, 1.0, 0.0
    while joint in mimics:
        mimic = mimics[joint]
        offset += multiplier * mimic.offset
        multiplier *= mimic.multiplier
        joint = mimic.joint
    return Mimic(joint, multiplier, offset)


def numbers(text: str | None) -> tuple[float, ...]:
    """Return the numbers in an attribute; none where they are none."""
    try:
        return tuple(float(word) for word in (text or "").split())
    except ValueError:
        return ()


def read_mimics(tree: ET.Element, where: str) -> dict[str, Mimic]:
    """Return who mimics whom; raises ModelError for one that follows nobody, or itself."""
    kinds = {joint.get("name", ""): joint.get("type") for joint in tree.findall("joint")}
    found = {}
    for joint in tree.findall("joint"):
        mimic, name = joint.find("mimic"), joint.get("name", "")
        if mimic is None or kinds[name] == "fixed":
            continue
        primary = mimic.get("joint", "")
        factors = numbers(mimic.get("multiplier", "1")), numbers(mimic.get("offset", "0"))
        if kinds.get(primary, "fixed") == "fixed" or "planar" in (kinds[name], kinds[primary]):
            raise ModelError(
                f"{where}: joint {name!r} mimics {primary!r}: not a joint of one coordinate"
            )
        if any(len(each) != 1 or not math.isfinite(each[0]) for each in factors):
            raise ModelError(f"{where}: joint {name!r}: mimic: multiplier and offset are numbers")
        found[name] = Mimic(primary, factors[0][0], factors[1][0])
    for name in found:
        then, count = name, 0
        while then in found:
            then, count = found[then].joint, count + 1
            if count > len(found):
                raise ModelError(f"{where}: joint {name!r} mimics itself, by way of others")
    return found
