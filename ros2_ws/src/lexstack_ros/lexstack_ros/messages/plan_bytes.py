"""Plans of the MPC as bytes: of each robot's plans nothing but numbers changes."""

from __future__ import annotations

from lexstack.mpc import Plan
from lexstack_ros.messages.cdr import Buffer
from lexstack_ros.messages.conversions import to_time
from lexstack_ros.messages.plans import inputs_of, plan_message, positions_of


class PlanBytes:
    """Makes the message of a plan."""

    def __init__(self) -> None:
        """Know no plan yet."""
        self._buffers: dict[tuple[object, ...], Buffer] = {}

    def __call__(self, plan: Plan, names: list[str]) -> bytes:
        """Return the message of a plan of the joints with these names."""
        key = (*names, plan.q.shape, plan.step)
        buffer = self._buffers.get(key)
        if buffer is None:
            buffer = self._buffers[key] = Buffer(plan_message(plan, names))
            return buffer.data
        stamp = to_time(plan.stamp)
        buffer.put("header.stamp.sec", stamp.sec)
        buffer.put("header.stamp.nanosec", stamp.nanosec)
        rows = zip(positions_of(plan), plan.v, inputs_of(plan), strict=True)
        for k, (positions, velocities, accelerations) in enumerate(rows):
            buffer.put_all(f"points.{k}.positions", positions)
            buffer.put_all(f"points.{k}.velocities", velocities)
            buffer.put_all(f"points.{k}.accelerations", accelerations)
        return buffer.data
