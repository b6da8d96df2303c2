"""Joint positions at a pose, and the quickest way of joints to them."""

from functools import cache

import numpy as np
import pytest

from lexstack.errors import InputError, ModelError
from lexstack.limits import travel_time
from lexstack.references import PointToPoint
from lexstack.robots import Pose, RobotModel, inverse_kinematics
from lexstack.tasks import pose_error
from lexstack_config.resolved import load_robot
from support.scenario import CONFIG


@cache
def robot(name):
    return RobotModel(name, load_robot(CONFIG / f"robots/{name}.yaml"))


def inside(name, rng):
    limits = robot(name).limits
    lower = np.where(np.isfinite(limits.position_lower), limits.position_lower, -6.0)
    upper = np.where(np.isfinite(limits.position_upper), limits.position_upper, 6.0)
    return lower + rng.uniform(0.05, 0.95, robot(name).n) * (upper - lower)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("name", ["panda", "ur10", "xarm7", "kinova"])
def test_the_frame_is_at_the_pose_and_the_joints_inside_their_limits(name, seed):
    rng, model = np.random.default_rng(seed), robot(name)
    start, goal = inside(name, rng), model.tool(inside(name, rng))[0]
    q = inverse_kinematics(model, goal, start)
    assert q is not None
    assert np.abs(pose_error(model.tool(q)[0], goal)).max() <= 1e-6
    assert (q >= model.limits.position_lower).all()
    assert (q <= model.limits.position_upper).all()
    np.testing.assert_array_equal(q, inverse_kinematics(model, goal, start))


def test_more_tries_find_no_slower_one_and_whole_turns_are_taken_off():
    rng, model = np.random.default_rng(3), robot("ur10")
    for _ in range(5):
        start, goal = inside("ur10", rng), model.tool(inside("ur10", rng))[0]
        limits = model.limits
        times = [
            travel_time(q - start, limits.velocity, limits.acceleration).max()
            for tries in (4, 16)
            if (q := inverse_kinematics(model, goal, start, tries=tries)) is not None
        ]
        assert times[-1] <= times[0]
    q = model.home()
    q[0] += 2.0 * np.pi - 0.3
    found = inverse_kinematics(model, model.tool(model.home())[0], q)
    assert np.abs(found - q).max() < np.pi


def test_a_base_stays_and_other_frames_have_poses_too():
    model = robot("tiago")
    q = model.home()
    away = q.copy()
    away[model.arm] += 0.2
    place = model.frame("arm_5_link")
    goal, _ = model.at(away, place)
    found = inverse_kinematics(model, goal, q, frame="arm_5_link")
    np.testing.assert_array_equal(found[model.base], q[model.base])
    assert np.abs(pose_error(model.at(found, place)[0], goal)).max() <= 1e-6


def test_out_of_reach_there_is_none_and_a_wrong_frame_is_refused():
    model = robot("panda")
    far = Pose(np.array([3.0, 0.0, 0.0]), np.eye(3))
    assert inverse_kinematics(model, far, model.home(), tries=3) is None
    with pytest.raises(ModelError, match="no frame 'wing'"):
        inverse_kinematics(model, far, model.home(), frame="wing")


@pytest.mark.parametrize("seed", range(5))
def test_joints_go_straight_within_their_limits_as_quick_as_the_slowest_can(seed):
    rng = np.random.default_rng(seed)
    start, goal = rng.normal(size=(2, 5)) * 10.0 ** rng.uniform(-2, 0.5)
    velocity, acceleration = rng.uniform(0.5, 2.0, (2, 5)) * np.array([[1.0], [4.0]])
    way = PointToPoint(2.0, start, goal, velocity, acceleration)
    least = travel_time(goal - start, velocity, acceleration).max()
    assert least - 1e-12 <= way.end - 2.0 <= 1.6 * least
    dt = 1e-3
    stamps = np.arange(1.9, way.end + 0.1, dt)
    places = np.array([way.at(stamp) for stamp in stamps])
    rates = np.array([way.rate(stamp) if way.rate(stamp) is not None else 0 * goal
                      for stamp in stamps])  # fmt: skip
    assert (np.abs(rates) <= velocity + 1e-12).all()
    assert (np.abs(np.diff(rates, axis=0)) <= dt * acceleration + 1e-12).all()
    middle = 0.5 * (rates[1:] + rates[:-1])
    np.testing.assert_allclose(np.diff(places, axis=0) / dt, middle, atol=dt * acceleration.max())
    np.testing.assert_array_equal(places[0], start)
    assert way.at(way.end) is way.at(way.end + 1.0) is way.goal
    share = (places - start) / (goal - start)
    np.testing.assert_allclose(share, share[:, :1] * np.ones(5), atol=1e-9)


def test_joints_of_one_shape_take_the_least_time_and_nowhere_to_go_takes_none():
    ones = np.ones(3)
    way = PointToPoint(0.0, 0 * ones, np.array([0.1, 2.0, -0.5]), ones, 4.0 * ones)
    assert way.end == pytest.approx(2.0 + 0.25)
    assert PointToPoint(1.0, ones, ones, ones, ones).end == 1.0


@pytest.mark.parametrize(
    ("values", "text"),
    [
        (([0.0], [1.0, 2.0], [1.0], [1.0]), "vectors of one length"),
        (([0.0], [np.nan], [1.0], [1.0]), "expected finite numbers"),
        (([0.0], [1.0], [0.0], [1.0]), "expected limits > 0"),
    ],
)
def test_a_wrong_way_is_refused(values, text):
    with pytest.raises(InputError, match=text):
        PointToPoint(0.0, *map(np.array, values))
