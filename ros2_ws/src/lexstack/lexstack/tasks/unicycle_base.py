"""The task ``base`` of a robot that cannot go sideways: a stabiliser of its pose.

    chi_base -> (v, w) of the law in ``unicycle_law``

No rows Phi chi -> lambda (x_d - x) lead a differential base to a pose: no smooth law of the state
does. The law drives along the line to the goal and turns, and arrives with the heading asked for.
"""

from __future__ import annotations

import numpy as np

from lexstack.references import References
from lexstack.robots import Kinematics, Team
from lexstack.tasks.unicycle_law import paced, tracking_rates
from lexstack.types import Curve, LinearTask


class UnicycleBase:
    """(v, w) -> the law for the integrated pose x*, within the robot's own limits."""

    def __init__(self, team: Team, robot: int, gain: float) -> None:
        """Make the task of the robot at place ``robot``; ``gain`` in 1/s."""
        model, start = team.robots[robot], team.slices[robot].start
        self.name = f"{team.names[robot]}/base"
        self.robots = (robot,)
        self._robot = robot
        place = team.q_slices[robot].start
        self._place = slice(place, place + 3)
        self._matrix = np.eye(2, team.n, start)
        self._matrix.setflags(write=False)  # solvers may remember it
        self._gain = gain
        speeds, rates = model.limits.velocity[:2].tolist(), model.limits.acceleration[:2].tolist()
        self._limits = ((speeds[0], speeds[1]), (rates[0], rates[1]))
        self._curve = Curve(gain, (robot,), (team.slices[robot],))

    def linearise(self, kinematics: Kinematics, references: References) -> LinearTask:
        """Return 2 rows: forward speed [m/s] and yaw rate [rad/s]."""
        x, y, yaw = kinematics.state.q_star[self._place].tolist()
        goal_x, goal_y, goal_yaw = references.base[self._robot].tolist()
        feed, gap = references.motion.bases.get(self._robot), (goal_x - x, goal_y - y)
        if feed is None:
            rates = paced(gap, yaw, goal_yaw, self._gain, self._limits)
            return LinearTask.equality(self.name, self._matrix, np.array(rates), self._curve)
        x_d, y_d, w_d = feed.tolist()
        v_d = float(np.cos(goal_yaw) * x_d + np.sin(goal_yaw) * y_d)
        rates = tracking_rates(gap, yaw, (goal_yaw, v_d, w_d), self._gain)
        both = np.array((v_d, w_d))
        return LinearTask.equality(
            self.name, self._matrix, np.array(rates) - both, self._curve, both
        )
