"""The MPC of the library, fed with the recorded states, sequences and changes: the same plans?

Open loop, as for the other nodes: every plan begins at its recorded state, also with changes. What
a solve takes from the one before it, or from the plan of another robot, is the replayed one: plans
are replayed in the order in which they were sent.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from lexstack.errors import InputError
from lexstack.mpc import ARCHITECTURES, Change, SequenceRunner, SequenceTask, plans_of
from lexstack.robots import Team
from lexstack.transition import HeardPlan
from lexstack.types import Matrix, RobotState, Vector
from lexstack_bag.errors import BagError
from lexstack_bag.replay.changes import Question
from lexstack_bag.replay.outcome import Joint, Outcome, joints_of
from lexstack_bag.replay.states import Arrivals, States
from lexstack_bag.run.run import PlanStream, PlanTopics, Run, SequenceEvent
from lexstack_config.parts import build_team

PLANNER = "htmpc"


def heard_plans(run: Run, team: Team) -> Arrivals[HeardPlan]:
    """Return the recorded plans as the controller took them, by the time of their sending."""
    return Arrivals(
        [
            (int(plan_topics.plans.sent[row]), _plan(plan_topics.plans, row, team.index(name)))
            for name, plan_topics in run.plan_topics.items()
            for row in range(len(plan_topics.plans.tick))
        ]
    )


def replay_planner(question: Question) -> Outcome:
    """Return the plans for the recorded states, sequences and changes.

    Columns are the velocities of all robots with plans at all states of a horizon; nan where a
    robot has no plan of the tick.

    Raises:
        BagError: the bag holds no plans, or a change without what it changes.
    """
    if not question.run.plan_topics:
        raise BagError(f"{question.run.path}: holds no plan of the HTMPC")
    run, team = question.run, build_team(question.resolved)
    found: dict[int, tuple[float, Matrix]] = {}  # by tick: stamp, and both plans of all robots
    width = max(plan_topics.plans.velocity.shape[1] for plan_topics in run.plan_topics.values())
    whole = sum(len(plan_topics.plans.tick) for plan_topics in run.plan_topics.values())
    for done, (place, tick, stamp, recorded, replayed) in enumerate(_plans(question, team), 1):
        if tick not in found:
            found[tick] = stamp, np.full((2, len(run.plan_topics) * width), np.nan)
        mine = slice(place * width, place * width + recorded.size)
        found[tick][1][:, mine] = recorded, replayed
        question.progress(done / whole)
    ticks = sorted(found)
    both = np.array([found[tick][1] for tick in ticks])
    return Outcome(
        PLANNER,
        tuple(joint for name in run.plan_topics for joint in _columns(team, name, width)),
        np.array(ticks, np.int64),
        np.array([found[tick][0] for tick in ticks]),
        np.ascontiguousarray(both[:, 0]),
        np.ascontiguousarray(both[:, 1]),
        "plan",
    )


class _Robot:
    """One robot's sequences, as the bag tells of them.

    Attributes:
        runner: what executes them.
        plans: that were recorded.
    """

    def __init__(self, runner: SequenceRunner, topics: PlanTopics) -> None:
        """Begin before the first event."""
        self.runner = runner
        self.plans = topics.plans
        self._events = Arrivals([(event.sent, event) for event in topics.events])
        self._tasks: tuple[SequenceTask, ...] = ()

    def go_on(self, sent: int, states: States) -> None:
        """Do what was done before a time [ns]; raises BagError for a change of what is unknown."""
        for event in self._events.until(sent):
            if event.tick in states:
                try:
                    _apply(self.runner, event, self._tasks, states[event.tick])
                except InputError as error:  # events before it are not in the bag
                    where = f"{PLANNER}: {event.event} at tick {event.tick}"
                    raise BagError(f"{where}: {error}") from error
            self._tasks = event.tasks


def _plans(question: Question, team: Team) -> Iterator[tuple[int, int, float, Vector, Vector]]:
    """Yield of every plan, in the order of their sending, what ``replay_planner`` compares.

    These are the robot's place among those with plans, tick, stamp [s], recorded and replayed
    velocities.

    Raises:
        BagError: the bag holds a change, but not what it changes.
    """
    run, scenario = question.run, question.resolved.scenario
    config, blend = question.resolved.htmpc[scenario.htmpc.parameters], scenario.transition.duration
    states = States(run)
    robots = [
        _Robot(SequenceRunner(team, team.index(name), config, blend), topics)
        for name, topics in run.plan_topics.items()
    ]
    runners = {robot.runner.robot: robot.runner for robot in robots}
    rows = [
        (int(sent), place, row)
        for place, robot in enumerate(robots)
        for row, sent in enumerate(robot.plans.sent)
    ]
    for sent, place, row in sorted(rows):
        for robot in robots:
            robot.go_on(sent, states)
        runner, plans = robots[place].runner, robots[place].plans
        tick, recorded = int(plans.tick[row]), plans.velocity[row]
        replayed = np.full_like(recorded, np.nan)
        if tick in states and runner.sequence is not None:
            found = runner.step(states[tick], plans_of(runners)).plan.v.ravel()
            replayed = found if found.shape == recorded.shape else replayed
        yield place, tick, float(plans.stamp[row]), recorded, replayed


def _apply(
    runner: SequenceRunner,
    event: SequenceEvent,
    before: tuple[SequenceTask, ...],
    state: RobotState,
) -> None:
    """Do to a runner what was done; ``before`` are the tasks until then."""
    kind, name = event.event, event.changed
    if kind == "end":
        runner.end()
    elif kind in ("begin", "replace"):
        if kind == "begin":
            runner.end()  # a node that was killed has not said so
        runner.begin(event.tasks, ARCHITECTURES[event.architecture], state)
    elif runner.sequence is not None:
        tasks = {task.name: task for task in event.tasks}
        names = list(tasks)
        change = Change("release", name)
        if kind == "cancel":
            change = Change("cancel", name)
        elif kind == "retarget":
            change = Change("retarget", name, points=tasks[name].points)
        elif kind == "insert":
            after = names[names.index(name) + 1 :]
            known = {task.name for task in before}
            follower = next((other for other in after if other in known), "")
            change = Change("insert", name, task=tasks[name], before=follower)
        runner.change(change, state)


def _plan(plans: PlanStream, row: int, robot: int) -> HeardPlan:
    """Return a recorded plan as the controller took it."""
    times = np.asarray(plans.times[row])
    times = times[np.isfinite(times)]
    velocities = plans.velocity[row].reshape(len(times), -1)
    return HeardPlan(robot, int(plans.tick[row]), times, velocities)


def _columns(team: Team, name: str, width: int) -> Iterator[Joint]:
    """Yield a name and a unit for every velocity in a robot's plan."""
    mine = [joint for joint in joints_of(team) if joint.name.partition("/")[0] == name]
    for column in range(width):
        joint = mine[column % len(mine)]
        yield Joint(f"{joint.name}, state {column // len(mine)}", joint.unit)
