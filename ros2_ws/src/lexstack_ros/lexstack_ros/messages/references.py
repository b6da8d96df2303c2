"""The controller's decisions on references as messages, and back."""

from __future__ import annotations

from lexstack.references import WIDTHS, Setting, decode, encode
from lexstack.robots import Team
from lexstack_interfaces.msg import References
from lexstack_ros.messages.conversions import check_robots, stamped, to_array, to_seconds


def references_message(setting: Setting, team: Team, sender: str) -> References:
    """Return a decision as a message."""
    message = References(revision=setting.revision, sender=sender, robots=list(team.names))
    for name, vector in encode(setting).items():
        setattr(message, name, to_array(vector))
    return stamped(message, setting.at)


def to_setting(message: References, team: Team, where: str) -> Setting:
    """Return a decision; raises InputError. ``where``: its topic."""
    check_robots(message.robots, team, where)
    vectors = {name: getattr(message, name) for name in WIDTHS}
    at = to_seconds(message.header.stamp)
    return decode(at, message.revision, vectors, len(team.robots), where)
