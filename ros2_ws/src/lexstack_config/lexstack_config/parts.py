"""From a resolved scenario to what runs in a process: team, stacks, controller, solver."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from lexstack.control import Controller, StackSolver, make_controller, make_stack_solver
from lexstack.errors import ConfigurationError
from lexstack.hqp import Damper, SolverFactory
from lexstack.limits import BoundsProvider
from lexstack.references import ReferenceSchedule
from lexstack.robots import Obstacles, RobotModel, Team
from lexstack.tasks import Stack, build_stack
from lexstack.transition import TransitionOptions
from lexstack.types import Vector
from lexstack_config.folders import Folders
from lexstack_config.reader import advised
from lexstack_config.resolved import ResolvedScenario
from lexstack_config.scenario import ScenarioConfig, pose_from_config


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
        cls, resolved: ResolvedScenario, folders: Folders | None = None, *, every: bool = False
    ) -> Parts:
        """Build team and stacks; leave out a stack that does not fit, unless the scenario names it.

        Args:
            resolved: the scenario.
            folders: of the configuration, for the texts of errors.
            every: whether all stacks of the scenario must fit, as in one that has run already.

        Raises:
            ConfigurationError: a stack that must fit does not fit the robots.
            ModelError: a robot cannot be built.
        """
        team = build_team(resolved)
        stacks, unfit = {}, dict(resolved.unfit)
        for name, config in resolved.stacks.items():
            file = f"config/stacks/{name}.yaml"
            try:
                stacks[name] = build_stack(config, team, file)
            except ConfigurationError as error:
                if every or name in resolved.scenario.stacks_named:
                    path = file if folders is None else folders.find("stacks", name)
                    text = advised(error).removeprefix(file)
                    raise ConfigurationError(f"{path}{text}") from error
                unfit[name] = advised(error)
        return cls(team, stacks, 1.0 / resolved.scenario.rate, unfit)


def build_team(resolved: ResolvedScenario) -> Team:
    """Return the team of a scenario, and the obstacles in its way."""
    scenario = resolved.scenario
    robots = (
        RobotModel(name, resolved.robots[place.model], place.mounting)
        for name, place in scenario.robots.items()
    )
    return Team(tuple(robots), 1.0 / scenario.rate, Obstacles(scenario.obstacles))


def home_of(team: Team, resolved: ResolvedScenario) -> Vector:
    """Return the configuration at which a scenario starts, shape (n,)."""
    return team.home({name: place.base for name, place in resolved.scenario.robots.items()})


def transition_options(scenario: ScenarioConfig) -> TransitionOptions:
    """Return what the transitions of a scenario's controller follow: its times in ticks."""
    times, rate = scenario.timeouts, scenario.rate
    return TransitionOptions(
        scenario.initial_stack,
        scenario.transition,
        lockstep=scenario.mode == "lockstep",
        limit_jerk=scenario.limit_jerk,
        horizon=scenario.horizon_ticks,
        patience=round(times.source_patience * rate),
        stale=round(times.source_stale * rate),
        plan_every=scenario.htmpc.ticks(rate),
        plan_stale=round(times.plan_stale * rate),
    )


def build_references(resolved: ResolvedScenario, team: Team) -> ReferenceSchedule:
    """Return the scenario's first references."""
    scenario = resolved.scenario
    return ReferenceSchedule.at_home(
        team,
        home_of(team, resolved),
        {name: pose_from_config(pose) for name, pose in scenario.ee_target.items()},
        {name: np.array(place) for name, place in scenario.base_target.items()},
        lead_in=scenario.lead_in,
        horizon=scenario.timeouts.target_horizon,
    )


def build_stack_solver(
    resolved: ResolvedScenario,
    parts: Parts,
    solver: SolverFactory | None = None,
    damper: Damper | None = None,
) -> StackSolver:
    """Return robot B's solver; ``solver`` and ``damper`` are others than the scenario's."""
    chosen = solver or resolved.scenario.solver
    return make_stack_solver(parts.team, parts.stacks, chosen, damper)


def build_controller(
    resolved: ResolvedScenario,
    parts: Parts,
    solver: SolverFactory | None = None,
    box: BoundsProvider | None = None,
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
    return make_controller(
        parts.team,
        parts.stacks,
        transition_options(resolved.scenario),
        build_references(resolved, parts.team),
        unfit=parts.unfit,
        solver=solver or resolved.scenario.solver,
        box=box,
        damper=damper,
    )
