"""The solver in an operating-system process of its own, asked through a pipe; without ROS."""

from __future__ import annotations

import gc
import multiprocessing
from dataclasses import dataclass, replace
from multiprocessing.connection import Connection
from time import perf_counter, process_time

from lexstack.references import References
from lexstack.transition import Announcement, SourceSample
from lexstack.types import RobotState
from lexstack_config.parts import Parts, build_references, build_stack_solver
from lexstack_config.resolved import ResolvedScenario
from lexstack_experiments.loop import targets_of

_PATIENCE = 60.0  # s of wall time to wait for an answer, the start of the process included


@dataclass(frozen=True, slots=True)
class Effort:
    """What one answer of the solver cost it [s].

    Attributes:
        wall: time of the solve, kinematics included.
        cpu: time of its process since the answer before, the pipe included.
    """

    wall: float
    cpu: float


class RemoteB:
    """The solver in its own process; a context manager that ends it.

    Attributes:
        efforts: of each answer, in their order.
    """

    def __init__(self, resolved: ResolvedScenario, *, behind: bool) -> None:
        """Start the process.

        Args:
            resolved: the scenario.
            behind: do not wait for the answer of the present tick, take that of the tick before:
                The controller and the solver then work at the same time, as they do in realtime.
        """
        context = multiprocessing.get_context("spawn")
        self._pipe, other = context.Pipe()
        text = resolved.to_yaml()
        self._process = context.Process(target=_serve, args=(other, text), daemon=True)
        self._process.start()
        other.close()
        self._behind = behind
        self._waiting = False
        self.efforts: list[Effort] = []
        self._receive()  # it is ready

    def __enter__(self) -> RemoteB:
        """Return itself."""
        return self

    def __exit__(self, *_error: object) -> None:
        """End the process."""
        self._pipe.send(None)
        self._process.join(timeout=5.0)
        if self._process.is_alive():
            self._process.kill()
        self._pipe.close()

    def ask(
        self, wanted: Announcement, state: RobotState, _references: References
    ) -> SourceSample | None:
        """Return the solver's answer for this state, or if so configured for the state before."""
        before = self._answer() if self._waiting else None
        self._pipe.send((wanted, state))
        self._waiting = True
        if self._behind:
            return before
        return self._answer()

    def _answer(self) -> SourceSample:
        """Return the answer that is awaited."""
        sample, effort = self._receive()
        self.efforts.append(effort)
        self._waiting = False
        return sample

    def _receive(self) -> tuple[SourceSample, Effort]:
        """Return the next message; raises TimeoutError where none comes."""
        if not self._pipe.poll(_PATIENCE):
            raise TimeoutError(f"the solver did not answer within {_PATIENCE:g} s")
        return self._pipe.recv()


def _serve(pipe: Connection, text: str) -> None:
    """Answer until None comes; run in the solver's process."""
    resolved = ResolvedScenario.from_yaml(text, "the solver")
    parts = Parts.of(resolved)
    solver, references = build_stack_solver(resolved, parts), build_references(resolved, parts.team)
    for event in resolved.scenario.events:
        for target in targets_of(event, parts.team):
            references.add(target)
    gc.disable()
    pipe.send(None)
    used = process_time()
    while (message := pipe.recv()) is not None:
        wanted, state = message
        begun = perf_counter()
        kinematics = parts.team.kinematics(state)
        sample = solver.answer(wanted, kinematics, references.at(state.stamp))
        wall, cpu = perf_counter() - begun, process_time()
        effort, used = Effort(wall, cpu - used), cpu
        # Its decisions are counted apart from the controller's, so no revision is named.
        pipe.send((replace(sample, revision=None), effort))
