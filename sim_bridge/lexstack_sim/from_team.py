"""Robots in MuJoCo without a scenario, for programs on the library."""

from __future__ import annotations

from lexstack.robots import Team
from lexstack.transition import TransitionConfig
from lexstack.types import Vector
from lexstack_config.plant import PlantConfig
from lexstack_config.resolved import ResolvedScenario
from lexstack_config.scenario import PlacementConfig, ScenarioConfig
from lexstack_sim.plant import Plant


def mujoco_plant(team: Team, q: Vector, config: PlantConfig | None = None) -> Plant:
    """Return robots under joint impedance control in MuJoCo: ``plant`` of ``lexstack.Lockstep``.

    Args:
        team: the robots; their control period must be a multiple of 1 ms.
        q: where they start, shape (n_q,), m and rad.
        config: what is not ideal about it; None: nothing.

    Raises:
        ConfigurationError: a value does not fit; the text says which.
    """
    scenario = ScenarioConfig(
        name="run",
        description="",
        robots={name: PlacementConfig(name) for name in team.names},
        rate=1.0 / team.dt,
        duration=1.0,
        initial_stack="",
        transition=TransitionConfig(duration=1.0),
        plant=config or PlantConfig(),
    )
    return Plant(ResolvedScenario(scenario, {}, {}), team, start=q)
