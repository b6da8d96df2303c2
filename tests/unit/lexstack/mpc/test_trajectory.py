"""Reference trajectories: speed, the short way of angles, jumps, and what is refused."""

import numpy as np
import pytest

from lexstack.errors import InputError
from lexstack.mpc import (
    Trajectory,
    base_path,
    drive_path,
    ee_path,
    hold,
    joint_path,
    orientation_path,
    steps,
)
from lexstack.robots import to_quaternion
from lexstack.robots.spatial import from_quaternions, log3_all


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


def turned(angle, axis=(0.0, 0.6, 0.8), sign=1.0):
    """Return a pose at the origin, turned by an angle [rad], its quaternion with a sign."""
    quaternion = sign * np.array([*(np.sin(0.5 * angle) * np.array(axis)), np.cos(0.5 * angle)])
    return np.concatenate((np.zeros(3), quaternion))


def turning(path, times):
    """Return the angular velocities of a path in its own axes between times, shape (k, 3)."""
    rotations = from_quaternions(path.at(times)[:, 3:])
    between = rotations[:-1].transpose(0, 2, 1) @ rotations[1:]
    return log3_all(between) / np.diff(times)[:, None]


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("degrees", [1e-3, 0.01, 30.0, 90.0, 150.0, 179.9, 180.0])
def test_a_path_never_turns_faster_than_its_limit_and_always_at_one_speed(degrees, sign):
    """Components of quaternions in proportion to time exceed it by 41 % at 180 degrees."""
    angle = np.deg2rad(degrees)
    path = ee_path(1.0, np.array([turned(0.0), turned(angle, sign=sign)]), 1.0, 0.5)
    assert path.end - 1.0 == pytest.approx(angle / 0.5, rel=1e-9)
    speeds = np.linalg.norm(turning(path, np.linspace(1.0, path.end, 401)), axis=1)
    np.testing.assert_allclose(speeds, 0.5, rtol=1e-6)


def test_a_turn_that_takes_as_long_as_its_line_has_one_axis_and_one_speed():
    rng = np.random.default_rng(0)
    for _ in range(50):
        first, second = rng.normal(size=(2, 7))
        path = ee_path(0.0, np.array([first, second]), 0.2)
        rates = turning(path, np.linspace(0.0, path.end, 51))
        np.testing.assert_allclose(rates, np.broadcast_to(rates[0], rates.shape), atol=1e-9)
        assert np.linalg.norm(rates[0]) * path.end <= np.pi + 1e-9, "the short way round"
        start, end = from_quaternions(path.at(np.array([0.0, path.end]))[:, 3:])
        np.testing.assert_allclose(
            [to_quaternion(start), to_quaternion(end)],
            [to_quaternion(each) for each in from_quaternions(np.array([first, second])[:, 3:])],
            atol=1e-9,
        )


def test_a_trajectory_of_poses_turns_the_short_way_though_the_signs_differ():
    poses = Trajectory(np.array([0.0, 1.0]), np.array([turned(0.0), turned(1.0, sign=-1.0)]))
    speeds = np.linalg.norm(turning(poses, np.linspace(0.0, 1.0, 11)), axis=1)
    np.testing.assert_allclose(speeds, 1.0, rtol=1e-9)


def test_a_pose_that_does_not_turn_keeps_its_quaternion_to_the_bit():
    pose = np.array([0.0, 0.0, 0.0, 0.3, -0.2, 0.7, 0.4])
    line = Trajectory(np.array([0.0, 1.0]), np.array([pose, [1.0, *pose[1:]]]))
    values = line.at(np.linspace(-1.0, 2.0, 31))
    np.testing.assert_array_equal(values[:, 3:], np.broadcast_to(pose[3:], (31, 4)))


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


def test_a_differential_base_turns_drives_and_turns():
    path = drive_path(1.0, np.zeros(3), np.array([[0.0, 1.0, np.pi]]), 0.5, 1.0)
    np.testing.assert_allclose(path.times, [1.0, 1.0 + np.pi / 2, 3.0 + np.pi / 2, 3.0 + np.pi])
    wanted = [[0, 0, 0], [0, 0, np.pi / 2], [0, 1, np.pi / 2], [0, 1, np.pi]]
    np.testing.assert_allclose(path.values, wanted, atol=1e-12)


def test_it_drives_backwards_to_what_is_behind_it():
    path = drive_path(0.0, np.zeros(3), np.array([[-1.0, 0.0, 0.0]]), 0.5, 1.0)
    np.testing.assert_allclose(path.values[:, 2], 0.0, atol=1e-12)
    assert path.end == pytest.approx(2.0)


def test_positions_have_no_yaw_at_their_end_and_one_that_is_reached_takes_no_time():
    path = drive_path(0.0, np.zeros(3), np.array([[0.0, 1.0], [1.0, 1.0]]), 0.5, 1.0)
    assert path.values.shape[1] == 2
    assert path.end == pytest.approx(4.0 + np.pi)
    here = drive_path(2.0, np.zeros(3), np.zeros((1, 2)), 0.5, 1.0)
    assert here.end == 2.0
    np.testing.assert_array_equal(here.goal, np.zeros(2))


def test_joints_arrive_together_and_no_one_is_too_fast():
    points = np.array([[0.0, 0.0], [0.2, 0.3], [0.2, -0.3]])
    path = joint_path(0.0, points, np.array([True, False]), 0.1, 0.2)
    np.testing.assert_allclose(path.times, [0.0, 2.0, 5.0])
    np.testing.assert_allclose(path.at(np.array([1.0]))[0], [0.1, 0.15])


def test_seven_joints_are_no_pose_and_four_no_orientation():
    for count in (7, 4):
        points = np.zeros((2, count))
        points[1] = 1.0
        path = joint_path(0.0, points, np.zeros(count, dtype=bool), 1.0, 1.0)
        np.testing.assert_allclose(path.at(np.array([0.5]))[0], 0.5)
        assert hold(points[1], joints=True).at(np.array([0.0]))[0].tolist() == [1.0] * count


def test_an_orientation_turns_about_one_axis_at_its_speed():
    points = np.array([turned(0.0)[3:], turned(1.0, sign=-1.0)[3:]])
    path = orientation_path(0.0, points, 0.5)
    angle = 2.0 * np.arccos(abs(points[0] @ points[1]))
    assert path.end == pytest.approx(angle / 0.5)
    half = path.at(np.array([0.5 * path.end]))[0]
    assert 2.0 * np.arccos(abs(half @ path.values[0])) == pytest.approx(0.5 * angle)
