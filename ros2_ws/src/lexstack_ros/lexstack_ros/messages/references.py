"""Robot A's decisions on references as messages, and back."""

from __future__ import annotations

from lexstack.references import WIDTHS, Setting, decode, encode
from lexstack.robots import Team
from lexstack_interfaces.msg import References
from lexstack_ros.messages.conversions import WORLD, check_robots, to_array, to_seconds, to_time


def references_message(setting: Setting, team: Team, sender: str) -> References:
    """Return a decision as a message."""
    message = References(revision=setting.revision, sender=sender, robots=list(team.names))
    message.header.stamp = to_time(setting.at)
    message.header.frame_id = WORLD
    for name, vector in encode(setting).items():
        setattr(message, name, to_array(vector))
    return message


def to_setting(message: References, team: Team, where: str) -> Setting:
    """Return a decision; raises InputError. ``where``: its topic."""
    check_robots(message.robots, team, where)
    vectors = {name: getattr(message, name) for name in WIDTHS}
    at = to_seconds(message.header.stamp)
    return decode(at, message.revision, vectors, len(team.robots), where)
