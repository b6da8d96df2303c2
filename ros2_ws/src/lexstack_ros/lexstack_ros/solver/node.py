"""The solver: solves the stack that the controller asks for, for the same plant states."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from time import perf_counter

import numpy as np
from rclpy.node import Node

from lexstack.control import share
from lexstack.errors import ConfigurationError, InputError
from lexstack.hqp import near_singularity
from lexstack.options import shown
from lexstack.robots import Kinematics
from lexstack.tasks import Stack
from lexstack.transition import Announcement, SourceSchedule
from lexstack.types import RobotState
from lexstack_bag.topics import REQUEST
from lexstack_config.parts import Parts, build_stack_solver
from lexstack_config.sent_stacks import fit_stack, read_stack
from lexstack_interfaces.msg import Chi, References, StackRequest
from lexstack_ros.controller.references import KEPT, HeardReferences, load_ahead
from lexstack_ros.intake.plant_states import PlantStates
from lexstack_ros.messages.conversions import to_announcement, to_seconds
from lexstack_ros.messages.names import relative
from lexstack_ros.messages.qos import LATCHED, LATEST, STREAM
from lexstack_ros.messages.solution_bytes import SolutionBytes
from lexstack_ros.node.diagnostics import Diagnostics, Health, Meter, first
from lexstack_ros.node.options import FROM_COMMAND_LINE, NodeOptions
from lexstack_ros.node.parameters import count_parameter, scenario_parameter
from lexstack_ros.node.sole_sender import sender_name
from lexstack_ros.node.spin import run_node


class StackSolverNode(Node):
    """Topics around the library's StackSolver; no mathematics here."""

    def __init__(self, options: NodeOptions = FROM_COMMAND_LINE) -> None:
        """Build the solver of the scenario; raises LexstackError for a wrong parameter."""
        super().__init__(**options.arguments("stack_solver"))
        self._resolved = scenario_parameter(self)
        self._parts = Parts.of(self._resolved)
        self._solver = build_stack_solver(self._resolved, self._parts)
        solvers = self._resolved.scenario.solvers
        number = count_parameter(self, "number", "which of the scenario's solvers it is", solvers)
        self._number = number
        self._stacks: dict[str, Stack] = {}  # those that can be asked for
        self._mine: dict[str, Stack | None] = {}  # what this solver solves of each
        self._texts: dict[str, str] = {}  # of those that users sent
        self._know_the_configured()
        self._schedule = SourceSchedule()
        self._served: tuple[int, set[int]] = (-1, set())  # the last tick, and its transitions' ids
        self._failures = 0
        self._failed = ""  # why a stack was not solved since the last report
        self._meter = Meter()
        self._bytes_of = SolutionBytes(sender_name(self))
        self._chi_out = self.create_publisher(Chi, "robot_b/chi", STREAM)
        team = self._parts.team
        self._references = HeardReferences(self, team, on_news=self._on_references)
        load_ahead(self._resolved.scenario.mode)
        self._kept = (
            self.create_publisher(References, relative(KEPT), LATEST) if number == 1 else None
        )
        self.create_subscription(StackRequest, relative(REQUEST), self._on_request, LATCHED)
        Diagnostics(self, self._health)
        newest = int(self._resolved.scenario.mode == "realtime")
        self._states = PlantStates(
            self,
            team,
            self._serve,
            self._restart,
            self._on_commander,
            newest=newest,
            wanted=lambda _tick: self._schedule.is_busy,
        )

    def _on_commander(self, name: str, _follows: bool) -> bool:
        """Believe the references of whom the plant takes commands from; serve in any case."""
        self._references.believed = name
        return True

    def _on_references(self, message: References) -> None:
        """Keep the controller's decision for it; solve again what changes of the present tick."""
        if self._kept is not None:
            self._kept.publish(message)
        state = self._states.newest_state if self._schedule.is_busy else None
        if state is not None and to_seconds(message.header.stamp) <= state.stamp:
            self._served = (state.tick, set())
            self._serve(state)

    def _on_request(self, message: StackRequest) -> None:
        """Take the controller's wish, and serve it for the present state if that is due."""
        try:
            self._learn(message.stack, message.stack_yaml)
            wanted = to_announcement(message, self._stacks, self._parts.team)
        except InputError as error:
            self._states.refuse(error)
            return
        if self._stacks[wanted.stack].planned or self._mine[wanted.stack] is None:
            return  # the HTMPC's, or another solver's
        self._schedule.hear(wanted)
        self._serve(self._states.newest_state)

    def _learn(self, name: str, text: str) -> None:
        """Know a stack that a user sent to the controller; raises InputError."""
        if not text or name in self._parts.stacks or self._texts.get(name) == text:
            return
        try:
            config = read_stack(text)
            if config.name != name:
                raise InputError(f"{REQUEST}: stack: {shown(name)} is not that of stack_yaml")
            self._know(fit_stack(config, self._parts.team))
        except ConfigurationError as error:
            raise InputError(f"{REQUEST}: {error}") from error
        self._texts[name] = text

    def _know(self, stack: Stack) -> None:
        """Let a stack be asked for."""
        robots, solvers = len(self._parts.team.robots), self._resolved.scenario.solvers
        self._stacks[stack.name] = stack
        self._mine[stack.name] = share(stack, robots, self._number, solvers)

    def _know_the_configured(self) -> None:
        """Let the scenario's stacks be asked for, and none that users sent."""
        self._stacks, self._mine, self._texts = {}, {}, {}
        for stack in self._parts.stacks.values():
            self._know(stack)

    def _serve(self, state: RobotState | None) -> None:
        """Send the optimum of each stack that is asked for, once per state and request.

        Not before the references are known: towards others the robots would move.
        """
        if state is None or not self._references.timeline.covers(state.stamp):
            return
        if self._served[0] != state.tick:
            self._served = (state.tick, set())
        due = [w for w in self._schedule.current(state.tick) if w.id not in self._served[1]]
        if not due:
            return
        begun = perf_counter()
        kinematics = self._parts.team.kinematics(state)
        for wanted in due:
            self._served[1].add(wanted.id)
            self._send(wanted, state, kinematics, begun)
            begun = perf_counter()

    def _send(
        self, wanted: Announcement, state: RobotState, kinematics: Kinematics, begun: float
    ) -> None:
        """Solve one stack for a state, and send its optimum; ``begun``: when its work began [s]."""
        references = self._references.timeline.at(state.stamp)
        stack, team = self._mine[wanted.stack], self._parts.team
        assert stack is not None
        solution = self._solver.solve(stack, kinematics, references)
        bounds = self._solver.bounds(stack, kinematics)
        solve_time = perf_counter() - begun
        names: Sequence[str] = team.names
        vectors = {"chi": solution.chi, "lower": bounds.lower, "upper": bounds.upper}
        if self._resolved.scenario.solvers > 1:
            robots = range(len(team.robots)) if stack.robots is None else stack.robots
            names = [team.names[robot] for robot in robots]
            vectors = {name: each[team.columns(robots)] for name, each in vectors.items()}
        usable = solution.solved and bool(np.isfinite(solution.chi).all())
        reason = solution.reason or solution.undamped or near_singularity(solution.near)
        self._meter.add(solve_time)
        self._chi_out.publish(
            self._bytes_of(
                state.stamp,
                names,
                {"stack": wanted.stack, "reason": reason},
                {**vectors, "slacks": solution.slacks},
                {
                    "tick": state.tick,
                    "transition_id": wanted.id,
                    "references": references.revision,
                    "status": Chi.SOLVED if usable else Chi.FAILED,
                    "empty_bounds": bounds.empty,
                    "solve_time": solve_time,
                },
            )
        )
        if not usable:
            self._failures += 1
            self._failed = f"not solved: {wanted.stack}: {reason or 'chi is not finite'}"
            self.get_logger().warning(solution.reason, throttle_duration_sec=1.0)

    def _restart(self) -> None:
        """Begin anew after a reset of the plant."""
        self._solver = build_stack_solver(self._resolved, self._parts)
        self._know_the_configured()
        self._schedule = SourceSchedule()
        self._served = (-1, set())

    def _health(self) -> Health:
        """Return how the node is."""
        complaint, ages = self._states.report()
        failed, self._failed = self._failed, ""
        return Health(
            first(complaint, f"{self._failures} ticks failed" if self._failures else ""),
            {
                **self._meter.report(),
                **ages,
                "tick": str(self._served[0]),
                "failures": str(self._failures),
                "skipped states": str(self._states.skipped),
                "refused messages": str(self._states.refused + self._references.refused),
            },
            error=failed,
            stale=self._states.delays.silent,
        )


def main() -> int:
    """Run the solver's solver; returns the exit code."""
    return run_node(StackSolverNode)


if __name__ == "__main__":
    sys.exit(main())
