"""What the live page is told: one JSON text from the newest messages."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

from lexstack_core.model import Team
from lexstack_core.references import References
from lexstack_core.rotation import to_quaternion
from lexstack_interfaces.msg import Chi, PlantState, TransitionStatus
from lexstack_ros.conversions import to_seconds

_PLANT = {
    PlantState.FOLLOWING: "following",
    PlantState.HOLDING: "holding",
    PlantState.BRAKING: "braking",
    PlantState.PAUSED: "paused",
}
_PHASE = {
    TransitionStatus.IDLE: "idle",
    TransitionStatus.REQUESTED: "requested",
    TransitionStatus.PREPARING: "preparing",
    TransitionStatus.BLENDING: "blending",
    TransitionStatus.ADOPTING: "adopting",
    TransitionStatus.ABORTED: "aborted",
}


def news(
    team: Team,
    state: PlantState,
    status: TransitionStatus | None,
    chi: Mapping[str, Chi],
    references: References,
) -> str:
    """Return the text for ``live.js``: metres, seconds, and solve times in ms.

    Args:
        team: the robots.
        state: of the plant.
        status: of the transition, None before the first.
        chi: the newest of each robot that has sent one; robot A's is the command.
        references: in effect.
    """
    time = to_seconds(state.header.stamp)
    command = chi.get(team.names[0])
    status = status or TransitionStatus()
    blending = status.phase == TransitionStatus.BLENDING
    content: dict[str, Any] = {
        "time": time,
        "tick": int(state.tick),
        "q": [round(value, 5) for value in state.q],
        "plant": _PLANT.get(state.status, "?"),
        "stack": f"{status.from_stack} → {status.to_stack}" if blending else status.to_stack,
        "phase": _PHASE.get(status.phase, "?"),
        "alpha": _finite(status.alpha),
        "source": status.source,
        "reason": status.reason,
        "levels": [] if command is None else [_finite(slack) for slack in command.slacks],
        "solve": {name: 1e3 * _finite(one.solve_time) for name, one in chi.items()},
        "ee": [[*pose.position, *to_quaternion(pose.rotation)] for pose in references.ee],
        "base": [base.tolist() for base in references.base],
        "obstacles": team.obstacles.at(time).ravel().tolist(),
    }
    return json.dumps(content, separators=(",", ":"), allow_nan=False)


def _finite(value: float) -> float:
    """Return a number that JSON can hold."""
    return float(value) if math.isfinite(value) else 0.0
