"""The HTMPC in the running system: its plan is followed, lost, and left again."""

import dataclasses
import os
import signal
import time
from collections import Counter
from functools import cache, partial

import numpy as np
import pytest
from rclpy.action import ActionClient
from std_msgs.msg import String

from lexstack.mpc import SequenceTask
from lexstack_bag.figures.figures import compute_metrics
from lexstack_bag.figures.phases import find_phases
from lexstack_bag.figures.series import measure
from lexstack_bag.replay.changes import Changes
from lexstack_bag.replay.nodes import REPLAYERS, Question
from lexstack_bag.report import sequences
from lexstack_bag.run.reader import read_run
from lexstack_bringup.processes import PLANNERS
from lexstack_config.resolved import load_scenario
from lexstack_interfaces.action import ExecuteSequence
from lexstack_interfaces.msg import SequenceStatus, TransitionStatus
from lexstack_interfaces.srv import ChangeSequence
from lexstack_ros.messages.plans import task_message
from lexstack_ros.messages.qos import STREAM
from lexstack_ros.node.calls import let_be_known, wait_until
from lexstack_ros.node.readiness import READY
from lexstack_testing.played_run import apart, together
from support.logs import until_printed
from support.planned_loop import PlannedLoop
from support.runs import acceleration_ratio, chi_by_tick, read, transitions
from support.scenario import CONFIG, team

pytestmark = pytest.mark.system
ACTION, CHI = "/htmpc/execute_sequence", "/robot_a/chi"


def scenario(name, **values):
    """Return a scenario with other values."""
    resolved = load_scenario(CONFIG / f"scenarios/{name}.yaml")
    return dataclasses.replace(resolved, scenario=dataclasses.replace(resolved.scenario, **values))


@pytest.fixture(scope="module")
def delivery(tmp_path_factory):
    """Return the folder of a lockstep run with two sequences at once, and their results."""
    folder = tmp_path_factory.mktemp("delivery")
    with together(scenario("deliver-both", duration=7.5), folder) as run:
        run.play()
        results = dict(run.player._sequences.results)
    return folder, results


def transitions_of(run_folder, robot):
    """Return the transition states of one robot's arm and base, in order."""
    return [m for m in transitions(run_folder / "bag") if robot in m.robots]


def largest_acceleration(run_folder):
    """Return the largest acceleration of the command over its limit."""
    return acceleration_ratio(run_folder / "bag", team().limits.acceleration, 0.01)


@pytest.mark.parametrize(
    ("name", "robot", "begin"), [("left", "robot_a", 100), ("right", "robot_b", 150)]
)
def test_a_follows_the_plans_of_both_robots_and_goes_back(delivery, name, robot, begin):
    folder, results = delivery
    result, plan = results[name], f"plan_{robot}"
    assert (result.success, result.done, result.message) == (True, 2, "")
    states = transitions_of(folder, robot)
    stacks = list(dict.fromkeys(m.to_stack for m in states if m.phase == TransitionStatus.BLENDING))
    assert stacks == [plan, "posture"]
    assert {m.source for m in states if m.to_stack == plan and m.tick > begin} == {"htmpc"}
    assert (states[-1].phase, states[-1].to_stack) == (TransitionStatus.IDLE, "posture")
    assert largest_acceleration(folder) <= 1.0 + 1e-6
    statuses: list[SequenceStatus] = read(folder / "bag", "/htmpc/status")["/htmpc/status"]
    mine = [m for m in statuses if m.robot == robot]
    assert all(m.solved for m in mine)
    assert [m.index for m in mine] == sorted(m.index for m in mine)
    assert mine[0].tick == begin
    assert set(np.diff([m.tick for m in mine])) == {5}, "20 Hz beside 100 Hz, none missing"


def test_two_lockstep_runs_are_equal_to_the_bit_whatever_goals_were_refused(delivery, tmp_path):
    """The one in one process, the other in five."""
    with apart(scenario("deliver-both", duration=5.0), tmp_path) as run:
        refused(run)
        run.play()
    chi = [chi_by_tick(folder / "bag", CHI) for folder in (delivery[0], tmp_path)]
    assert len(chi[1]) == 500
    assert {tick: chi[0][tick] for tick in chi[1]} == chi[1]


@pytest.mark.parametrize("node", REPLAYERS)
def test_a_replay_gives_the_same_bits(delivery, node):
    run = recorded(delivery[0])
    found = REPLAYERS[node](Question(run, Changes(), run.resolved))
    assert found.identical, found.line()
    assert len(found.tick) > 50


@cache
def recorded(folder):
    """Return the run in a folder."""
    return read_run(folder)


def test_the_run_through_processes_is_the_one_in_one_process(delivery):
    loop = PlannedLoop(recorded(delivery[0]).resolved)
    chi = np.array([command.chi for command in loop.run(300).commands])
    np.testing.assert_allclose(chi, recorded(delivery[0]).chi["robot_a"].chi[:300], atol=1e-6)


def test_metrics_and_report_tell_of_the_sequences(delivery):
    run = read_run(delivery[0], plans=False)
    assert [len(plan_topics.plans.tick) for plan_topics in run.plan_topics.values()] == [0, 0]
    phases, time_series = find_phases(run), measure(run)
    metrics = compute_metrics(run, time_series, phases)
    assert [(one.robot, one.done, one.count) for one in metrics.sequences] == [
        ("robot_a", 2, 2),
        ("robot_b", 2, 2),
    ]
    assert all(1.0 < one.completion_s < 6.0 for one in metrics.sequences)
    assert all(one.failed_plans == 0 for one in metrics.sequences)
    figures = sequences.figures(run, time_series, phases, metrics)
    assert len(figures) == 4
    assert all(figure.traces for figure in figures)


def refused(run):
    """Send goals that cannot be met; each is refused, and the node's log says why."""
    client = ActionClient(run.player, ExecuteSequence, ACTION)
    assert client.wait_for_server(timeout_sec=10.0)
    let_be_known(run.executor)
    good = task_message(SequenceTask("give", "ee_position", ((1.0, 0.0, 1.0),)))
    wrong = task_message(SequenceTask("give", "ee_position", ((1.0, 0.0, 1.0),)))
    wrong.kind = "tail"
    high = task_message(SequenceTask("up", "ee_position", ((1.0, 0.0, 4.0),)))
    cases = {
        "robot: unknown 'robot_x'": {"robot": "robot_x", "tasks": [good]},
        "tasks: expected 1 to": {"tasks": []},
        "kind: 'tail'": {"tasks": [wrong]},
        "architecture: unknown": {"tasks": [good], "architecture": "xx"},
        "at_tick: must be given": {"tasks": [good], "at_tick": 0},
        "two tasks have the name": {"tasks": [good, good]},
        "task 'up': points[0]: out of reach": {"tasks": [good, high]},
    }
    for text, fields in cases.items():
        goal = ExecuteSequence.Goal(**{"robot": "robot_a", "at_tick": 50, **fields})
        time.sleep(0.1)  # not a flood: of that the log tells a part
        future = client.send_goal_async(goal)
        assert wait_until(run.executor, future.done, 15.0)
        assert not future.result().accepted
        assert f"refused: {ACTION}: " in until_printed(
            run.out / "logs/htmpc.log", text, patience=10.0
        )


class EnoughSeenError(Exception):
    """The run has shown what it was for."""


def drive(name, x, **values):
    """Return a task that drives robot A's base to x [m]."""
    return SequenceTask(name, "base_position", ((x, 0.0),), speed=0.3, tolerance=0.05, **values)


class KillAndAskAgain:
    """Kills the HTMPC while it is followed, starts it anew, and sends one goal after another.

    The first one is pre-empted by the second, that is cancelled, the third is held until released.
    """

    goals = (
        (drive("far", 3.0),),
        (drive("other", -3.0),),
        (drive("near", 0.0), drive("wait", 0.0, held=True)),
    )

    def __init__(self, run):
        """Watch a run from its first tick on."""
        self.run, self.killed, self.again = run, 0, None
        self.asked = self.cancelled = -np.inf  # s
        self.client = ActionClient(run.player, ExecuteSequence, ACTION)
        self.changes = run.player.create_client(ChangeSequence, "/htmpc/change_sequence")
        self.change = None
        self.release = run.player.create_publisher(String, "/htmpc/release", STREAM)
        self.handles, self.results, self.seen = {}, {}, Counter()

    def __call__(self):
        """Do what is due; raises EnoughSeenError at the end."""
        player = self.run.player
        if not self.killed and player.tick >= 210:
            self.killed = player.tick
            os.kill(self.run.process("htmpc").pid, signal.SIGKILL)
            given = ["--ros-args", "-p", f"scenario:={self.run.out / 'scenario.yaml'}"]
            given += ["-p", "peers:=hqp_controller"]
            self.again = self.run.supervisor.start("htmpc_again", PLANNERS["htmpc"], given)
        if not self.killed or player.tick < self.killed + 215 or not self.again.printed(READY):
            return
        self.go_on(len(self.handles))
        if self.seen["wait"] > 5 and self.change is None:
            high = task_message(SequenceTask("up", "ee_position", ((0.0, 0.0, 4.0),)))
            request = ChangeSequence.Request(change=ChangeSequence.Request.INSERT, task=high)
            self.change = self.changes.call_async(request)
        if self.seen["wait"] > 20:
            self.release.publish(String(data="robot_a/wait"))
        if 2 in self.results and player.transition.to_stack == "posture":
            raise EnoughSeenError

    def go_on(self, accepted):
        """Send the next goal when the one before has shown enough."""
        due = [True, self.seen["far"] > 15, 1 in self.results, False][accepted]
        # The dead server is seen for a while longer, and what is sent to it is lost: ask again.
        if due and time.monotonic() > self.asked + (30.0 if accepted else 2.0):
            self.asked = time.monotonic()
            tasks = [task_message(task) for task in self.goals[accepted]]
            # Ticks go on meanwhile, faster than the wall's clock.
            at_tick = self.run.player.tick + 400
            goal = ExecuteSequence.Goal(robot="robot_a", tasks=tasks, at_tick=at_tick)
            future = self.client.send_goal_async(goal, feedback_callback=self.feedback)
            future.add_done_callback(partial(self.accepted, accepted))
        due = accepted == 2 and self.seen["other"] > 15 and 1 not in self.results
        if due and time.monotonic() > self.cancelled + 2.0:
            self.cancelled = time.monotonic()
            self.handles[1].cancel_goal_async()

    def feedback(self, message):
        """Count the plans of each task; of the last one those that only wait."""
        status = message.feedback.status
        self.seen[status.task] += status.task != "wait" or status.error < 0.05

    def accepted(self, number, future):
        """Wait for the result; a goal that came too late for its tick is asked for again."""
        self.asked = -np.inf
        if future.result().accepted:
            self.handles[number] = future.result()
            future.result().get_result_async().add_done_callback(partial(self.ended, number))

    def ended(self, number, future):
        """Keep the result."""
        self.results[number] = future.result().result


def test_the_plan_s_loss_brings_a_to_rest_and_the_next_sequences_are_taken(tmp_path):
    with apart(scenario("deliver-one", duration=600.0), tmp_path) as run:
        watch = KillAndAskAgain(run)
        with pytest.raises(EnoughSeenError):
            run.play(watch)
    states = transitions_of(tmp_path, "robot_a")
    lost = next(m for m in states if "the MPC lost at tick" in m.reason)
    assert lost.tick >= watch.killed - 10
    assert "come to rest" in lost.reason
    chi = {tick: np.frombuffer(b) for tick, b in chi_by_tick(tmp_path / "bag", CHI).items()}
    ticks = range(lost.tick + 150, lost.tick + 200)
    at_rest = [chi[tick][:10] for tick in ticks if tick in chi]
    assert at_rest
    assert np.abs(at_rest).max() < 1e-3
    assert largest_acceleration(tmp_path) <= 1.0 + 1e-6
    after = [m.source for m in states if m.id > lost.id and m.to_stack == "plan_robot_a"]
    assert "htmpc" in after, "the controller follows again"
    results = [watch.results[number] for number in range(3)]
    assert [result.message for result in results[:2]] == [
        "pre-empted by another sequence",
        "cancelled",
    ]
    assert (results[2].success, results[2].done) == (True, 2)
    assert watch.seen["wait"] > 20, "held until released by topic"
    assert not watch.change.result().accepted
    assert "task 'up': points[0]: out of reach" in watch.change.result().message
