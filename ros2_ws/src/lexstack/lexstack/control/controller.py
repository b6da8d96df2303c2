"""What the controller does at every tick: it serves its stack, or goes smoothly to another."""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter

import numpy as np

import lexstack.hqp
from lexstack.control.kernels import load_kernels
from lexstack.hqp import (
    Damper,
    HqpProblem,
    HqpSolver,
    NearSingular,
    Solution,
    near_singularity,
)
from lexstack.hqp.fallback import rejected
from lexstack.limits.joint_limits import Bounds, JointLimits
from lexstack.limits.limits_in_force import BoundsProvider
from lexstack.limits.viable_bounds import target_bounds
from lexstack.references import ReferenceSchedule, measured
from lexstack.robots import Kinematics, Team
from lexstack.transition.auxiliary import Auxiliary
from lexstack.transition.manager import Transition
from lexstack.transition.messages import TransitionState
from lexstack.transition.status_report import with_singularity
from lexstack.transition.tick_context import TickContext
from lexstack.types import RobotState, Vector

_BRAKING = "braking: "  # begins the reason of a fallback without any solution
_TOUCH = 1e-9  # m/s, rad/s: nearer than this chi is at its bound


@dataclass(frozen=True, slots=True)
class Command:
    """What the controller sends at one tick.

    Attributes:
        tick: the tick whose state it answers.
        stamp: that state's time [s].
        stack: names of the stacks in effect; during a blend of the one that the controller goes to.
        chi: the command, shape (n,), inside ``bounds``.
        bounds: the box at this tick.
        slacks: norm of the residual of each level that the controller solved.
        fallback: empty, or why it is not the configured solver's: another one's, or the controller
            brakes; and which auxiliary problem of a transition failed, so that a robot held its
            command.
        transitions: where the transition of each channel stands, in the order of their robots.
        solve_time: wall time of the whole tick [s].
        revision: of the references, see ``References``.
        near: the levels near a singularity; those with added rows are not strict at this tick.
        undamped: empty, or why damping could not be worked out.
    """

    tick: int
    stamp: float
    stack: str
    chi: Vector
    bounds: Bounds
    slacks: Vector
    fallback: str
    transitions: tuple[TransitionState, ...]
    solve_time: float
    revision: int = 0
    near: tuple[NearSingular, ...] = ()
    undamped: str = ""

    @property
    def brakes(self) -> bool:
        """Whether no solution could be sent: the robots brake as fast as their limits allow."""
        return self.fallback.startswith(_BRAKING)

    @property
    def near_singularity(self) -> str:
        """Which levels are near one, or why none could be damped; empty: all is regular."""
        if self.undamped:
            return self.undamped
        return near_singularity(self.near)

    @property
    def transition(self) -> TransitionState:
        """Where the transition of the first channel stands: often there is no other one."""
        return self.transitions[0]


class Controller:
    """The controller: one ``tick`` per state, one command back, always inside the bounds."""

    def __init__(
        self,
        team: Team,
        references: ReferenceSchedule,
        transition: Transition,
        solver: HqpSolver,
        box: BoundsProvider,
        damper: Damper | None = None,
    ) -> None:
        """Put the parts together; ``box`` keeps the limits, and knows the control period.

        ``damper`` is for those who compare: another one than the default.
        """
        load_kernels()
        self.references = references
        self.transition = transition
        self._team = team
        self._solver = solver
        self._box = box
        self._damper = damper or Damper(team, box.dt)
        self._sent: Vector | None = None
        self._bounds: Bounds | None = None
        self._warm: Solution | None = None
        self._problem: HqpProblem | None = None

    def tick(self, state: RobotState) -> Command:
        """Return the command for this state; it never raises for what a solver does.

        The same states, requests, targets and samples give the same commands, bit for bit.
        """
        begun = perf_counter()
        self.begin(state)
        kinematics = self._team.kinematics(state)
        references = self.references.at(state.stamp)
        due = self.transition.due(state.tick, references.revision)
        wanted, jerk = self.transition.limits(due)
        limits, bounds = self._box.at(state, wanted, self._sent, jerk=jerk)
        auxiliary = Auxiliary(
            lambda problem: self._solve(problem, kinematics, limits, None), state.command, bounds
        )
        context = TickContext(
            kinematics,
            references,
            references,
            bounds,
            self._bounds or bounds,
            free_bounds=lambda: target_bounds(
                self._team.joint_positions(state.q_star), wanted, self._box.dt
            ),
            solve=auxiliary.solve,
            limits=limits,
            dt=self._box.dt,
            held=auxiliary.held,
        )
        plans = self.transition.step(due, context)
        bounds = self._bounds = plans.problem.bounds
        solution = self._solve(plans.problem, kinematics, limits, self._warm)
        chi, fallback = checked(solution, bounds)
        self._warm = None if fallback else solution
        fallback = "; ".join([word for word in (fallback, auxiliary.failures) if word])
        self._problem = plans.problem
        self._sent = chi
        stack = self.transition.stack
        states = self.transition.finish(plans, chi)
        return Command(
            state.tick,
            state.stamp,
            stack,
            chi,
            bounds,
            solution.slacks,
            fallback,
            tuple([with_singularity(state, solution.near) for state in states]),
            perf_counter() - begun,
            references.revision,
            solution.near,
            solution.undamped,
        )

    def prepare(self, state: RobotState) -> None:
        """Decide the references of a state's tick, unless that is done."""
        self.begin(state)
        self.references.decide(state.stamp)

    def begin(self, state: RobotState) -> None:
        """Take the measured poses for the first references, where none are given."""
        if not self.references.begun:
            self.references.begin(measured(self._team, state.q))

    def awaits(self, state: RobotState) -> bool:
        """Return whether a source's chi of this tick is still to come (lockstep)."""
        return self.transition.awaits(state.tick, self.references.at(state.stamp).revision)

    def _solve(
        self,
        problem: HqpProblem,
        kinematics: Kinematics,
        limits: JointLimits,
        warm: Solution | None,
    ) -> Solution:
        """Return the solution of a problem, damped where a level is near a singularity.

        What is latched and told is about the problem's own rows: damping is added here, and nobody
        else sees it.
        """
        damped = self._damper.damped(problem, kinematics, limits)
        return damped.own(self._solver.solve(damped.problem, damped.warm(warm)))

    def obstructed(self) -> str:
        """Return which levels of the last tick a joint's bound keeps from being met, or ''.

        For whoever looks, not for every tick: where a bound is touched it takes milliseconds.
        Levels that give way to those above them, and to no bound, are left out: that is what a
        hierarchy is for.
        """
        if self._problem is None or self._warm is None:
            return ""
        bounds, chi = self._problem.bounds, self._warm.chi
        if min(float((chi - bounds.lower).min()), float((bounds.upper - chi).min())) > _TOUCH:
            return ""
        levels = lexstack.hqp.explain_unmet_levels(
            self._problem, self._warm
        )  # loads scipy.optimize, when asked
        held = [b for b in levels if any(obstacle.joint >= 0 for obstacle in b.obstacles)]
        return lexstack.hqp.describe(held, self._team.joint_names)


def checked(solution: Solution, bounds: Bounds) -> tuple[Vector, str]:
    """Return the chi that may be sent, shape (n,), and what stood in for the solver, or ''.

    The order: the solver that was asked; another one, which its ``note`` tells of; and where no
    solution may be sent (failed, not finite, out of the box), the box's nearest point to zero: the
    robots brake as fast as their limits allow.
    """
    reason, inside = rejected(solution, bounds)
    if reason:
        return np.clip(0.0, bounds.lower, bounds.upper), f"{_BRAKING}{reason}"
    if inside is not None:
        return inside, solution.note
    return np.minimum(np.maximum(solution.chi, bounds.lower), bounds.upper), solution.note
