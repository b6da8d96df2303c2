"""The HTMPC in the running system: A follows its plan, survives its loss, and goes back."""

import dataclasses
import os
import signal
import time

import numpy as np
import pytest
from rclpy.action import ActionClient

from lexstack_core.config.resolved import load_scenario
from lexstack_core.htmpc import SequenceTask
from lexstack_interfaces.action import ExecuteSequence
from lexstack_interfaces.msg import SequenceStatus, TransitionStatus
from lexstack_ros.bringup import PLANNERS
from lexstack_ros.plan_conversions import task_message
from support.processes import acceleration_ratio, chi_by_tick, read, running
from support.scenario import CONFIG, team

pytestmark = pytest.mark.system
CHI = "/robot_a/chi"


def scenario(**values):
    """Return the scenario with one delivery, shorter."""
    resolved = load_scenario(CONFIG / "scenarios/deliver-one.yaml")
    values = {"duration": 8.0, **values}
    return dataclasses.replace(resolved, scenario=dataclasses.replace(resolved.scenario, **values))


def of_robot_a(run_folder):
    """Return the transition states of robot A's own arm and base, in order."""
    topic = "/robot_a/transition"
    return [m for m in read(run_folder / "bag", topic)[topic] if "robot_a" in m.robots]


def largest_acceleration(run_folder):
    """Return the largest acceleration of the command over its limit."""
    return acceleration_ratio(run_folder / "bag", team().limits.acceleration, 0.01)


def test_a_follows_the_plan_and_goes_back_to_its_own_stack(tmp_path):
    resolved = scenario()
    with running(resolved, tmp_path) as run:
        run.play()
        result = run.player._sequences.results["deliver"]
        assert (result.success, result.done, result.message) == (True, 2, "")
    states = of_robot_a(tmp_path)
    stacks = list(dict.fromkeys(m.to_stack for m in states if m.phase == TransitionStatus.BLENDING))
    assert stacks == ["plan_robot_a", "posture"]
    assert {m.source for m in states if m.to_stack == "plan_robot_a" and m.tick > 100} == {"htmpc"}
    assert (states[-1].phase, states[-1].to_stack) == (TransitionStatus.IDLE, "posture")
    assert largest_acceleration(tmp_path) <= 1.0 + 1e-6
    statuses: list[SequenceStatus] = read(tmp_path / "bag", "/htmpc/status")["/htmpc/status"]
    assert all(m.solved for m in statuses)
    assert [m.index for m in statuses] == sorted(m.index for m in statuses)
    ticks = [m.tick for m in statuses]
    assert set(np.diff(ticks)) == {5}, "20 Hz beside 100 Hz, none missing"


def test_two_lockstep_runs_are_equal_to_the_bit(tmp_path):
    chi = []
    for name in ("one", "two"):
        folder = tmp_path / name
        folder.mkdir()
        with running(scenario(), folder) as run:
            run.play()
        chi.append(chi_by_tick(folder / "bag", CHI))
    assert len(chi[0]) == 800
    assert chi[0] == chi[1]


def test_the_plan_s_loss_brings_a_to_rest_and_the_next_sequence_is_taken(tmp_path):
    resolved = scenario(duration=20.0, mode="realtime")
    goal = ExecuteSequence.Goal(robot="robot_a")
    task = SequenceTask("again", "base_position", ((0.5, 0.0),), speed=0.3, tolerance=0.05)
    goal.tasks = [task_message(task)]
    done = {}

    def accepted(future):
        done["handle"] = future.result()
        future.result().get_result_async().add_done_callback(
            lambda f: done.update(result=f.result().result)
        )

    with running(resolved, tmp_path) as run:
        client = ActionClient(run.player, ExecuteSequence, "/htmpc/execute_sequence")
        acts = {}

        def watch():
            status = run.player.transition
            if status is None:
                return
            if "killed" not in acts and run.player.tick >= 250:
                acts["killed"] = run.player.tick
                os.kill(run.process("htmpc").pid, signal.SIGKILL)
            if "back" not in acts and run.player.tick >= 400:
                acts["back"] = time.monotonic()
                path = tmp_path / "scenario.yaml"
                given = ["--ros-args", "-p", f"scenario:={path}", "-p", "peers:=hqp_controller"]
                run.supervisor.start("htmpc_again", PLANNERS["htmpc"], given)
            if "back" in acts and "asked" not in acts and client.server_is_ready():
                acts["asked"] = True
                client.send_goal_async(goal).add_done_callback(accepted)

        run.play(watch)
        assert "asked" in acts
    states = of_robot_a(tmp_path)
    lost = next(m for m in states if "the MPC lost at tick" in m.reason)
    assert lost.tick >= acts["killed"] - 10
    assert "come to rest" in lost.reason
    chi = {tick: np.frombuffer(b) for tick, b in chi_by_tick(tmp_path / "bag", CHI).items()}
    assert np.abs(chi[lost.tick + 150][:10]).max() < 1e-3
    assert largest_acceleration(tmp_path) <= 1.0 + 1e-6
    assert [m.to_stack for m in states if m.id > lost.id and m.source == "htmpc"], "taken again"
    assert "result" not in done or done["result"].success or done["result"].message


def test_goals_that_cannot_be_are_answered_with_the_reason(tmp_path):
    resolved = scenario(duration=1.0, events=())
    with running(resolved, tmp_path) as run:
        client = ActionClient(run.player, ExecuteSequence, "/htmpc/execute_sequence")
        assert client.wait_for_server(timeout_sec=10.0)
        good = task_message(SequenceTask("give", "ee_position", ((1.0, 0.0, 1.0),)))
        wrong = task_message(SequenceTask("give", "ee_position", ((1.0, 0.0, 1.0),)))
        wrong.kind = "tail"
        cases = {
            "robot: unknown 'robot_x'": ExecuteSequence.Goal(
                robot="robot_x", tasks=[good], at_tick=50
            ),
            "tasks: expected 1 to": ExecuteSequence.Goal(robot="robot_a", at_tick=50),
            "kind: 'tail'": ExecuteSequence.Goal(robot="robot_a", tasks=[wrong], at_tick=50),
            "architecture: unknown": ExecuteSequence.Goal(
                robot="robot_a", tasks=[good], architecture="xx", at_tick=50
            ),
            "at_tick: must be given": ExecuteSequence.Goal(robot="robot_a", tasks=[good]),
            "two tasks have the name": ExecuteSequence.Goal(
                robot="robot_a", tasks=[good, good], at_tick=50
            ),
        }
        for text, goal in cases.items():
            future = client.send_goal_async(goal)
            handle = spun(run, future)
            result = spun(run, handle.get_result_async()).result
            assert not result.success
            assert text in result.message


def spun(run, future):
    """Return a future's result."""
    end = time.monotonic() + 15.0
    while not future.done():
        run.executor.spin_once(timeout_sec=0.1)
        assert time.monotonic() < end
    return future.result()
