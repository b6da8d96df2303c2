"""A controller, a stack solver, plans of the MPC and a plant in one process, tick by tick.

This is the order in which the processes serve a tick in lockstep, and the only place in which it is
written for one process: experiments, replays, tests and programs of users go through it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Protocol

import numpy as np

from lexstack.control.controller import Command, Controller
from lexstack.control.stack_solver import StackSolver
from lexstack.references import References
from lexstack.robots import Kinematics, Team
from lexstack.transition.messages import Announcement, SourceSample, SourceSchedule
from lexstack.transition.sources.mpc_plans import HeardPlan
from lexstack.types import RobotState, Vector

AskSolver = Callable[[Announcement, RobotState, References], SourceSample | None]
"""The solver's answer for a tick, or an earlier one, or none."""

Link = Callable[[SourceSample], SourceSample | None]
"""What the controller hears of an answer: the message, another one, or nothing."""

Plans = Callable[[RobotState], Iterable[HeardPlan]]
"""The plans of the MPC that arrive before a tick."""


class Plant(Protocol):
    """What a run needs of a plant."""

    def state(self) -> RobotState:
        """Return the present state; the same one until the next ``step``."""
        ...

    def step(self, chi: Vector | None) -> RobotState:
        """Advance by one tick under a command (n,), or without one, and return the new state."""
        ...


class ExactPlant:
    """Robots that follow their command exactly and at once: q(k+1) = q(k) + dt chi, or an arc."""

    def __init__(self, q: Vector, dt: float, team: Team | None = None) -> None:
        """Start at rest at q, shape (nq,), m and rad.

        Args:
            q: the configuration.
            dt: control period [s].
            team: the robots, where chi is not the derivative of q.
        """
        self._team = team
        self._dt = dt
        self._tick = 0
        self._q = q
        self._chi: Vector = np.zeros(q.size if team is None else team.n)

    def put(self, q: Vector, chi: Vector) -> None:
        """Put the robots at q (nq,), moving at chi (n,)."""
        self._q, self._chi = q.copy(), chi.copy()

    def state(self) -> RobotState:
        """Return the present state: q* is q."""
        return RobotState(self._tick, self._tick * self._dt, self._q, self._chi, self._q, self._chi)

    def step(self, chi: Vector | None) -> RobotState:
        """Advance by one tick; without a command the last one goes on."""
        if chi is not None:
            self._chi = chi.copy()
        if self._team is None:
            self._q = self._q + self._dt * self._chi
        else:
            self._q = self._team.integrate(self._q, self._chi, self._dt)
        self._tick += 1
        return self.state()


class Lockstep:
    """Serves tick after tick: every message of a tick is there before the tick is served.

    The attributes that are functions may be replaced: to lose messages, to delay or to change them.

    Attributes:
        controller: one command per state; its ``transition`` takes requests to switch.
        solver: solves the stack to come.
        plant: the robots.
        schedule: what the controller has announced to the solver.
        solver_references: by which the solver goes; the controller's own decisions.
        plans: what arrives of the MPC before a tick; default: nothing.
        solver_answers: whether the solver answers at a tick; default: always.
        ask_solver: how it is asked; default: by a call.
        link: what the controller hears of an answer; default: the answer.
    """

    def __init__(
        self, team: Team, controller: Controller, solver: StackSolver, plant: Plant
    ) -> None:
        """Put the parts together; see ``make_controller`` and ``make_stack_solver``."""
        self.controller = controller
        self.solver = solver
        self.plant = plant
        self.schedule = SourceSchedule()
        self.solver_references = controller.references
        self.plans: Plans = lambda _state: ()
        self.solver_answers: Callable[[int], bool] = lambda _tick: True
        self.ask_solver: AskSolver = self.answer
        self.link: Link = lambda sample: sample
        self._team = team
        self._kinematics: Kinematics | None = None

    def step(self) -> Command:
        """Serve one tick: plans, the solver's answers, the command, the plant's step."""
        state = self.plant.state()
        transition = self.controller.transition
        for plan in self.plans(state):
            transition.hear_plan(plan)
        for announcement in transition.take_announcements():
            self.schedule.hear(announcement)
        # References first: the solver goes by what the controller decides for this very tick.
        self.controller.prepare(state)
        references = self.solver_references.at(state.stamp)
        for sample in self.answers(state, references):
            transition.hear(sample)
        command = self.controller.tick(state)
        self.served(state, references, command)
        self.plant.step(command.chi)
        return command

    def served(self, state: RobotState, references: References, command: Command) -> None:
        """Be told of a tick before the plant's step; for those who keep records."""

    def answers(self, state: RobotState, references: References) -> Iterable[SourceSample]:
        """Return what the controller hears of the solver before a tick is served."""
        wanted = self.schedule.current(state.tick)
        if wanted and self.solver_answers(state.tick):
            for announcement in wanted:
                sample = self.ask_solver(announcement, state, references)
                heard = None if sample is None else self.link(sample)
                if heard is not None:
                    yield heard

    def answer(
        self, wanted: Announcement, state: RobotState, references: References
    ) -> SourceSample | None:
        """Return the solver's answer for a state; None for a stack that follows a plan."""
        if not self.solver.solves(wanted.stack):
            return None
        return self.solver.answer(wanted, self.kinematics(state), references)

    def kinematics(self, state: RobotState) -> Kinematics:
        """Return the kinematics of a state, worked out once for all stacks of a tick."""
        if self._kinematics is None or self._kinematics.state is not state:
            self._kinematics = self._team.kinematics(state)
        return self._kinematics
