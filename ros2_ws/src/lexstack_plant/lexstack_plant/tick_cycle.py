"""The cycle of a tick: the state goes out, its command comes in, the plant steps. No ROS."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from lexstack.errors import InputError
from lexstack.types import PlantStatus as Status
from lexstack.types import RobotState, Vector
from lexstack_plant.pacing import Pacer

_PAUSED_PERIOD = 0.1  # s of wall time between two publications of a paused plant


class TickedPlant(Protocol):
    """What a cycle needs of a plant.

    Attributes:
        seed: of everything random in it.
    """

    seed: int

    @property
    def status(self) -> Status:
        """What the plant did in its last tick."""
        ...

    def state(self) -> RobotState:
        """Return the present state."""
        ...

    def step(self, chi: Vector | None) -> RobotState:
        """Advance by one tick under a command (n,), or without one, and return the new state."""
        ...

    def reset(self, seed: int) -> RobotState:
        """Begin anew at tick 0, and return that state."""
        ...


class TickCycle:
    """Runs a plant tick by tick, until ``last_tick``; lockstep and realtime differ in the pacer.

    While it is paused, and after the end, the same state goes out ten times a second with the
    status PAUSED, for whoever comes later; nobody answers it.

    Attributes:
        plant: the plant.
        pacer: how long to wait for a command.
        state: the state of the present tick.
        deadline: when to call ``expire`` on the monotonic clock [s]; it may move at every call.
    """

    def __init__(
        self,
        plant: TickedPlant,
        pacer: Pacer,
        last_tick: int,
        publish: Callable[[RobotState, Status], None],
        clock: Callable[[], float],
    ) -> None:
        """Make a paused cycle; ``publish`` sends a state, ``clock`` is monotonic [s]."""
        self.plant = plant
        self.pacer = pacer
        self.state = plant.state()
        self.deadline = 0.0
        self._last_tick = last_tick
        self._publish = publish
        self._clock = clock
        self._command: Vector | None = None
        self._budget: int | None = 0  # ticks that may still run; None: no limit

    @property
    def paused(self) -> bool:
        """Whether simulated time stands still."""
        return self._budget == 0

    @property
    def ended(self) -> bool:
        """Whether the last tick was reached."""
        return self.state.tick >= self._last_tick

    def start(self) -> None:
        """Begin the present tick after the plant stood still, or the first one."""
        self._command = None
        self.pacer.start(self._clock())
        self._begin()

    def take(self, tick: int, chi: Vector) -> None:
        """Take the command of a tick; in lockstep the plant steps at once.

        Raises:
            InputError: it is not for the present tick, or the plant is paused.
        """
        self.pacer.answered()
        if not self.paused:
            self.deadline = self.pacer.deadline
        if self.paused or tick != self.state.tick:
            now = "the plant is paused" if self.paused else f"now is tick {self.state.tick}"
            raise InputError(f"a command for tick {tick}, but {now}")
        self._command = chi
        if self.pacer.lockstep:
            self._end()

    def expire(self) -> None:
        """The deadline has passed: step with what there is, or publish a paused state again."""
        if self.paused:
            self._begin()
            return
        if self._command is None:
            self.pacer.missed()
        self._end()

    def pause(self) -> None:
        """Stop after the present tick, so that no command is lost."""
        if self._budget is None:
            self._budget = 1

    def resume(self, ticks: int | None = None) -> None:
        """Go on, for so many ticks or without limit.

        Raises:
            InputError: the last tick was reached, or single ticks are asked of a running plant.
        """
        if self.ended:
            raise InputError("the scenario has ended: reset first")
        if ticks is not None and not self.paused:
            raise InputError("the plant is running: pause first")
        was_paused, self._budget = self.paused, ticks
        if was_paused:
            self.start()

    def reset(self) -> None:
        """Put the robots where the scenario starts; paused or running, as before."""
        self.state = self.plant.reset(self.plant.seed)
        self.start()

    def _begin(self) -> None:
        """Publish the state, and set the deadline of its command."""
        now = self._clock()
        if self.paused:
            self.deadline = now + _PAUSED_PERIOD
            self._publish(self.state, Status.PAUSED)
            return
        self.pacer.begin(now)
        self.deadline = self.pacer.deadline
        self._publish(self.state, self.plant.status)

    def _end(self) -> None:
        """Step the plant, and begin the next tick."""
        self.state = self.plant.step(self._command)
        self._command = None
        if self._budget is not None:
            self._budget -= 1
        if self.ended:
            self._budget = 0
        self._begin()
