"""Closed loops towards targets out of reach on an exact integrator, and the least error there."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from lexstack.control import Command
from lexstack.hqp import Damped, Damper, HqpProblem
from lexstack.limits import JointLimits, LimitOptions, LimitsInForce
from lexstack.references import Target
from lexstack.robots import Kinematics, Team
from lexstack.tasks import cross, other_end, pose_error
from lexstack.types import LinearTask, Matrix, Vector
from lexstack_config.parts import Parts, build_controller
from lexstack_config.resolved import ResolvedScenario
from lexstack_experiments.experiments.reach_cases import KINDS, Case, scenario
from lexstack_experiments.ideal import IdealPlant
from lexstack_experiments.measuring import after_last

REST = 0.01  # of a joint's velocity limit: slower, it is at rest
REACHED = 1e-3  # m or rad
_PLAIN = 0.1  # m or 1: the damping of the baseline


class Undamped(Damper):
    """Solves every problem as it is."""

    def damped(self, problem: HqpProblem, kinematics: Kinematics, limits: JointLimits) -> Damped:
        """Return the problem itself."""
        return Damped(problem, problem)


class PlainDamping(Damper):
    """Levenberg and Marquardt's damping of every tool level, at all times: the strong baseline."""

    def damped(self, problem: HqpProblem, kinematics: Kinematics, limits: JointLimits) -> Damped:
        """Return [J; mu I] chi -> [b; 0] for every level with a curved task."""
        n = problem.bounds.lower.size
        rows = LinearTask.equality("damping", _PLAIN * np.eye(n), np.zeros(n))
        levels = tuple(
            (*level, rows) if any(task.curve and task.curve.signs for task in level) else level
            for level in problem.levels
        )
        return Damped(problem, HqpProblem(levels, problem.bounds))


LAWS: dict[str, Callable[[Team, float], Damper]] = {
    "undamped": Undamped,
    "plain damping": PlainDamping,
    "lexstack": Damper,
}
"""What is compared."""


@dataclass(frozen=True)
class Motion:
    """A run of one case.

    Attributes:
        case: the targets.
        team: the robots.
        chi: the commands, shape (T, n).
        q: where the robots were, shape (T + 1, n).
        commands: all that the controller sent.
    """

    case: Case
    team: Team
    chi: Matrix
    q: Matrix
    commands: Sequence[Command]

    def rest_after(self) -> float | None:
        """Return from when on all joints are at rest [s]; None: not at the end."""
        fast = np.abs(self.chi / self.team.limits.velocity).max(axis=1) >= REST
        return after_last(fast) * self.team.dt if not fast[-1] else None

    def reached_after(self) -> float | None:
        """Return from when on the tool's error is below ``REACHED`` [s]; None: not at the end."""
        far = np.array([np.abs(errors(self.case, self.team, q)[0]).max() > REACHED for q in self.q])
        return after_last(far) * self.team.dt if not far[-1] else None

    def sign_changes(self, seconds: float) -> float:
        """Return the most changes of sign of a joint's velocity per second, near the end."""
        tail = self.chi[-round(seconds / self.team.dt) :]
        felt = np.abs(tail) > 1e-4 * self.team.limits.velocity
        changed = (tail[1:] * tail[:-1] < 0.0) & felt[1:] & felt[:-1]
        return float(changed.sum(axis=0).max()) / seconds

    def damped(self) -> float:
        """Return the share of ticks at which a level was damped."""
        return float(np.mean([any(near.rows for near in c.near) for c in self.commands]))

    def excess(self) -> float:
        """Return how far half the squared error at the end is above the least one from there."""
        return gap(self.case, self.team, self.q[-1])


def run(
    resolved: ResolvedScenario,
    case: Case,
    law: str,
    seconds: float,
    back: float = 0.0,
    *,
    jerk: bool = False,
) -> Motion:
    """Return the run towards a case's targets from the start on, and back home after that.

    Args:
        resolved: a scenario of two robots.
        case: whose targets.
        law: key of ``LAWS``.
        seconds: towards the targets.
        back: seconds after them, with the tools' first poses as targets.
        jerk: whether jerk limits are kept.
    """
    small = scenario(resolved, case)
    parts = Parts.of(small)
    damper = LAWS[law](parts.team, parts.dt)
    box = LimitsInForce(parts.team.limits, LimitOptions(parts.dt, jerk), parts.team.joint_positions)
    controller = build_controller(small, parts, box=box, damper=damper)
    plant = IdealPlant(small, parts.team)
    starts = parts.team.tools(plant.state().q)
    for robot, (tool, base) in enumerate(zip(case.tools, case.bases, strict=True)):
        controller.references.add(Target(0.0, robot, ee=tool, base=base))
        if back:
            controller.references.add(Target(seconds, robot, ee=starts[robot]))
    commands, positions = [], [plant.state().q]
    for _ in range(round((seconds + back) / parts.dt)):
        commands.append(controller.tick(plant.state()))
        positions.append(plant.step(commands[-1].chi).q)
    chi = np.array([command.chi for command in commands])
    return Motion(case, parts.team, chi, np.array(positions), commands)


def errors(case: Case, team: Team, q: Vector) -> tuple[Vector, Matrix]:
    """Return the error of a case's tool level, and its derivative by the joints with other sign."""
    pairs = [robot.tool(q[part]) for robot, part in zip(team.robots, team.slices, strict=True)]
    tools, jacobians = [pose for pose, _ in pairs], [jacobian for _, jacobian in pairs]
    if "relative_pose" in KINDS[case.kind]:
        goal = other_end(tools[0], case.tools[0], case.tools[1])
        moved = -jacobians[0]
        moved[:3] += cross(goal.position - tools[0].position) @ jacobians[0][3:]
        return pose_error(tools[1], goal), np.hstack([moved, jacobians[1]])
    rows = 3 if "ee_position" in KINDS[case.kind] else 6
    error, matrix = np.empty(rows * len(tools)), np.zeros((rows * len(tools), team.n))
    for i, (tool, part) in enumerate(zip(tools, team.slices, strict=True)):
        here = slice(rows * i, rows * i + rows)
        error[here] = pose_error(tool, case.tools[i])[:rows]
        matrix[here, part] = jacobians[i][:rows]
    return error, matrix


def gap(case: Case, team: Team, q: Vector) -> float:
    """Return by how much half the squared error at q is above the least one nearby [m^2].

    Found by scipy from q on, within the joints' limits; a base that a level above holds stays.
    """
    limits = team.limits
    fixed = np.zeros(team.n, dtype=bool)
    if KINDS[case.kind][0] == "base":
        for part in team.slices:
            fixed[part.start : part.start + 3] = True
    lower = np.where(fixed, q, np.maximum(limits.position_lower, q - 5.0))
    upper = np.where(fixed, q, np.minimum(limits.position_upper, q + 5.0))

    def cost(x: Vector) -> tuple[float, Vector]:
        error, matrix = errors(case, team, x)
        return 0.5 * float(error @ error), -matrix.T @ error

    start = np.clip(q, lower, upper)
    here = cost(start)[0]
    box = list(zip(lower, upper, strict=True))
    options = {
        "L-BFGS-B": {"maxiter": 3000, "ftol": 1e-16, "gtol": 1e-10, "maxcor": 30},
        "TNC": {"maxfun": 4000, "ftol": 1e-16, "gtol": 1e-12},
    }
    found = [
        minimize(cost, start, jac=True, method=name, bounds=box, options=values).fun
        for name, values in options.items()
    ]
    return here - min(here, *found)
