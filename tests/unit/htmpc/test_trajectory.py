"""Reference trajectories: speed, the short way of angles, jumps, and what is refused."""

import numpy as np
import pytest

from lexstack_core.errors import InputError
from lexstack_core.htmpc import Trajectory, base_path, ee_path, hold, steps


def test_a_base_line_keeps_its_speed_and_turns_the_short_way():
    line = base_path(2.0, np.array([[0.0, 0.0, 3.0], [3.0, 4.0, -3.0]]), 0.5)
    assert line.end == pytest.approx(12.0)
    values = line.at(np.linspace(2.0, 12.0, 101))
    speeds = np.linalg.norm(np.diff(values[:, :2], axis=0), axis=1) / 0.1
    np.testing.assert_allclose(speeds, 0.5, atol=1e-12)
    assert np.ptp(values[:, 2]) == pytest.approx(2 * np.pi - 6.0)
    np.testing.assert_allclose(np.sin(line.goal[2]), np.sin(-3.0), atol=1e-12)
    np.testing.assert_array_equal(line.at(np.array([0.0]))[0], [0.0, 0.0, 3.0])
    np.testing.assert_array_equal(line.at(np.array([99.0]))[0], line.goal)


def test_turning_on_the_spot_takes_its_time():
    line = base_path(0.0, np.array([[1.0, 1.0, 0.0], [1.0, 1.0, 1.0]]), 0.5, 0.25)
    assert line.end == pytest.approx(4.0)
    assert base_path(0.0, np.array([[1.0, 1.0, 0.0]] * 2), 0.5, 0.25).end == 0.0


def test_a_path_goes_through_its_points():
    points = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 1.0], [2.0, 1.0, 1.0]])
    path = ee_path(0.0, points, 1.0)
    np.testing.assert_allclose(path.at(np.array([0.0, 1.0, 3.0])), points)
    np.testing.assert_allclose(path.at(np.array([2.0]))[0], [1.0, 1.0, 1.0])


def test_a_pose_takes_the_near_sign_of_the_quaternion():
    points = np.array([[0, 0, 0, 0, 0, 0, 1.0], [1, 0, 0, 0, 0, 0, -2.0]])
    np.testing.assert_allclose(ee_path(0.0, points, 1.0).at(np.array([0.5]))[0, 3:], [0, 0, 0, 1])


def test_steps_hold_between_their_times():
    wave = steps(np.array([1.0, 2.0, 4.0]), np.array([[1.0], [5.0], [2.0]]))
    times = np.array([0.0, 1.0, 1.999, 2.0, 3.999, 4.0, 9.0])
    np.testing.assert_array_equal(wave.at(times)[:, 0], [1, 1, 1, 5, 5, 2, 2])


def test_a_trajectory_is_a_value():
    values = np.ones((1, 2))
    kept = hold(values[0])
    values[:] = 7.0
    assert kept.goal[0] == 1.0
    with pytest.raises(ValueError, match="read-only"):
        kept.values[0, 0] = 2.0


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Trajectory(np.array([0.0, -1.0]), np.zeros((2, 1))), "times must not decrease"),
        (lambda: Trajectory(np.zeros(2), np.zeros((1, 1))), "shapes"),
        (lambda: Trajectory(np.zeros(1), np.full((1, 1), np.inf)), "finite"),
        (lambda: base_path(0.0, np.zeros((2, 3)), 0.0), "speed and turn must be > 0"),
        (lambda: base_path(0.0, np.zeros((2, 4)), 1.0), "points of shape"),
        (lambda: ee_path(0.0, np.zeros((2, 2)), 1.0), "points of shape"),
    ],
)
def test_what_is_no_trajectory_is_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()
