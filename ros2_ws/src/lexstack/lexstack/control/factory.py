"""From a resolved scenario to the parts that run: the one place where they are put together."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from lexstack.config.resolved import ResolvedScenario
from lexstack.control.controller import Controller
from lexstack.control.stack_solver import StackSolver
from lexstack.errors import ConfigurationError
from lexstack.hqp import Damper, SolverFactory, make_solver
from lexstack.limits.limits_in_force import BoxLaw, LimitOptions, LimitsInForce
from lexstack.references import ReferenceSchedule
from lexstack.robots import Team
from lexstack.tasks.stack import Stack, build_stack
from lexstack.transition.manager import Transition


@dataclass(frozen=True, slots=True)
class Parts:
    """What a scenario's controllers share: built anew for each of them.

    Attributes:
        team: the robots.
        stacks: that can be asked for, by name.
        dt: control period [s].
        unfit: why the other stacks of the configuration cannot be asked for, by name.
    """

    team: Team
    stacks: dict[str, Stack]
    dt: float
    unfit: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def of(
        cls, resolved: ResolvedScenario, folder: str = "config", *, every: bool = False
    ) -> Parts:
        """Build team and stacks; leave out a stack that does not fit, unless the scenario names it.

        Args:
            resolved: the scenario.
            folder: of the configuration, for the texts of errors.
            every: whether all stacks of the scenario must fit, as in one that has run already.

        Raises:
            ConfigurationError: a stack that must fit does not fit the robots.
            ModelError: a robot cannot be built.
        """
        team = Team.from_scenario(resolved)
        stacks, unfit = {}, dict(resolved.unfit)
        for name, config in resolved.stacks.items():
            file = f"stacks/{name}.yaml"
            try:
                stacks[name] = build_stack(config, team, f"config/{file}")
            except ConfigurationError as error:
                if every or name in resolved.scenario.stacks_named:
                    text = str(error).removeprefix(f"config/{file}")
                    raise ConfigurationError(f"{folder}/{file}{text}") from error
                unfit[name] = str(error)
        return cls(team, stacks, 1.0 / resolved.scenario.rate, unfit)


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
        Transition(parts.stacks, local, resolved.scenario, parts.team, parts.unfit),
        solver() if solver else make_solver(resolved.scenario.solver),
        box or build_limits(resolved, parts),
        damper,
    )


def build_limits(resolved: ResolvedScenario, parts: Parts) -> LimitsInForce:
    """Return how robot A keeps its limits."""
    scenario = resolved.scenario
    options = LimitOptions(parts.dt, scenario.limit_jerk, scenario.transition.limits_move)
    return LimitsInForce(parts.team.limits, options)
