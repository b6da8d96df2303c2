"""The cycle of ticks with real robots: time does not stand still for them, they are braked."""

from __future__ import annotations

from lexstack.errors import InputError
from lexstack.types import Vector
from lexstack_plant.hardware.memory import Phase
from lexstack_plant.hardware.plant import HardwarePlant
from lexstack_plant.tick_cycle import TickCycle


class HardwareCycle(TickCycle):
    """Ticks run from the moment at which all robots are enabled until they have come to rest.

    Attributes:
        plant: the robots.
        runs: how often ticks have begun: every time after the first is a reset for controllers.
    """

    plant: HardwarePlant
    runs = 0

    def enable(self, name: str) -> str:
        """Enable a robot, and begin when all are; return what happened, in words.

        Raises:
            InputError: it may not move now.
        """
        if not self.plant.enable(name):
            waits = [other for other in self.plant.robots if other not in self.plant.armed]
            return f"{name} is enabled; motion begins when {', '.join(waits)} is enabled too"
        self.runs += 1
        self.state = self.plant.state()
        self._budget = None
        self.start()
        return "all robots are enabled"

    def rewind(self, back: float) -> None:
        """Brake all robots, as time went back by so much [s]: a simulator began again.

        The present tick ends a period from now: its deadline would come much later.
        """
        self.plant.stop(f"time went back by {back:.3g} s")
        now = self._clock()
        self.pacer.start(now)
        self.pacer.begin(now)
        self.deadline = self.pacer.deadline

    def take(self, tick: int, chi: Vector) -> None:
        """Take the command of a tick; raises InputError while robots are braked."""
        if self.plant.phase is Phase.STOPPING:
            raise InputError(f"the robots are braked: {self.plant.reason}")
        super().take(tick, chi)

    def pause(self) -> None:
        """Brake all robots and disable them."""
        self.plant.stop("paused")

    def resume(self, ticks: int | None = None) -> None:
        """Raise InputError: robots are enabled by name."""
        raise InputError(f"the robots are {self.plant.phase.value}: {self.plant.reason}")

    def reset(self) -> None:
        """Raise InputError: real robots do not jump back."""
        raise InputError("real robots cannot be reset; disable and enable them")

    def _begin(self) -> None:
        """Publish the state, measured now while nothing is sent."""
        if self.paused:
            self.state = self.plant.look()
        super()._begin()

    def _end(self) -> None:
        """Send the command, and begin the next tick, or rest."""
        if self.ended:
            self.plant.stop("the scenario has ended")
        self.state = self.plant.step(self._command, self.pacer.due)
        self._command = None
        if self.plant.resting:
            self._budget = 0
        self._begin()
