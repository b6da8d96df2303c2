"""The HTMPC node: executes sequences of tasks; the controller follows its plans."""

from __future__ import annotations

import sys
from dataclasses import replace

from rclpy.action import CancelResponse, GoalResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectory

from lexstack.errors import InputError
from lexstack.mpc import ARCHITECTURES, Change, Reach, SequenceRunner, plans_of
from lexstack.tasks import plan_stack
from lexstack.transition import MAX_SCHEDULED, too_far
from lexstack.types import RobotState
from lexstack_config.parts import build_team
from lexstack_interfaces.action import ExecuteSequence
from lexstack_interfaces.msg import Sequence, SequenceStatus
from lexstack_ros.intake.plant_states import PlantStates
from lexstack_ros.messages.names import relative
from lexstack_ros.messages.plan_bytes import PlanBytes
from lexstack_ros.messages.plans import (
    PLAN,
    joint_names,
    sequence_message,
    status_message,
    to_points,
)
from lexstack_ros.messages.qos import LATCHED, STREAM
from lexstack_ros.node.diagnostics import Diagnostics, Health, Meter, first
from lexstack_ros.node.goal_server import GoalServer
from lexstack_ros.node.options import FROM_COMMAND_LINE, NodeOptions
from lexstack_ros.node.parameters import scenario_parameter
from lexstack_ros.node.spin import beside, run_node
from lexstack_ros.planner.follow_client import FollowClient
from lexstack_ros.planner.goals import Job, Stage, base_at, wanted_of
from lexstack_ros.planner.sequence_changes import SequenceChanges, Wish

ACTION = "/htmpc/execute_sequence"
_SHARE = 0.7  # of the time between two plans, which a solve may take in realtime
_THROTTLE = 0.05  # s: a flood of goals is no flood of lines


class HtmpcNode(Node):
    """Action, topics and service around the library's SequenceRunner; no mathematics here."""

    def __init__(self, options: NodeOptions = FROM_COMMAND_LINE) -> None:
        """Build optimisers for the robots that sequences name, or for all; raises LexstackError."""
        super().__init__(**options.arguments("htmpc"))
        self._resolved = scenario_parameter(self)
        scenario = self._resolved.scenario
        self._team = build_team(self._resolved)
        self._horizon = scenario.horizon_ticks
        self._every = scenario.htmpc.ticks(scenario.rate)
        self._lockstep = scenario.mode == "lockstep"
        self.niceness = beside(scenario.mode)
        self._jobs: dict[int, Job] = {}  # by robot
        self._by_goal: dict[bytes, Job] = {}
        self._waits: RobotState | None = None  # a state that a plan is due for
        self._later: list[Wish] = []
        self._meter = Meter()
        self._failures = 0
        self._failed = 0  # of them those since the last report
        self._runners: dict[int, SequenceRunner] = {}
        self._reach = [Reach(robot, self._team.obstacles) for robot in self._team.robots]
        named = {entry.robot for entry in scenario.sequences.values()}
        for robot in sorted(map(self._team.index, named or scenario.robots)):
            self._runner(robot)
        self._bytes_of = PlanBytes()
        self._plan_out = self.create_publisher(JointTrajectory, relative(PLAN), STREAM)
        self._status_out = self.create_publisher(SequenceStatus, "htmpc/status", STREAM)
        self._sequence_out = self.create_publisher(Sequence, "htmpc/sequence", LATCHED)
        self._follow_client = FollowClient(self, self._team, self._resolved, self._on_answer)
        self._action = GoalServer(
            self,
            ExecuteSequence,
            relative(ACTION),
            execute_callback=self._execute,
            goal_callback=self._on_request,
            handle_accepted_callback=self._on_goal,
            cancel_callback=lambda _goal: CancelResponse.ACCEPT,
        )
        SequenceChanges(self, self._team, self._change)
        Diagnostics(self, self._health)
        self._states = PlantStates(
            self,
            self._team,
            self._on_state,
            self._restart,
            newest=self._every,
            wanted=lambda tick: tick % self._every == 0,
        )

    @property
    def _state(self) -> RobotState | None:
        """The newest state of the plant."""
        return self._states.newest_state

    # ---- goals

    def _on_request(self, goal: ExecuteSequence.Goal) -> GoalResponse:
        """Accept a goal that can be met; log and diagnostics say why another is refused."""
        try:
            wanted = wanted_of(goal, self._team, self._state, self._every, self._horizon)
            self._follow_client.check(goal.robot)
            base = base_at(self._state, self._team, wanted.robot)
            self._reach[wanted.robot].check(wanted.tasks, wanted.architecture, base)
        except InputError as error:
            # The action's answer has no room for the reason.
            self._states.note_rejection(InputError(f"{ACTION}: {error}"))
            log = self.get_logger()
            log.warning(f"refused: {ACTION}: {error}", throttle_duration_sec=_THROTTLE)
            return GoalResponse.REJECT
        self._wanted = wanted  # rclpy calls _on_goal next, before anything else
        return GoalResponse.ACCEPT

    def _on_goal(self, handle: ServerGoalHandle) -> None:
        """Begin with a goal that was accepted."""
        job = Job(handle, self._wanted)
        job.on_end = self._action.finish
        self._by_goal[bytes(handle.goal_id.uuid)] = job
        handle.execute()
        before = self._jobs.get(job.robot)
        if before is not None:
            before.end("pre-empted by another sequence")
            job.origin = before.origin
        self._runner(job.robot)
        self._jobs[job.robot] = job
        self._follow_client.begin(job)

    def _execute(self, handle: ServerGoalHandle) -> ExecuteSequence.Result | None:
        """Return the result of a goal that has ended."""
        return self._by_goal.pop(bytes(handle.goal_id.uuid)).result

    def _on_answer(self, job: Job, back: bool, rejection: str) -> None:
        """Go on as the controller has answered."""
        if rejection:
            self.get_logger().warning(
                f"the controller refused: {rejection}", throttle_duration_sec=1.0
            )
            job.end(f"the controller refused: {rejection}")
            if not back and self._jobs.get(job.robot) is job:
                self._drop(job)
        elif job.stage is Stage.ASKED:
            job.stage = Stage.WAITING
        self._serve()

    def _change(self, wish: Wish) -> str:
        """Change a sequence under way, now or later; returns what was done, raises InputError."""
        change, state = wish.change, self._state
        if wish.at_tick:
            rejection = too_far(wish.at_tick, -1 if state is None else state.tick, self._horizon)
            if rejection or len(self._later) >= MAX_SCHEDULED:
                raise InputError(rejection or f"{MAX_SCHEDULED} changes are to come already")
            self._later.append(wish)
            return f"{change.kind}: {change.name} at tick {wish.at_tick}"
        running = [robot for robot, job in self._jobs.items() if job.stage is Stage.RUNNING]
        robot = running[0] if wish.robot is None and len(running) == 1 else wish.robot
        if robot is None or robot not in running or state is None:
            raise InputError("no sequence is under way for this robot")
        runner = self._runners[robot]
        if change.kind == "retarget":
            points = to_points(wish.task, runner.task(change.name).kind, f"task {change.name!r}")
            change = replace(change, points=points)
        self._check_change(robot, change)
        runner.change(change, state)
        self._announce(robot, change.kind, change.name)
        return f"{change.kind}: {change.name}"

    def _check_change(self, robot: int, change: Change) -> None:
        """Raise InputError for a change after which a task could not be met."""
        task = self._runners[robot].task_after(change)
        if task is not None:
            # Where the base will stand then is not known: the whole robot may serve the task.
            self._reach[robot].check([task], "ht")

    def _change_due(self, tick: int) -> None:
        """Make the changes whose tick has come."""
        due = [wish for wish in self._later if wish.at_tick <= tick]
        self._later = [wish for wish in self._later if wish.at_tick > tick]
        for wish in due:
            try:
                self._change(replace(wish, at_tick=0))
            except InputError as error:
                self._states.refuse(error)

    # ---- the tick

    def _on_state(self, state: RobotState) -> None:
        """Plan from a new state for which a plan is due."""
        self._waits = state
        self._serve()

    def _serve(self) -> None:
        """Plan for every robot with a sequence, unless an answer is awaited that decides."""
        state = self._waits
        if state is None or (self._lockstep and self._follow_client.pending):
            return
        self._waits = None
        self._change_due(state.tick)
        for job in list(self._jobs.values()):
            if job.stage is not Stage.ASKED and state.tick >= job.begin:
                self._plan(job, state)

    def _plan(self, job: Job, state: RobotState) -> None:
        """Send the plan of one robot."""
        runner, name = self._runners[job.robot], self._team.names[job.robot]
        if self._left(job):
            return
        if job.stage is Stage.WAITING:
            event = "begin" if runner.sequence is None else "replace"
            runner.begin(job.tasks, ARCHITECTURES[job.architecture], state)
            job.stage = Stage.RUNNING
            self._announce(job.robot, event)
        progress = runner.step(state, plans_of(self._runners))
        self._plan_out.publish(self._bytes_of(progress.plan, joint_names(self._team, job.robot)))
        status = status_message(progress, state, name, job.architecture)
        self._status_out.publish(status)
        job.tell(status)
        self._meter.add(progress.plan.solve_time)
        self._failures += not progress.plan.solved
        self._failed += not progress.plan.solved
        if job.stage is Stage.RUNNING and (job.cancelled or progress.sequence.done):
            job.end("" if progress.sequence.done else "cancelled")
            job.stage = Stage.LEAVING
            self._follow_client.go_back(job, state.tick, self._every)

    def _left(self, job: Job) -> bool:
        """Return whether the controller does not follow any more, and then forget the job."""
        stack = self._follow_client.stack(job.robot)
        if stack == plan_stack(self._team.names[job.robot]):
            job.followed = True
            return False
        if not job.followed:
            return False
        job.end(f"the controller went to {stack!r}")
        self._drop(job)
        return True

    def _drop(self, job: Job) -> None:
        """Forget a job."""
        del self._jobs[job.robot]
        self._runners[job.robot].end()
        self._announce(job.robot, "end")

    def _announce(self, robot: int, event: str, changed: str = "") -> None:
        """Send a robot's sequence as it is after an event."""
        runner, job = self._runners[robot], self._jobs.get(robot)
        if self._state is not None:
            which = self._team.names[robot], "" if job is None else job.architecture
            message = sequence_message(runner.sequence, self._state, which, event, changed)
            self._sequence_out.publish(message)

    def _runner(self, robot: int) -> SequenceRunner:
        """Return a robot's optimiser, made when first needed."""
        if robot not in self._runners:
            scenario = self._resolved.scenario
            config, blend = self._resolved.htmpc[scenario.htmpc.parameters], scenario.transition
            if not self._lockstep and not config.deadline:
                # All robots plan at the same tick, one after the other.
                deadline = _SHARE * self._every / scenario.rate / len(scenario.robots)
                config = replace(config, deadline=deadline)
            self._runners[robot] = SequenceRunner(self._team, robot, config, blend.duration)
        return self._runners[robot]

    # ---- the rest

    def _restart(self) -> None:
        """Begin anew after a reset of the plant."""
        for job in list(self._jobs.values()):
            job.end("the plant was reset")
            self._drop(job)
        self._waits = None

    def close(self) -> None:
        """Tell the clients before the node ends."""
        for job in self._jobs.values():
            job.end("the node ends")

    def _health(self) -> Health:
        """Return how the node is."""
        complaint, ages = self._states.report()
        failed, self._failed = self._failed, 0
        return Health(
            first(complaint, f"{self._failures} solves failed" if self._failures else ""),
            {
                **self._meter.report(),
                **ages,
                "sequences": str(len(self._jobs)),
                "failures": str(self._failures),
                "skipped states": str(self._states.skipped),
                "refused messages": str(self._states.refused),
            },
            error=f"{failed} plans were not solved" if failed else "",
            stale=self._states.delays.silent,
        )


def main() -> int:
    """Run the HTMPC; returns the exit code."""
    return run_node(HtmpcNode)


if __name__ == "__main__":
    sys.exit(main())
