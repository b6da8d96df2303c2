"""What the live page is told: one JSON text from the newest messages."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from typing import Any

from lexstack.references import References
from lexstack.robots import Team, to_quaternion
from lexstack.transition import Phase
from lexstack.types import PlantStatus
from lexstack_interfaces.msg import Chi, PlantState, TransitionStatus
from lexstack_ros.messages.conversions import to_seconds

COMMANDER, SOURCE = "robot_a", "robot_b"  # the controllers, whatever the robots are called
_PLANT = {status.value: status.name.lower() for status in PlantStatus}
_OLD = 10  # ticks
_PHASE = {phase.value: phase.name.lower() for phase in Phase}


def news(
    team: Team,
    state: PlantState,
    statuses: Sequence[TransitionStatus],
    chi: Mapping[str, Chi],
    references: References,
) -> str:
    """Return the text for ``live.js``: metres, seconds, and solve times in ms.

    Args:
        team: the robots.
        state: of the plant.
        statuses: of the transitions at one tick; they are about different robots.
        chi: the newest of each controller that has sent one, the controller first: the command.
        references: in effect.
    """
    time = to_seconds(state.header.stamp)
    command = chi.get(COMMANDER)
    busy = [status for status in statuses if status.phase != TransitionStatus.IDLE]
    status = (busy or [*statuses, TransitionStatus()])[0]
    content: dict[str, Any] = {
        "time": time,
        "tick": int(state.tick),
        "q": [round(value, 5) for value in state.q],
        "plant": _PLANT.get(state.status, "?"),
        "stack": "; ".join(_stack(team, status) for status in statuses),
        "phase": _PHASE.get(status.phase, "?"),
        "alpha": _finite(status.alpha),
        "source": status.source,
        "reason": status.reason,
        "levels": [] if command is None else [_finite(slack) for slack in command.slacks],
        "solve": {name: _solve_time(one, state) for name, one in chi.items()},
        "ee": [[*pose.position, *to_quaternion(pose.rotation)] for pose in references.ee],
        "base": [base.tolist() for base in references.base],
        "obstacles": team.obstacles.at(time).ravel().tolist(),
    }
    return json.dumps(content, separators=(",", ":"), allow_nan=False)


def _stack(team: Team, status: TransitionStatus) -> str:
    """Return which stack is in effect, which one comes, and of whom if not of all."""
    names = list(status.robots)
    whose = f" ({', '.join(names)})" if set(names) not in (set(), set(team.names)) else ""
    if status.phase == TransitionStatus.BLENDING:
        return f"{status.from_stack} → {status.to_stack}{whose}"
    if status.phase in (TransitionStatus.REQUESTED, TransitionStatus.PREPARING):
        return f"{status.from_stack}, then {status.to_stack}{whose}"
    return f"{status.to_stack}{whose}"


def _solve_time(chi: Chi, state: PlantState) -> float | None:
    """Return a solve time [ms]; None where the solution is old: nothing was solved since."""
    return 1e3 * _finite(chi.solve_time) if chi.tick + _OLD >= state.tick else None


def _finite(value: float) -> float:
    """Return a number that JSON can hold."""
    return float(value) if math.isfinite(value) else 0.0
