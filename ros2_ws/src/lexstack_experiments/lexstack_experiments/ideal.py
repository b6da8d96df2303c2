"""The ideal plant of a scenario: it does what it is told, exactly and at once."""

from __future__ import annotations

from lexstack.control import ExactPlant
from lexstack.robots import Team
from lexstack_config.parts import home_of
from lexstack_config.resolved import ResolvedScenario


class IdealPlant(ExactPlant):
    """An exact plant that starts at a scenario's home."""

    def __init__(self, resolved: ResolvedScenario, team: Team) -> None:
        """Start at rest."""
        super().__init__(home_of(team, resolved), 1.0 / resolved.scenario.rate, team)
