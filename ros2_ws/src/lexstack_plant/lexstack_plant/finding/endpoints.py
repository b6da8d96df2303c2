"""What a ROS graph has that may belong to a plant, as values."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

JOINT_STATE = "sensor_msgs/msg/JointState"
ODOMETRY = "nav_msgs/msg/Odometry"
TF = "tf2_msgs/msg/TFMessage"
CLOCK = "rosgraph_msgs/msg/Clock"
TRAJECTORY = "trajectory_msgs/msg/JointTrajectory"
VALUES = "std_msgs/msg/Float64MultiArray"
TWIST = "geometry_msgs/msg/Twist"
TWIST_STAMPED = "geometry_msgs/msg/TwistStamped"

STATES = frozenset({JOINT_STATE, ODOMETRY, TF, CLOCK})  # of which publishers count
COMMANDS = frozenset({TRAJECTORY, VALUES, TWIST, TWIST_STAMPED})  # of which listeners count


@dataclass(frozen=True, slots=True)
class Endpoint:
    """A topic that somebody publishes states on, or listens for commands on.

    Attributes:
        topic: its name, from the root.
        kind: the type of its messages, like ``sensor_msgs/msg/JointState``.
        joints: that it is about, where that is known.
        interface: of an array: ``velocity``, ``position`` or ``effort``, where it is known.
        active: whether its controller is.
    """

    topic: str
    kind: str
    joints: tuple[str, ...] = ()
    interface: str = ""
    active: bool = True


@dataclass(frozen=True, slots=True)
class Controller:
    """A controller of ros2_control.

    Attributes:
        path: of its node, below which its topics are, like ``/cell/arm_controller``.
        active: whether it commands.
        joints: that it claims.
        interface: the kind of command that it gives the hardware, if it is one.
    """

    path: str
    active: bool
    joints: tuple[str, ...]
    interface: str


def told(endpoints: Iterable[Endpoint], controllers: Iterable[Controller]) -> list[Endpoint]:
    """Return endpoints with what their controllers say of them."""
    known = list(controllers)
    found = []
    for endpoint in endpoints:
        mine = next((c for c in known if endpoint.topic.startswith(f"{c.path}/")), None)
        if mine is None or endpoint.kind not in COMMANDS:
            found.append(endpoint)
        else:
            said = {"joints": mine.joints, "interface": mine.interface, "active": mine.active}
            found.append(replace(endpoint, **said))
    return found
