"""Errors of tasks on frames, axes, masses and pairs of frames, in the figures of a run."""

import json
from dataclasses import replace

import numpy as np
import pytest

from lexstack.tasks import LevelConfig, StackConfig, TaskConfig
from lexstack_bag.figures.compare import compare_metrics
from lexstack_bag.figures.goals import summary_lines
from lexstack_bag.report.tables import tasks_table
from lexstack_config.resolved import load_scenario
from lexstack_experiments.ideal import IdealPlant
from lexstack_experiments.loop import Loop
from lexstack_experiments.runs import analysed, changed
from support.scenario import CONFIG, team


class Standing(IdealPlant):
    """Robots that stay where they are, whatever they are told."""

    def step(self, chi):
        """Let a tick pass."""
        return super().step(np.zeros(20))


def measured(*tasks, plant=None, seconds=0.6):
    """Return a run of the default scenario on a stack of these tasks, and its figures."""
    resolved = load_scenario(CONFIG / "scenarios" / "transition-sequence.yaml")
    stack = StackConfig("own", "", tuple(LevelConfig((task,)) for task in tasks))
    resolved = replace(resolved, stacks={**resolved.stacks, "own": stack})
    resolved = changed(
        resolved, initial_stack="own", events=(), duration=seconds, mode="lockstep", ee_target={}
    )
    loop = Loop(resolved)
    loop.plant = (plant or IdealPlant)(resolved, loop.parts.team)
    loop.run()
    return loop, analysed(loop)


def test_each_task_has_the_distance_from_what_it_asks_for():
    home = Loop(load_scenario(CONFIG / "scenarios" / "transition-sequence.yaml")).plant.state().q
    robot = team().robots[0]
    centre = robot.centre_of_mass(home[:10])[0]
    tool = robot.tool(home[:10])[0]
    off = tool.rotation @ np.array([0.0, np.sin(0.3), np.cos(0.3)])
    away = TaskConfig(
        "relative_pose", "robot_a",
        parameters={"frame": "panda_link4", "other_frame": "panda_link4", "other": "robot_b"},
    )  # fmt: skip
    _, run = measured(
        TaskConfig("centre_of_mass", "robot_a", 4.0,
                   {"target": (centre + np.array([0.03, 0.04, 0.0])).tolist()}),
        TaskConfig("axis_alignment", "robot_a", parameters={"direction": off.tolist()}),
        TaskConfig("ee_pose", "robot_a"),
        away,
        TaskConfig("velocity_damping"),
        plant=Standing,
    )  # fmt: skip
    phase = run.metrics.phases[0]
    found = {one.task: one for one in phase.tasks}
    assert list(found) == [
        "robot_a/centre_of_mass",
        "robot_a/axis_alignment",
        "robot_a/relative_pose(panda_link4, panda_link4)",
    ]
    mass, axis, pair = found.values()
    assert mass.error_mm == pytest.approx(50.0)
    assert mass.peak_error_mm == pytest.approx(50.0)
    assert mass.error_mrad is None
    assert axis.error_mrad == pytest.approx(300.0)
    assert axis.error_mm is None
    assert (pair.error_mm, pair.error_mrad) == (0.0, 0.0)
    assert phase.relative_error_mm is None
    assert phase.settled_s == 0.0, "all stand still"
    text = "own: robot_a/centre_of_mass 50.00 mm, peak 50.00 mm"
    assert text in summary_lines(run.metrics)
    assert "robot_a/axis_alignment" in tasks_table(run.metrics)
    assert json.loads(run.metrics.to_json())["phases"][0]["tasks"][0]["error_mm"] is not None


def test_the_time_to_settle_is_that_of_any_task():
    turned = TaskConfig("axis_alignment", "robot_a", parameters={"direction": [1.0, 0.0, -1.0]})
    _, run = measured(turned, TaskConfig("velocity_damping"), seconds=6.0)
    phase = run.metrics.phases[0]
    (axis,) = phase.tasks
    assert phase.has_errors
    assert axis.error_mrad < 1.0
    assert axis.peak_error_mrad > 700.0
    assert 0.5 < phase.settled_s < 5.0


def test_a_stack_of_tools_and_bases_alone_has_no_more_than_before():
    _, run = measured(TaskConfig("ee_pose"), TaskConfig("base"), TaskConfig("posture"))
    assert run.metrics.phases[0].tasks == ()
    assert not tasks_table(run.metrics)


def test_two_runs_are_compared_by_task():
    metrics = [
        measured(TaskConfig("axis_alignment", "robot_a", parameters={"direction": direction}),
                 plant=Standing)[1].metrics
        for direction in ([1.0, 0.0, -1.0], [0.0, 0.0, -1.0])
    ]  # fmt: skip
    told = [entry.figure for entry in compare_metrics(*metrics).differences]
    assert "task error, robot_a/axis_alignment" in told
