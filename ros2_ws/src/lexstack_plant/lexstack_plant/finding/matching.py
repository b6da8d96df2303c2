"""Which topics are whose: from a list of endpoints to the content of a plant file."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from lexstack_plant.finding.endpoints import (
    CLOCK,
    JOINT_STATE,
    ODOMETRY,
    TF,
    TRAJECTORY,
    TWIST,
    TWIST_STAMPED,
    VALUES,
    Endpoint,
)

_INTERFACES = ("velocity", "position", "effort")


@dataclass(frozen=True, slots=True)
class Wanted:
    """A robot of a scenario.

    Attributes:
        name: the scenario's.
        model: a name of config/robots.
        joints: of its arm, as its file names them.
        has_base: whether it drives.
    """

    name: str
    model: str
    joints: tuple[str, ...]
    has_base: bool


@dataclass(frozen=True, slots=True)
class Found:
    """What was found.

    Attributes:
        content: of a plant file; a key whose topic is missing or ambiguous is left out.
        notes: what is missing, ambiguous or to be looked at, a line each.
    """

    content: dict[str, Any]
    notes: tuple[str, ...]


def find_plant_content(
    name: str, wanted: Sequence[Wanted], endpoints: Sequence[Endpoint], rate: float = 100.0
) -> Found:
    """Return the content of a plant file for the robots of a scenario.

    Nothing is guessed where two topics fit equally: a wrong one would move another robot.

    Args:
        name: of the file.
        wanted: the robots.
        endpoints: what there is.
        rate: of the plant [Hz].
    """
    names = [robot.name for robot in wanted]
    searches = [_Search(robot, names, endpoints) for robot in wanted]
    content: dict[str, Any] = {
        "name": name,
        "description": "As it was found running.",
        "rate": rate,
        "robots": {search.robot.name: search.run() for search in searches},
    }
    notes = [note for search in searches for note in search.notes]
    if any(each.kind == CLOCK and each.topic == "/clock" for each in endpoints):
        content["use_sim_time"] = True
        notes.append("/clock is there: time is the simulator's")
    return Found(content, tuple(notes))


class _Search:
    """The topics of one robot.

    Attributes:
        robot: whose.
        notes: what was not found, or not for certain.
    """

    def __init__(self, robot: Wanted, names: Sequence[str], endpoints: Sequence[Endpoint]) -> None:
        """Look at all endpoints that do not name another robot."""
        self.robot = robot
        self.notes: list[str] = []
        others = {name for name in names if name != robot.name}
        self._mine = [each for each in endpoints if not others & set(each.topic.split("/"))]

    def run(self) -> dict[str, Any]:
        """Return the robot's part of the file."""
        states = self._joint_states()
        content: dict[str, Any] = {"model": self.robot.model}
        if states:
            content["joint_states"] = states
        if self.robot.has_base:
            content["base"] = self._base()
        content["arm"] = self._arm(states.get("names", {}))
        return content

    def _joint_states(self) -> dict[str, Any]:
        """Return the topic of the joints, and their names in its messages where they differ."""
        matched = {
            each.topic: (prefix, len(each.joints))
            for each in self._of(JOINT_STATE)
            if (prefix := _prefix(self.robot.joints, each.joints)) is not None
        }
        chosen = self._choose(
            "joint_states.topic",
            [each for each in self._of(JOINT_STATE) if each.topic in matched],
            # The same names before others; the topic of one robot before that of many.
            lambda each: (not matched[each.topic][0], -matched[each.topic][1]),
            f"no JointState has {', '.join(self.robot.joints)}",
        )
        if chosen is None:
            return {}
        prefix = matched[chosen.topic][0]
        names = {joint: f"{prefix}{joint}" for joint in self.robot.joints} if prefix else {}
        return {"topic": chosen.topic} | ({"names": names} if names else {})

    def _arm(self, names: dict[str, str]) -> dict[str, Any]:
        """Return the topic and the type of the arm's commands."""
        joints = {names.get(joint, joint) for joint in self.robot.joints}
        fitting = []
        about = [e for e in self._of(TRAJECTORY, VALUES) if not e.joints or joints & set(e.joints)]
        for each in about:
            wrong = self._unfit(each, joints)
            if wrong:
                self.notes.append(f"{self._key('arm.command')}: not {each.topic}: {wrong}")
            else:
                fitting.append(each)
        chosen = self._choose(
            "arm.command",
            fitting,
            lambda each: (bool(each.joints), each.kind == TRAJECTORY),
            "nobody listens for JointTrajectory or Float64MultiArray",
        )
        if chosen is None:
            return {}
        if not chosen.joints:
            self._note("arm.command", f"the joints of {chosen.topic} are not known: compare them")
        kind = "joint_trajectory" if chosen.kind == TRAJECTORY else _interface(chosen)
        return {"command": chosen.topic, "type": kind}

    def _unfit(self, each: Endpoint, joints: set[str]) -> str:
        """Return why a topic cannot be that of the arm, or ''."""
        if not each.active:
            return "its controller is not active"
        if each.joints and set(each.joints) != joints:
            missing, more = sorted(joints - set(each.joints)), sorted(set(each.joints) - joints)
            lacks = f"its controller lacks {', '.join(missing)}" if missing else ""
            return lacks or f"its controller has {', '.join(more)} too"
        if each.kind == VALUES and not _interface(each):
            return f"nothing says whether it is {', '.join(_INTERFACES[:2])} or {_INTERFACES[2]}"
        return ""

    def _base(self) -> dict[str, Any]:
        """Return the topics of the platform."""
        content: dict[str, Any] = {}
        command = self._choose(
            "base.command",
            [each for each in self._of(TWIST, TWIST_STAMPED) if each.active],
            lambda each: ("cmd_vel" in each.topic, each.kind == TWIST_STAMPED),
            "nobody listens for Twist or TwistStamped",
        )
        near = command.topic.split("/")[:-1] if command else []
        odometry = self._choose(
            "base.odometry",
            self._of(ODOMETRY),
            lambda each: (_shared(each.topic.split("/")[:-1], near),),
            "nobody publishes Odometry",
        )
        if odometry is not None:
            content["odometry"] = odometry.topic
        elif any(each.kind == TF and each.topic == "/tf" for each in self._mine):
            content["tf"] = {"frame": "base_link", "parent": "odom"}
            self._note("base.tf", "the names of the frames are those of REP-105: compare them")
        if command is not None:
            stamped = command.kind == TWIST_STAMPED
            content |= {"command": command.topic, "type": "twist_stamped" if stamped else "twist"}
        return content

    def _of(self, *kinds: str) -> list[Endpoint]:
        """Return the endpoints of some types."""
        return [each for each in self._mine if each.kind in kinds]

    def _choose(
        self,
        key: str,
        candidates: Sequence[Endpoint],
        rank: Callable[[Endpoint], tuple[int, ...]],
        none: str,
    ) -> Endpoint | None:
        """Return the best candidate, if it is better than all others; else say so.

        A topic with the robot's name in it is better than one without, then ``rank`` counts.
        """
        if not candidates:
            self._note(key, none)
            return None
        ranks = [(self.robot.name in c.topic.split("/"), *rank(c)) for c in candidates]
        best = [c for c, each in zip(candidates, ranks, strict=True) if each == max(ranks)]
        if len(best) > 1:
            self._note(key, f"one of {', '.join(sorted(each.topic for each in best))}")
            return None
        return best[0]

    def _note(self, key: str, text: str) -> None:
        """Say something about a key of the file."""
        self.notes.append(f"{self._key(key)}: {text}")

    def _key(self, key: str) -> str:
        """Return a key of this robot in the file."""
        return f"robots.{self.robot.name}.{key}"


def _prefix(joints: Sequence[str], names: Sequence[str]) -> str | None:
    """Return what messages have before the names of all joints; None: they are not in them."""
    if not joints:
        return None
    ends = [name[: -len(joints[0])] for name in names if name.endswith(joints[0])]
    fitting = [p for p in ends if all(f"{p}{joint}" in names for joint in joints)]
    return min(fitting, key=len) if fitting else None


def _interface(endpoint: Endpoint) -> str:
    """Return what an array of values is, by its controller or its name, or ''."""
    named = [each for each in _INTERFACES if each in endpoint.topic]
    return endpoint.interface or (named[0] if len(named) == 1 else "")


def _shared(one: Sequence[str], other: Sequence[str]) -> int:
    """Return how many parts two paths have in common, from the root."""
    pairs = list(zip(one, other, strict=False))
    return next((i for i, (a, b) in enumerate(pairs) if a != b), len(pairs))
