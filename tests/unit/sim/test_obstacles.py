"""Obstacles in MuJoCo: where the library has them, in the way, seen by what measures distance."""

import dataclasses
import itertools

import mujoco
import numpy as np
import pytest

from lexstack.errors import ModelError
from lexstack.robots import ObstacleConfig
from lexstack_config.parts import build_team
from lexstack_config.scenario import PlacementConfig
from lexstack_sim.contacts import OBSTACLE, robot_masks
from lexstack_sim.obstacles import Clearance, obstacle_name
from lexstack_sim.plant import Plant
from lexstack_sim.world import build_world
from support.scenario import changed, home, random_q, resolved

POST = ObstacleConfig((0.9, 0.0, 0.25), 0.2)
BALL = ObstacleConfig(
    (-2.0, 0.3, 0.3), 0.15, velocity=(0.5, 0.0, 0.0), swing=(0.0, 0.4, 0.0), period=3.0
)


def plant_with(**obstacles):
    resolved = changed(obstacles=obstacles)
    return Plant(resolved, build_team(resolved))


def test_the_plant_moves_them_as_the_core_says():
    plant = plant_with(post=POST, ball=BALL)
    for _ in range(50):
        plant.step(np.zeros(20))
    step = 0.001  # the last physics step began this much before the state's stamp
    now = plant.team.obstacles.at(plant.state().stamp - step)
    for name, center in zip(plant.team.obstacles.names, now, strict=True):
        body = plant.world.body(obstacle_name(name)).id
        np.testing.assert_allclose(plant._data.xpos[body], center, atol=1e-9)


def test_a_robot_that_runs_into_one_touches_it():
    plant = plant_with(post=POST)
    command = np.zeros(20)
    for tick in range(150):
        command[0] = min(0.02 * tick, 0.5)
        plant.step(command)
    assert plant.counters.contact > 10
    assert plant.contact_force > 1.0
    assert plant.state().q[0] < 0.9 - 0.2 - 0.3655 + 0.02, "it does not go through"


def test_one_that_runs_into_a_robot_touches_it():
    plant = plant_with(ball=dataclasses.replace(BALL, position=(-1.2, 0.0, 0.3)))
    for _ in range(150):
        plant.step(np.zeros(20))
    assert plant.counters.contact > 0


@pytest.fixture(scope="module")
def crowd():
    """Return a plant of 40 robots in a row, with an obstacle beside the last one."""
    model = resolved().scenario.robots["robot_a"].model
    robots = {f"robot_{i}": PlacementConfig(model, (0.0, 3.0 * i, 0.0)) for i in range(40)}
    ball = ObstacleConfig((1.2, 3.0 * 39, 0.3), 0.15)
    scenario = changed(robots=robots, obstacles={"ball": ball}, events=())
    return Plant(scenario, build_team(scenario))


def touching_pairs(crowd, **places):
    """Return who touches whom with some robots' bases moved to places x, y [m]."""
    world = crowd.world
    data = mujoco.MjData(world)
    data.qpos[:] = crowd.reset().q
    for name, place in places.items():
        first = crowd.team.slices[crowd.team.index(name)].start
        data.qpos[first : first + 2] = place
    mujoco.mj_forward(world, data)
    owners = np.array([world.geom(i).name.split("/")[0] for i in range(world.ngeom)])
    return {tuple(sorted(owners[pair])) for pair in data.contact.geom}


@pytest.mark.parametrize("number", [0, 29, 30, 31, 32, 39])
def test_every_one_of_forty_robots_touches_an_obstacle(crowd, number):
    """With one bit of contact for each robot the 31st passed through, the 32nd was a TypeError."""
    assert touching_pairs(crowd) == set()
    beside = (1.2 - 0.45, 3.0 * 39)
    moved = {f"robot_{number}": beside}
    if number != 39:
        moved["robot_39"] = (9.0, 9.0)
    assert touching_pairs(crowd, **moved) == {("obstacle", f"robot_{number}")}


@pytest.mark.parametrize(("one", "other"), [(0, 1), (0, 30), (29, 31), (30, 31), (38, 39), (7, 39)])
def test_any_two_of_forty_robots_touch_each_other(crowd, one, other):
    moved = {f"robot_{one}": (30.0, -30.0), f"robot_{other}": (30.5, -30.0)}
    assert touching_pairs(crowd, **moved) == {tuple(sorted(moved))}


def test_forty_robots_go_a_few_ticks(crowd):
    crowd.reset()
    for _ in range(3):
        state = crowd.step(np.full(crowd.team.n, 0.01))
    assert np.isfinite(state.q).all()
    assert np.abs(state.v).max() > 0.0


def test_robots_touch_exactly_if_their_numbers_differ():
    masks = [robot_masks(i) for i in range(200)]
    for (i, (kind, affinity)), (j, (kind_2, affinity_2)) in itertools.product(
        enumerate(masks), repeat=2
    ):
        assert bool(kind & affinity_2 or kind_2 & affinity) == (i != j)
        assert max(kind, affinity) < OBSTACLE
    with pytest.raises(ModelError, match="at most 32768"):
        robot_masks(32768)


def test_obstacles_touch_no_obstacles_and_not_the_floor():
    plant = plant_with(one=POST, other=dataclasses.replace(POST, position=(0.95, 0.0, 0.1)))
    plant.step(np.zeros(20))
    assert plant.counters.contact == 0
    assert plant._data.ncon == 0


def test_a_saved_plant_has_its_obstacles_with_it():
    plant = plant_with(ball=BALL)
    for _ in range(20):
        plant.step(np.zeros(20))
    saved = plant.save()
    first = [plant.step(np.full(20, 0.01)) for _ in range(20)][-1]
    plant.restore(saved)
    again = [plant.step(np.full(20, 0.01)) for _ in range(20)][-1]
    np.testing.assert_array_equal(first.q, again.q)


def test_the_motion_is_the_same_where_an_obstacle_is_far():
    far = plant_with(far=ObstacleConfig((50.0, 0.0, 0.5), 0.3, velocity=(0.1, 0.0, 0.0)))
    alone = plant_with()
    for tick in range(30):
        command = np.full(20, 0.001 * tick)
        np.testing.assert_array_equal(far.step(command).q, alone.step(command).q)


@pytest.mark.parametrize("seed", range(10))
def test_the_spheres_of_the_core_are_a_careful_measure(seed):
    """The contact geometry sticks out of the spheres by 10 mm at most (see the robot's file)."""
    rng = np.random.default_rng(seed)
    resolved = changed(obstacles={"post": POST, "ball": BALL})
    team = build_team(resolved)
    q, stamp = random_q(rng), rng.uniform(0.0, 5.0)
    q[:2], q[10:12] = rng.uniform(-0.6, 0.6, 2), [2.0, 0.0]
    spheres = team.spheres(q)
    lines = spheres.centers[:, None] - team.obstacles.at(stamp)
    distance = np.linalg.norm(lines, axis=2) - spheres.radii[:, None] - team.obstacles.radii
    by_robot = np.array([distance[spheres.owners == robot].min(axis=0) for robot in (0, 1)])
    clearance = Clearance(build_world(team), team)
    measured = clearance.at(q, stamp, most=9.0)
    assert measured.shape == (2, 2)
    assert (by_robot <= measured + 0.0101).all()
    assert (by_robot >= measured - 0.15).all(), "beside the chassis they stick out most"


def test_depths_are_negative_and_far_is_far():
    resolved = changed(obstacles={"inside": ObstacleConfig((0.2, 0.0, 0.4), 0.1)})
    team = build_team(resolved)
    clearance = Clearance(build_world(team), team)
    inside, far = clearance.at(home(), 0.0)[:, 0]
    assert inside < -0.05
    assert far == 1.0
