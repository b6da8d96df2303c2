"""From robots, stacks and options to the objects that run: here they are put together."""

from __future__ import annotations

from collections.abc import Mapping

from lexstack.control.controller import Controller
from lexstack.control.stack_solver import StackSolver
from lexstack.hqp import DEFAULT_SOLVER, Damper, HqpSolver, SolverFactory, make_solver
from lexstack.limits import BoundsProvider, LimitOptions, LimitsInForce
from lexstack.references import ReferenceSchedule
from lexstack.robots import Team
from lexstack.tasks import Stack
from lexstack.transition.manager import Transition
from lexstack.transition.options import TransitionOptions


def make_stack_solver(
    team: Team,
    stacks: Mapping[str, Stack],
    solver: SolverFactory | str = DEFAULT_SOLVER,
    damper: Damper | None = None,
) -> StackSolver:
    """Return what solves any of the stacks for the present state: the solver's part.

    Args:
        team: the robots.
        stacks: by name.
        solver: a key of ``SOLVERS``, or what makes another solver.
        damper: treats singularities in another way than ``Damper``.
    """
    return StackSolver(team, stacks, _made(solver), team.dt, damper)


def make_controller(
    team: Team,
    stacks: Mapping[str, Stack],
    options: TransitionOptions,
    references: ReferenceSchedule | None = None,
    *,
    unfit: Mapping[str, str] | None = None,
    solver: SolverFactory | str = DEFAULT_SOLVER,
    box: BoundsProvider | None = None,
    damper: Damper | None = None,
) -> Controller:
    """Return the controller of a team: one call of its ``tick`` per state, one command back.

    Args:
        team: the robots.
        stacks: that can be asked for, by name.
        options: of its transitions.
        references: where tools and bases shall be; None: where the robots are at the first tick.
        unfit: why other stacks cannot be asked for, by name.
        solver: a key of ``SOLVERS``, or what makes another solver.
        box: keeps the limits in another way than ``LimitsInForce``.
        damper: treats singularities in another way than ``Damper``.
    """
    limits = LimitOptions(team.dt, options.limit_jerk, options.switch.limits_move)
    return Controller(
        team,
        references or ReferenceSchedule.at_home(team, team.home()),
        Transition(stacks, make_stack_solver(team, stacks, solver, damper), options, team, unfit),
        _made(solver),
        box or LimitsInForce(team.limits, limits, team.joint_positions),
        damper,
    )


def _made(solver: SolverFactory | str) -> HqpSolver:
    """Return a new solver."""
    return make_solver(solver) if isinstance(solver, str) else solver()
