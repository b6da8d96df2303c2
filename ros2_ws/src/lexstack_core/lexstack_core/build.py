"""From a resolved scenario to the parts that run: the one place where they are put together."""

from __future__ import annotations

from dataclasses import dataclass

from lexstack_core.config.resolved import ResolvedScenario
from lexstack_core.controller import Controller
from lexstack_core.hqp import Damper, SolverFactory, make_solver
from lexstack_core.in_force import BoxLaw, LimitOptions, LimitsInForce
from lexstack_core.model import Team
from lexstack_core.references import ReferenceSchedule
from lexstack_core.stack import Stack, build_stack
from lexstack_core.stack_solver import StackSolver
from lexstack_core.transition.machine import Transition


@dataclass(frozen=True, slots=True)
class Parts:
    """What a scenario's controllers share: built anew for each of them."""

    team: Team
    stacks: dict[str, Stack]
    dt: float

    @classmethod
    def of(cls, resolved: ResolvedScenario) -> Parts:
        """Build team and stacks; raises ConfigurationError or ModelError."""
        team = Team.from_scenario(resolved)
        stacks = {name: build_stack(config, team) for name, config in resolved.stacks.items()}
        return cls(team, stacks, 1.0 / resolved.scenario.rate)


def build_references(resolved: ResolvedScenario, team: Team) -> ReferenceSchedule:
    """Return the scenario's first references."""
    return ReferenceSchedule.from_scenario(resolved.scenario, team, team.home(resolved))


def build_stack_solver(
    resolved: ResolvedScenario,
    parts: Parts,
    solver: SolverFactory | None = None,
    damper: Damper | None = None,
) -> StackSolver:
    """Return robot B's solver; ``solver`` and ``damper`` are others than the scenario's."""
    made = solver() if solver else make_solver(resolved.scenario.solver)
    return StackSolver(parts.team, parts.stacks, made, parts.dt, damper)


def build_controller(
    resolved: ResolvedScenario,
    parts: Parts,
    solver: SolverFactory | None = None,
    box: BoxLaw | None = None,
    damper: Damper | None = None,
) -> Controller:
    """Return robot A's controller.

    Args:
        resolved: the scenario.
        parts: built from it.
        solver: makes other solvers than the scenario's.
        box: keeps the limits in another way than ``LimitsInForce``.
        damper: treats singularities in another way than ``Damper``.
    """
    local = build_stack_solver(resolved, parts, solver, damper)
    return Controller(
        parts.team,
        build_references(resolved, parts.team),
        Transition(parts.stacks, local, resolved.scenario, parts.team),
        solver() if solver else make_solver(resolved.scenario.solver),
        box or build_limits(resolved, parts),
        damper,
    )


def build_limits(resolved: ResolvedScenario, parts: Parts) -> LimitsInForce:
    """Return how robot A keeps its limits."""
    scenario = resolved.scenario
    options = LimitOptions(parts.dt, scenario.limit_jerk, scenario.transition.limits_move)
    return LimitsInForce(parts.team.limits, options)
