"""Goals that cannot be met are known before a sequence begins; the others are let through."""

import numpy as np
import pytest

from lexstack.errors import InputError
from lexstack.mpc import Reach, SequenceTask, tasks_of
from lexstack.robots import ObstacleConfig, Obstacles, RobotModel, to_quaternion
from lexstack_config.resolved import load_robot, load_scenario
from support.scenario import CONFIG

NONE = Obstacles({})


def robot(model="panda_summit"):
    """Return one robot."""
    return RobotModel("robot_a", load_robot(CONFIG / "robots" / f"{model}.yaml"))


def task(kind, *point, **values):
    """Return a task with one point."""
    return SequenceTask("it", kind, (point,), **values)


@pytest.mark.parametrize("model", ["panda_summit", "ur10_ridgeback"])
def test_whatever_pose_the_robot_has_it_can_be_sent_to(model):
    made, rng = robot(model), np.random.default_rng(1)
    limits, reach = made.limits, Reach(made, NONE)
    for _ in range(30):
        arm = rng.uniform(limits.position_lower[3:], limits.position_upper[3:])
        base = (*rng.uniform(-3.0, 3.0, 2), rng.uniform(-np.pi, np.pi))
        pose = made.tool(np.array([*base, *arm]))[0]
        if pose.position[2] < 0.0:
            continue
        point = (*pose.position, *to_quaternion(pose.rotation))
        reach.check([task("ee_pose", *point)], "ht")
        reach.check([task("ee_position", *pose.position)], "ht")
        reach.check([task("ee_position", *pose.position)], "st", base)
        reach.check([task("base_pose", *base), task("ee_pose", *point)], "st")


@pytest.mark.parametrize(
    ("wrong", "architecture", "message"),
    [
        (task("ee_position", 0.5, 0.0, 2.5), "ht", "out of reach: the tool comes to 0.659 m of it"),
        (task("ee_position", 0.5, 0.0, -0.4), "ht", "0.40 m below the floor"),
        (task("ee_position", 4.0, 0.0, 1.0), "st", "with the base at (0.00, 0.00) m"),
        (task("ee_pose", 0.5, 0.0, 1.75, 1.0, 0.0, 0.0, 0.0), "ht", "out of reach: the tool"),
        (task("ee_position", 3.1, 0.0, 0.5), "ht", "inside an obstacle"),
        (task("base_position", 3.0, 0.5), "ht", "an obstacle stands there"),
    ],
)
def test_a_goal_that_cannot_be_met_is_refused_with_the_reason(wrong, architecture, message):
    post = Obstacles({"post": ObstacleConfig((3.0, 0.0, 0.5), 0.4)})
    with pytest.raises(InputError) as error:
        Reach(robot(), post).check([wrong], architecture, (0.0, 0.0, 0.0))
    assert str(error.value).startswith("task 'it': points[0]: ")
    assert message in str(error.value)


def test_an_obstacle_that_moves_is_no_reason():
    ball = Obstacles({"ball": ObstacleConfig((3.0, 0.0, 0.5), 0.4, velocity=(0.1, 0.0, 0.0))})
    Reach(robot(), ball).check([task("base_position", 3.0, 0.0)], "ht")


def test_in_st_the_base_tasks_before_count():
    reach, far = Reach(robot(), NONE), task("ee_position", 4.0, 0.0, 1.0)
    with pytest.raises(InputError, match="out of reach"):
        reach.check([far], "st", (0.0, 0.0, 0.0))
    near = SequenceTask("near", "base_position", ((3.5, 0.0),))
    reach.check([near, far], "st", (0.0, 0.0, 0.0))
    reach.check([far], "ht", (0.0, 0.0, 0.0))
    reach.check([far], "st", None)


def test_a_wide_tolerance_lets_a_goal_through():
    reach = Reach(robot(), NONE)
    high = task("ee_position", 0.5, 0.0, 1.95, tolerance=0.3)
    reach.check([high], "ht")
    with pytest.raises(InputError):
        reach.check([task("ee_position", 0.5, 0.0, 1.95)], "ht")


@pytest.mark.parametrize("name", ["deliver-one", "deliver-both", "delivery", "reactivity"])
def test_every_sequence_of_the_configuration_can_be_met(name):
    found = load_scenario(CONFIG / "scenarios" / f"{name}.yaml")
    for config in found.scenario.sequences.values():
        place = found.scenario.robots[config.robot]
        made = RobotModel(config.robot, found.robots[place.model])
        obstacles = Obstacles(found.scenario.obstacles)
        Reach(made, obstacles).check(tasks_of(config), config.architecture, place.base)


def test_the_answer_is_the_same_each_time():
    goal = task("ee_pose", 0.5, 0.0, 1.75, 1.0, 0.0, 0.0, 0.0)
    texts = set()
    for _ in range(2):
        with pytest.raises(InputError) as error:
            Reach(robot(), NONE).check([goal], "ht")
        texts.add(str(error.value))
    assert len(texts) == 1
