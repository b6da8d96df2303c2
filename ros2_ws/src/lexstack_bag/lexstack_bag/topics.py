"""The topics of a run by name and type: what nodes, bag and experiments go by."""

from __future__ import annotations

from collections.abc import Iterable

_OURS = "lexstack_interfaces/msg"

PLANT_STATE = "/plant/state"
COMMAND, SOLUTION = "/robot_a/chi", "/robot_b/chi"  # whatever the robots are called
TRANSITION = "/robot_a/transition"
REQUEST = "/robot_a/stack_request"
DECISIONS = "/robot_a/references"
SCENARIO = "/robot_a/scenario"
"""Where the controller publishes the resolved scenario, for recorders of others."""
PLAN, PROGRESS, SEQUENCE = "/htmpc/plan", "/htmpc/status", "/htmpc/sequence"

NEEDED = (PLANT_STATE, COMMAND)
"""Topics without which there is nothing to analyse."""

STREAMS = {
    "/clock": "rosgraph_msgs/msg/Clock",
    PLANT_STATE: f"{_OURS}/PlantState",
    COMMAND: f"{_OURS}/Chi",
    SOLUTION: f"{_OURS}/Chi",
    TRANSITION: f"{_OURS}/TransitionStatus",
}
"""What is sent while ticks go on: state and chi at every tick, the rest less often."""

TOOLS = {
    "joint_states": "sensor_msgs/msg/JointState",
    "ee_pose": "geometry_msgs/msg/PoseStamped",
    "odom": "nav_msgs/msg/Odometry",
}
"""What is sent of each robot for tools, below the robot's name."""

TARGETS = {
    "ee_target": "geometry_msgs/msg/PoseStamped",
    "ee_twist": "geometry_msgs/msg/TwistStamped",
    "ee_trajectory": "trajectory_msgs/msg/MultiDOFJointTrajectory",
    "base_target": "geometry_msgs/msg/PoseStamped",
    "base_twist": "geometry_msgs/msg/TwistStamped",
    "base_path": "nav_msgs/msg/Path",
    "posture_trajectory": "trajectory_msgs/msg/JointTrajectory",
}
"""Where users set references of each robot, below the robot's name."""

ONLOOKERS = {
    "/tf": "tf2_msgs/msg/TFMessage",
    "/tf_static": "tf2_msgs/msg/TFMessage",
    "/markers": "visualization_msgs/msg/MarkerArray",
}
"""What is sent for RViz and Foxglove alone; the last by the live page."""


ROLES = {
    "robot_a": ("controller", ("chi", "references", "scenario", "stack_request", "transition")),
    "robot_b": ("solver", ("chi", "references")),
}
"""By the paper's name of a computer: its role, and the topics that may be named by the role."""

ASKED = ("cancel_transition", "request_stack", "switch_stack")
"""Where users ask the controller, below its name."""


def role_names() -> dict[str, str]:
    """Return the names by roles of all topics and services that have one, by the paper's."""
    asked = {f"/robot_a/{name}": f"/{ROLES['robot_a'][0]}/{name}" for name in ASKED}
    return asked | {
        f"/{paper}/{name}": f"/{role}/{name}"
        for paper, (role, names) in ROLES.items()
        for name in names
    }


_PLAIN = {by_role: by_paper for by_paper, by_role in role_names().items()}


def plain_name(topic: str, namespace: str = "") -> str:
    """Return what a recorded topic is called here, '' if it lies outside of the namespace.

    /cell1/plant/state in the namespace /cell1 is /plant/state, and /controller/chi is /robot_a/chi.
    """
    if not topic.startswith(f"{namespace}/"):
        return ""
    own = topic.removeprefix(namespace)
    return _PLAIN.get(own, own)


def contract_topics(robots: Iterable[str]) -> dict[str, str]:
    """Return name and type of lexstack's own volatile topics for these robots.

    The recorder subscribes to them before anybody publishes, so that nothing is missed at the
    start. Latched topics need no such care.
    """
    return {
        **STREAMS,
        "/diagnostics": "diagnostic_msgs/msg/DiagnosticArray",
        "/robot_a/request_stack": "std_msgs/msg/String",
        **{
            f"/{name}/{topic}": kind for name in robots for topic, kind in (TOOLS | TARGETS).items()
        },
    }
