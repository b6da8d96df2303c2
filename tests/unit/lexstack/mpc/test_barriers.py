"""Relaxed barriers are smooth; their slopes, and those of distances, are those of differences."""

import numpy as np
import pytest

from lexstack.errors import InputError
from lexstack.mpc import CollisionScene, StageModel
from lexstack.mpc.barriers import LimitBarrier, relaxed, slopes
from lexstack.mpc.collision_cost import Collisions
from support.htmpc import config, robot, sphere_centers

LIMITS = config().limits
SPACE = config().collision


@pytest.mark.parametrize("room", [-1.0, 0.0, 0.001, 0.0049999, 0.005, 0.0050001, 0.1, 3.0])
def test_slopes_of_the_barrier_are_those_of_differences(room):
    h = 1e-7
    values = [relaxed(LIMITS, np.array([room + k * h])) for k in (-1, 0, 1)]
    first, second = (float(s[0]) for s in slopes(LIMITS, np.array([room])))
    assert (values[2] - values[0]) / (2 * h) == pytest.approx(first, rel=1e-4)
    up, down = (float(slopes(LIMITS, np.array([room + k * h]))[0][0]) for k in (1, -1))
    if abs(room - LIMITS.zeta) > 1e-6:
        assert (up - down) / (2 * h) == pytest.approx(second, rel=1e-4)


def test_the_barrier_is_the_logarithm_far_and_finite_beyond():
    assert relaxed(LIMITS, np.array([2.0])) == pytest.approx(-LIMITS.mu * np.log(2.0))
    assert np.isfinite(relaxed(LIMITS, np.array([-100.0])))
    below, above = (relaxed(LIMITS, np.array([LIMITS.zeta * s])) for s in (1 - 1e-9, 1 + 1e-9))
    assert below == pytest.approx(above)


def test_limit_barriers_have_the_slopes_of_differences():
    rng = np.random.default_rng(5)
    lower = np.array([-np.inf, -1.0, -2.0])
    barrier = LimitBarrier(LIMITS, (lower, -lower), np.full(3, 1.5), np.full(3, 2.5))
    point = [rng.uniform(-1.2, 1.2, (4, 3)) for _ in range(3)]
    first, second = barrier.slopes(*point)
    for part in range(3):
        for k, joint in ((0, 0), (1, 1), (3, 2)):
            h = 1e-6
            costs, grads = [], []
            for s in (h, -h):
                moved = [p.copy() for p in point]
                moved[part][k, joint] += s
                costs.append(barrier.value(*moved))
                grads.append(barrier.slopes(*moved)[0][part][k, joint])
            assert (costs[0] - costs[1]) / (2 * h) == pytest.approx(
                first[part][k, joint], rel=1e-5, abs=1e-9
            )
            assert (grads[0] - grads[1]) / (2 * h) == pytest.approx(
                second[part][k, joint], rel=1e-5, abs=1e-7
            )
    assert np.all(first[0][:, 0] == 0.0), "a joint without position limits has no barrier"


def scene(seed, stages=3):
    model = robot("panda_summit")
    chosen = (0, 8, 12, 19, 23)
    stage_model = StageModel(model, stages, chosen)
    rng = np.random.default_rng(seed)
    q = model.home((0.0, 0.0, 0.0)) + rng.normal(0, 0.3, (stages, model.n))
    centers = rng.uniform([0.3, -1, 0.2], [1.5, 1, 1.5], (4, 3))
    around = CollisionScene.moving(
        centers, rng.normal(0, 0.3, (4, 3)), np.full(4, 0.1), 0.1 * np.arange(1, stages + 1)
    )
    return stage_model, Collisions(SPACE, stage_model, around), q, around


def test_collision_gradient_is_that_of_differences():
    stage_model, collisions, q, _ = scene(0)
    gradient, hessian = collisions.slopes(stage_model.at(q))
    for k in range(len(q)):
        for joint in range(q.shape[1]):
            moved = [q.copy(), q.copy()]
            moved[0][k, joint] += 1e-6
            moved[1][k, joint] -= 1e-6
            costs = [collisions.value(stage_model.at(m)) for m in moved]
            assert (costs[0] - costs[1]) / 2e-6 == pytest.approx(
                gradient[k, joint], rel=1e-5, abs=1e-9
            )
        assert np.linalg.eigvalsh(hessian[k]).min() > -1e-12


def test_collision_distance_is_that_of_all_pairs():
    stage_model, collisions, q, around = scene(1)
    least = np.inf
    for k in range(len(q)):
        centers = sphere_centers("panda_summit", q[k])
        for i, place in enumerate(stage_model.spheres):
            for o, radius in enumerate(around.radii):
                apart = np.linalg.norm(centers[place] - around.centers[k, o])
                least = min(least, apart - stage_model.radii[i] - radius)
            if robot("panda_summit").config.spheres[place].link != "base":
                least = min(least, centers[place][2] - stage_model.radii[i])
    assert collisions.distance(stage_model.at(q)) == pytest.approx(least, abs=1e-12)


def test_a_sphere_in_the_centre_of_an_obstacle_costs_and_gives_finite_slopes():
    stage_model, _, q, _ = scene(2)
    at = stage_model.at(q)
    around = CollisionScene(at.centers[:, 3:4], np.array([0.1]))
    collisions = Collisions(SPACE, stage_model, around)
    assert collisions.value(at) > 0.0
    assert all(np.isfinite(part).all() for part in collisions.slopes(at))


@pytest.mark.parametrize(
    ("centers", "radii"),
    [((3, 2, 3), (1,)), ((2, 1, 3), (1,)), ((3, 1, 2), (1,))],
)
def test_surroundings_of_a_wrong_shape_are_refused(centers, radii):
    stage_model, *_ = scene(0)
    with pytest.raises(InputError, match="surroundings: centers of shape"):
        Collisions(SPACE, stage_model, CollisionScene(np.zeros(centers), np.ones(radii)))
