"""From which stack to which one robots go, and for which request."""

from __future__ import annotations

from dataclasses import dataclass

from lexstack.tasks.stack import Stack
from lexstack.transition.requests import SwitchRequest
from lexstack.transition.robot_group import RobotGroup


@dataclass(frozen=True, slots=True, eq=False)
class Route:
    """From where to where.

    Attributes:
        request: that is served.
        group: the robots that go.
        origin: the stack that they come from.
        target: the stack that they go to.
        whole: whether they are all robots that this stack moves.
    """

    request: SwitchRequest
    group: RobotGroup
    origin: Stack
    target: Stack
    whole: bool

    def of(self, group: RobotGroup) -> Route:
        """Return the route of some of its robots."""
        origin, target = self.origin.of(group.robots), self.target.of(group.robots)
        return Route(self.request, group, origin, target, whole=False)
