"""Lockstep with a bag in place of plant, users, HTMPC and, without changes, the solver."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from dataclasses import replace

from lexstack.control import Command, Lockstep
from lexstack.references import References
from lexstack.transition import SourceSample
from lexstack.types import RobotState, Vector
from lexstack_bag.figures.series import COMMANDER
from lexstack_bag.replay.changes import Question
from lexstack_bag.replay.decisions import Decisions
from lexstack_bag.replay.planner import heard_plans
from lexstack_bag.replay.requests import Cancel, requests_of
from lexstack_bag.replay.source import heard_samples
from lexstack_bag.replay.states import EVER, States, begun_at
from lexstack_config.parts import Parts, build_controller, build_stack_solver


class RecordedPlant:
    """The states of a bag, one after another, whatever the commands are."""

    def __init__(self, states: States, ticks: list[int], *, recorded: bool) -> None:
        """Begin with the first of ``ticks``.

        ``recorded``: the command in force is the recorded one, else that of the step before.
        """
        self._states = states
        self._ticks = deque(ticks)
        self._recorded = recorded
        self._sent: Vector | None = None

    def state(self) -> RobotState:
        """Return the present state; after the last step the last one."""
        state = self._states[self._ticks[0]]
        if self._recorded or self._sent is None:
            return state
        return replace(state, command=self._sent)

    def step(self, chi: Vector | None) -> RobotState:
        """Go to the next state, if there is one."""
        self._sent = chi
        if len(self._ticks) > 1:
            self._ticks.popleft()
        return self.state()


class ReplayLoop(Lockstep):
    """Robot A, served with what it knew when it began each tick.

    Attributes:
        ticks: from the first to the last command, those whose state is in the bag.
    """

    def __init__(self, question: Question, parts: Parts) -> None:
        """Build both; with changes the solver solves again, else its answers are known."""
        run, resolved, changes = question.run, question.resolved, question.changes
        chi, states, team = run.chi[COMMANDER], States(run), parts.team
        self.ticks = states.between(int(chi.tick[0]), int(chi.tick[-1])) if len(chi.tick) else []
        controller, solver = build_controller(resolved, parts), build_stack_solver(resolved, parts)
        plant = RecordedPlant(states, self.ticks, recorded=not changes)
        super().__init__(team, controller, solver, plant)
        self._begun = dict(zip(chi.tick.tolist(), begun_at(chi).tolist(), strict=True))
        self._decisions = Decisions(question, team, controller.references)
        self._requests = deque(requests_of(run, changes, resolved))
        self._samples = None if changes else heard_samples(run, team)
        plans = heard_plans(run, team)
        self.plans = lambda state: plans.until(self._now(state))

    def step(self) -> Command:
        """Serve one tick, after what users asked and decided before it."""
        state, transition = self.plant.state(), self.controller.transition
        while self._requests and self._requests[0].after < state.tick:
            request = self._requests.popleft()
            if isinstance(request, Cancel):
                transition.cancel()
            else:
                how = request.duration, request.method, request.at_tick, request.robots
                transition.ask(request.stack, *how)
        self._decisions.take(state, self._now(state))
        return super().step()

    def answers(self, state: RobotState, references: References) -> Iterable[SourceSample]:
        """Return what the solver had sent before this tick began, or what it solves now."""
        if self._samples is None:
            return super().answers(state, references)
        return self._samples.until(self._now(state))

    def _now(self, state: RobotState) -> int:
        """Return when the controller began to serve a state [ns since 1970]."""
        return self._begun.get(state.tick, EVER)
