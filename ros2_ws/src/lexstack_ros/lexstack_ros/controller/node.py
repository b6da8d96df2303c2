"""The controller: one command per plant state; switches its stack when asked to."""

from __future__ import annotations

import sys
import time

from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectory

from lexstack.errors import InputError
from lexstack.types import RobotState
from lexstack_config.parts import Parts, build_controller
from lexstack_interfaces.msg import Chi, TransitionStatus
from lexstack_ros.controller.follow_joint_trajectory import FollowJointTrajectory
from lexstack_ros.controller.references import Decisions, load_ahead
from lexstack_ros.controller.switch_services import Requests
from lexstack_ros.controller.target_topics import TargetTopics
from lexstack_ros.intake.drain import waiting
from lexstack_ros.intake.plant_states import PlantStates
from lexstack_ros.messages.cdr import Reader
from lexstack_ros.messages.command_bytes import CommandBytes, TransitionNews
from lexstack_ros.messages.conversions import to_sample
from lexstack_ros.messages.names import relative
from lexstack_ros.messages.plans import PLAN, to_plan
from lexstack_ros.messages.qos import STREAM
from lexstack_ros.node.absence import Absence
from lexstack_ros.node.diagnostics import Diagnostics, Health, Meter, all_of
from lexstack_ros.node.options import FROM_COMMAND_LINE, NodeOptions
from lexstack_ros.node.parameters import scenario_parameter, tell_scenario
from lexstack_ros.node.peer_watch import PeerWatch
from lexstack_ros.node.sole_sender import AlreadyCommandedError, sender_name
from lexstack_ros.node.spin import run_node

_SOURCE = "/robot_b/chi"
_OF_SOURCE = ("tick", "robots", "stack", "transition_id", "references", "chi", "slacks", "status")
_LATE_START = 1.0  # s of simulated time: whoever comes later has been there before, or should have
_EARLY = 1e-4  # s, by which a timer may come too early


class HqpControllerNode(Node):
    """Topics and services around the library's Controller; no mathematics here."""

    def __init__(self, options: NodeOptions = FROM_COMMAND_LINE) -> None:
        """Build the controller of the scenario; raises LexstackError for a wrong parameter."""
        super().__init__(**options.arguments("hqp_controller"))
        self._resolved = scenario_parameter(self)
        self._parts = Parts.of(self._resolved)
        self._controller = build_controller(self._resolved, self._parts)
        timeouts = self._resolved.scenario.timeouts
        self._patience = timeouts.source_wall
        self._absence = Absence(round(timeouts.watchdog * self._resolved.scenario.rate))
        self._state: RobotState | None = None  # the one that still waits for its command
        self._served = -1
        self._deadline = 0.0
        self._fallbacks = 0
        self._braked = ""  # why, where no solution could be sent since the last report
        self._damped = 0  # ticks near a singularity
        self._near = ""  # the last of them since the last report
        self._meter = Meter()
        self._late = 0  # ticks that waited in vain for the solver
        self.failure: AlreadyCommandedError | None = None  # ends the process
        self._sender = sender_name(self)
        self._chi_of = CommandBytes(self._parts.team.names, self._sender)
        self._news = TransitionNews()
        self._chi_out = self.create_publisher(Chi, "robot_a/chi", STREAM)
        self._status_out = self.create_publisher(TransitionStatus, "robot_a/transition", STREAM)
        self._targets = TargetTopics(
            self,
            self._parts.team,
            self._controller.references,
            self._resolved.scenario.references,
            self._resolved.stacks.values(),
        )
        self._joint_goals = FollowJointTrajectory(self, self._parts.team, self._targets)
        self._decisions = Decisions(
            self, self._parts.team, self._controller.references, self._sender
        )
        load_ahead(self._resolved.scenario.mode)
        self._late_start = round(_LATE_START * self._resolved.scenario.rate)
        self._read = Reader(Chi, _SOURCE, _OF_SOURCE)
        self._source = self.create_subscription(
            Chi, relative(_SOURCE), self._on_source, STREAM, raw=True
        )
        self._read_plan = Reader(JointTrajectory, PLAN)
        self.create_subscription(JointTrajectory, relative(PLAN), self._on_plan, STREAM, raw=True)
        self._scenario_out = tell_scenario(self, self._resolved)
        self._requests = Requests(
            self,
            self._controller.transition,
            self._resolved,
            self._parts.team,
            on_stack=self._targets.add_frames,
        )
        wall = Clock(clock_type=ClockType.STEADY_TIME)
        self._timer = self.create_timer(self._patience, self._on_timer, clock=wall)
        self._peer_watch = PeerWatch(self)
        Diagnostics(self, self._health)
        self._states = PlantStates(
            self,
            self._parts.team,
            self._on_state,
            self._restart,
            self._on_commander,
            newest=int(self._resolved.scenario.mode == "realtime"),
        )

    # ---- the tick

    def _on_state(self, state: RobotState) -> None:
        """Serve a new state, or keep it until the source's chi is there."""
        self._targets.see(state)
        away = self._absence.arrive(state.tick)
        if away:
            self._controller.transition.note(away)
        if not self._decisions.known(state, self._late_start):
            return
        # A tick's references are decided when its state comes, if not before: what comes while the
        # controller waits for the source would reach the two at different ticks.
        self._controller.prepare(state)
        if self._decisions.missing:
            self._controller.transition.note(self._decisions.missing)
            self._decisions.missing = ""
        self._decisions.tell()
        self._joint_goals.see(state)
        self._state = state
        self._deadline = time.monotonic() + self._patience
        self._serve(wait=True)

    def _on_commander(self, name: str, follows: bool) -> bool:
        """Return whether the plant takes this process's commands; end if it has another's."""
        if name != self._sender and follows:
            self.failure = AlreadyCommandedError(f"the robots are commanded already, by {name}")
        return name == self._sender

    def _on_source(self, data: bytes) -> None:
        """Take the solver's chi, and what waits behind it, one by one: the first may be due."""
        for chi in (data, *(other for other, _ in waiting(self._source))):
            try:
                sample = to_sample(self._read(chi), self._parts.team, _SOURCE)
                self._controller.transition.hear(sample)
            except InputError as error:
                self._states.refuse(error)
                continue
            self._serve(wait=True)

    def _on_plan(self, data: bytes) -> None:
        """Take a plan of the HTMPC."""
        try:
            plan = to_plan(self._read_plan(data), self._parts.team, self._resolved.scenario.rate)
        except InputError as error:
            self._states.refuse(error)
            return
        self._controller.transition.hear_plan(plan)
        self._serve(wait=True)

    def _on_timer(self) -> None:
        """Serve a state whose source did not answer in time: it counts as lost.

        The deadline moves with every state that waits, the timer only when it is there: it comes
        once in the time of a deadline, not once a tick.
        """
        left = self._deadline - time.monotonic()
        if self._state is None:
            self._timer.cancel()  # until a state waits again
        elif left > _EARLY:
            self._let_come(left)
        else:
            self._late += 1
            self._serve(wait=False)

    def _let_come(self, seconds: float) -> None:
        """Let the timer come in so many seconds."""
        self._timer.timer_period_ns = round(1e9 * seconds)
        self._timer.reset()

    def _serve(self, *, wait: bool) -> None:
        """Send the command for the state at hand, unless it must wait for the source."""
        state = self._state
        if state is None:
            return
        if wait and self._controller.awaits(state):
            if self._timer.is_canceled():
                self._let_come(self._patience)
            return
        self._state = None
        command = self._controller.tick(state)
        self._controller.references.decide(state.stamp + self._parts.dt)
        self._decisions.tell()
        # Before the command, which lets the plant go on: others shall know at the next state.
        self._requests.announce(state.stamp)
        for status in self._news.of(command):
            self._status_out.publish(status)
        self._chi_out.publish(self._chi_of(command))
        self._absence.see(command.transitions)
        self._served = state.tick
        self._meter.add(command.solve_time)
        near = command.near_singularity
        if near:
            self._damped += any(level.rows for level in command.near)
            self._near = near
            self.get_logger().warning(near, throttle_duration_sec=10.0)
        if command.fallback:
            self._fallbacks += 1
            self._braked = command.fallback if command.brakes else self._braked
            self.get_logger().warning(command.fallback, throttle_duration_sec=1.0)

    # ---- the rest

    def _restart(self) -> None:
        """Begin anew after a reset of the plant."""
        self._controller = build_controller(self._resolved, self._parts)
        self._targets.schedule = self._controller.references
        self._joint_goals.restart()
        self._decisions.restart(self._controller.references)
        self._requests.restart(self._controller.transition)
        self._absence.begin_anew()

    def _complaints(self) -> tuple[str, ...]:
        """Return what the node's parts complain of."""
        return self._absence.report(), self._peer_watch.report(), self._targets.report()

    def _health(self) -> Health:
        """Return how the node is."""
        refused = self._states.refused + self._targets.refused
        complaint, ages = self._states.report()
        failed = f"{self._fallbacks} ticks failed" if self._fallbacks else ""
        near, self._near = self._near, ""
        braked, self._braked = self._braked, ""
        return Health(
            all_of(*self._complaints(), complaint, failed, near),
            {
                **self._meter.report(),
                **ages,
                "tick": str(self._served),
                "ticks without the solver in time": str(self._late),
                "fallbacks": str(self._fallbacks),
                "ticks damped near a singularity": str(self._damped),
                "levels held back by bounds": self._controller.obstructed(),
                "skipped states": str(self._states.skipped),
                "refused messages": str(refused),
            },
            error=braked,
            stale=self._states.delays.silent,
        )


def main() -> int:
    """Run the controller's controller; returns the exit code."""
    return run_node(HqpControllerNode)


if __name__ == "__main__":
    sys.exit(main())
