"""One level of Algorithm 2: SQP on H(9), with the line search of H(13)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lexstack.mpc.iteration_clock import IterationClock
from lexstack.mpc.level_problem import Iterate, Program, Quadratic
from lexstack.mpc.lexicographic_constraints import LexicographicConstraint
from lexstack.mpc.limited_qp import EMPTY, ActiveSet, LevelQp, condensed_qp
from lexstack.mpc.linear_rows import LinearRows
from lexstack.mpc.options import HtmpcConfig
from lexstack.mpc.stage_kinematics import StageKinematics
from lexstack.mpc.status import LevelStatus, Outcome
from lexstack.mpc.structured_qp import structured_qp
from lexstack.mpc.tracking_objectives import Task
from lexstack.types import Matrix, Vector

_CONVERGED = 1e-10  # of the cost: a step that promises less is no step
_BEND = 0.05  # m or rad with H(12): the most second-order error that a whole step may have
_PROBE = 0.25  # of a step: where its second-order error is measured


@dataclass(frozen=True, slots=True)
class _Step:
    """What one iteration came to: the iterate after it, and how."""

    iterate: Iterate
    outcome: Outcome
    alpha: float
    trials: int
    blocked_by: str
    qp: str


class Level:
    """One task, within the constraints of the levels above.

    Attributes:
        active_set: what held in the last QP, or at first what probably will.
    """

    def __init__(
        self,
        config: HtmpcConfig,
        program: Program,
        task: Task,
        constraints: tuple[LexicographicConstraint, ...],
        active_set: ActiveSet = EMPTY,
        clock: IterationClock | None = None,
    ) -> None:
        """Take the level's task, and the constraints of the levels above, highest first."""
        self._clock = IterationClock() if clock is None else clock
        self._left = 0
        self._config = config
        self._program = program
        self._task = task
        self._constraints = constraints
        self.active_set = active_set
        # Where every distance counts, the joints of every state are coupled, and so where a base
        # drives: then the condensed QP is as small.
        coupled = program.differential or (
            program.collisions.active and not config.collision.influence
        )
        self._structured = config.qp == "structured" and not coupled

    def better(self, start: Iterate, other: Iterate) -> Iterate:
        """Return the other iterate if it costs less and violates no constraint, else the first."""
        cost = self._program.cost(start, self._task)
        return start if self._rejection_reason(other, cost) else other

    def solve(self, start: Iterate) -> tuple[Iterate, LevelStatus]:
        """Return the last iterate, and how it was reached."""
        steps: list[_Step] = []
        iterate = start
        first = self._program.cost(start, self._task)
        late = False
        for _ in range(self._config.iterations):
            late = not self._clock.enough()
            if late:
                break
            step = self._step(iterate)
            self._clock.done()
            steps.append(step)
            before, iterate = iterate, step.iterate
            if step.outcome is not Outcome.STEPPED or self._stops_early(before, iterate):
                break
        last = self._program.cost(iterate, self._task)
        return iterate, self._status(steps, first - last, iterate, late)

    def _stops_early(self, before: Iterate, after: Iterate) -> bool:
        """Return whether another iteration is not worth its time: the task hardly gained by this.

        The task's own part counts: level 1 could always go on to save effort, which the levels
        below spend again.
        """
        least = self._config.early_stop_ratio * abs(self._program.cost(before, self._task))
        gained = self._cost(before) - self._cost(after)
        return self._config.early_stop_ratio > 0.0 and gained < least

    def _cost(self, iterate: Iterate) -> float:
        """Return J of H(8) alone."""
        return self._task.cost_at(iterate.at)

    def _status(
        self, steps: list[_Step], decrease: float, iterate: Iterate, late: bool
    ) -> LevelStatus:
        """Return the level's status: its last iteration decides, but a step stays a step."""
        outcome = steps[-1].outcome if steps else Outcome.LATE
        if outcome is Outcome.BLOCKED and len(steps) > 1:
            outcome = Outcome.STEPPED
        return LevelStatus(
            level=len(self._constraints),
            name=self._task.objective.name,
            outcome=outcome,
            iterations=len(steps),
            steps=tuple(step.alpha for step in steps),
            trials=sum(step.trials for step in steps),
            blocked_by=next((s.blocked_by for s in reversed(steps) if s.blocked_by), ""),
            qp=steps[-1].qp if steps else "not tried",
            cost=self._cost(iterate),
            decrease=decrease,
            late=late,
            condensed=self._left,
        )

    def _step(self, iterate: Iterate) -> _Step:
        """Do one iteration of SQP."""
        cost = self._program.cost(iterate, self._task)
        quadratic = self._program.quadratic(iterate, self._task)
        if not (np.isfinite(cost) and np.isfinite(quadratic.gradient).all()):
            return _Step(iterate, Outcome.FAILED, 0.0, 0, "", "not tried: a cost is not finite")
        direction, bend, word = self._direction(iterate, quadratic)
        if word != "solved":
            # The zero step is always allowed (``LinearRows``): "infeasible" is the verdict of
            # rounding on rows that depend on each other. The iterate is as good as it was, and the
            # levels below may be served.
            vain = word == "infeasible" and self._constraints
            return _Step(iterate, Outcome.BLOCKED if vain else Outcome.FAILED, 0.0, 0, "", word)
        slope = float(quadratic.gradient @ direction)
        if -slope <= _CONVERGED * max(1.0, abs(cost)):
            return _Step(iterate, Outcome.CONVERGED, 0.0, 0, "", word)
        shape = iterate.u.shape
        return self._search(iterate, direction.reshape(shape), bend.reshape(shape), cost, slope)

    def _search(
        self, iterate: Iterate, direction: Matrix, bend: Matrix, cost: float, slope: float
    ) -> _Step:
        """Backtrack until the cost falls enough and no constraint is violated, H(13).

        The trials are on the curve u + alpha d + alpha^2 b. Its slope at alpha = 0 is that of d, so
        Armijo's rule uses g.d whatever b is. Its second-order error in the constraints is alpha^2
        times that of the whole step, so one b serves all trials.
        """
        rules = self._config.line_search
        alpha, rejected = 1.0, ""
        for trial in range(1, rules.trials + 1):
            tried = self._program.iterate(iterate.u + alpha * direction + alpha**2 * bend)
            verdict = self._rejection_reason(tried, cost + rules.descent * alpha * slope)
            if not verdict:
                return _Step(tried, Outcome.STEPPED, alpha, trial, rejected, "solved")
            rejected = verdict
            alpha *= rules.beta
        return _Step(iterate, Outcome.BLOCKED, 0.0, rules.trials, rejected, "solved")

    def _rejection_reason(self, tried: Iterate, limit: float) -> str:
        """Return why a trial is not taken; empty if it is."""
        for constraint in self._constraints:
            excess, where = constraint.excess(constraint.task.error(tried.at))
            if not excess <= 0.0:
                return where
        cost = self._program.cost(tried, self._task)
        if not np.isfinite(cost):
            return "not finite"
        return "" if cost <= limit else "descent"

    def _direction(self, iterate: Iterate, quadratic: Quadratic) -> tuple[Vector, Vector, str]:
        """Return the step d, its correction b, shapes (N n,), and the solver's word.

        The constraints are curved: on the straight line u + d their values e differ from the linear
        e + E d by c, of second order in d, and H(13) would shorten the step for it. b is the
        smallest correction, in the metric of H, that makes up for c:

            min b.H b / 2    subject to    lower <= E (d + b) + c <= upper

        To second order these bounds then hold for every alpha in [0, 1], because

            alpha E d + alpha^2 (E b + c) = (alpha - alpha^2) E d + alpha^2 (E (d + b) + c)

        is a mean of 0, E d and E (d + b) + c, and all three are within [lower, upper]: the zero
        step because the bounds were opened for it (``LinearRows``).
        """
        none = np.zeros(iterate.u.size)
        rows = LinearRows.of(
            self._constraints,
            iterate.at,
            quadratic.sensitivity,
            self._task.moving,
            iterate.u.size,
        )
        make = structured_qp if self._structured else condensed_qp
        limited, word = make(quadratic, rows, self._program.hard, iterate.u, self.active_set)
        if limited is None:
            return none, none, word
        direction, bend, word = self._solved(iterate, limited, rows)
        self._left += limited.left
        return direction, bend, word

    def _solved(
        self, iterate: Iterate, limited: LevelQp, rows: LinearRows
    ) -> tuple[Vector, Vector, str]:
        """Solve a QP, and the one for the correction: see ``_direction``."""
        none = np.zeros(iterate.u.size)
        direction, word = limited.solve(rows.lower, rows.upper)
        # Kept before the second QP: it is a guess for the first one of the next iteration.
        self.active_set = limited.active_set
        if word != "solved" or not (self._config.second_order_correction and self._constraints):
            return direction, none, word
        # A step by s d has the second-order error s^2 c. Where max |c| exceeds 0.05, s is chosen so
        # that s^2 max |c| = 0.05; otherwise s = 1.
        bent = self._bent(iterate, limited, direction)
        scale = min(1.0, float(np.sqrt(_BEND / max(np.abs(bent).max(), _BEND))))
        shorter = scale * direction
        bent *= scale * scale
        # In terms of d + b the problem is the first one, with its bounds shifted by c and with s d
        # as the point to be near to: the same factors and rows serve. If it has no solution, the
        # straight step of the first QP is used, and the line search decides.
        corrected, again = limited.nearest(shorter, rows.lower - bent, rows.upper - bent)
        if again != "solved":
            return direction, none, word
        return shorter, corrected - shorter, word

    def _bent(self, iterate: Iterate, qp: LevelQp, direction: Vector) -> Vector:
        """Return c, the second-order error of the constraints for a whole step d, shape (r,).

            c = (e(u + h d) - e(u) - h E d) / h^2,    h = 1/4

        For a quadratic e any h gives the same c. Terms of third order enter with a factor h,
        rounding with 1 / h^2.
        """
        step = _PROBE * direction
        tried = self._program.kinematics(iterate.u + step.reshape(iterate.u.shape))
        off = self._values(tried) - self._values(iterate.at) - qp.along(step)
        return np.asarray(off / _PROBE**2)

    def _values(self, at: StageKinematics) -> Vector:
        """Return the values of all constraints, one after the other."""
        return np.concatenate(
            [constraint.value(constraint.task.error(at)) for constraint in self._constraints]
        )
