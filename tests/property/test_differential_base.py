"""A robot on a differential base against finite differences along its own motion."""

import math

import numpy as np
import pytest

import lexstack
from lexstack.hqp.curvature import add_curvature
from lexstack.options import build
from lexstack.references import measured
from lexstack.robots import RobotFile, arc
from lexstack.robots.team import NO_POSITION
from lexstack.tasks import TASKS
from lexstack.tasks.feed_forward import feed_forward
from lexstack_config.resolved import load_robot
from support.differential import DT, driven, random_q
from support.scenario import CONFIG

NAMES = ("ur10", "tiago", "pr2", "panda_summit")
STEP = 1e-5


@pytest.fixture(scope="module", params=NAMES)
def robot(request):
    return driven(request.param)


def along(robot, q, function):
    """Return the derivative of a function of q along each entry of chi, columns of a matrix."""
    columns = [
        (function(robot.integrate(q, chi, STEP)) - function(robot.integrate(q, chi, -STEP)))
        / (2.0 * STEP)
        for chi in np.eye(robot.n)
    ]
    return np.array(columns).T


def test_q_is_longer_than_chi_by_one_and_both_have_names(robot):
    assert robot.nq == robot.n + 1
    assert robot.joints[:2] == ("base_v", "base_w")
    assert robot.coordinates[:3] == ("base_x", "base_y", "base_yaw")
    assert robot.joints[robot.arm] == robot.coordinates[robot.arm_q] == robot.config.arm.joints
    assert robot.prismatic[:2] == (True, False)
    assert robot.prismatic[2:] == robot.sliding[3:]
    np.testing.assert_array_equal(robot.base_pose(robot.home((1.0, 2.0, 3.0))), [1.0, 2.0, 3.0])
    np.testing.assert_array_equal(robot.limits.velocity[:2], robot.config.base.velocity)
    assert np.isinf(robot.limits.position_upper[:2]).all()


def test_positions_are_those_of_the_commanded_velocities_integrated_exactly():
    rng = np.random.default_rng(1)
    for _ in range(50):
        pose, (v, w, time) = rng.uniform(-2.0, 2.0, 3), rng.uniform(-2.0, 2.0, 3)
        x, y, yaw = pose
        n = 20000  # midpoints: third order in the step
        turns = yaw + w * time * (np.arange(n) + 0.5) / n
        expected = [x + v * time * np.cos(turns).mean(), y + v * time * np.sin(turns).mean()]
        np.testing.assert_allclose(arc(pose, v, w, time), [*expected, yaw + w * time], atol=1e-8)


@pytest.mark.parametrize("w", [0.0, 1e-300, 1e-12, -1e-8, 1e-4])
def test_a_turn_that_vanishes_divides_nothing_by_it(w):
    x, y, yaw = arc(np.array([0.1, 0.2, 0.3]), 0.7, w, 0.5)
    np.testing.assert_allclose(
        [x, y, yaw],
        [
            0.1 + 0.35 * math.cos(0.3 + 0.25 * w),
            0.2 + 0.35 * math.sin(0.3 + 0.25 * w),
            0.3 + 0.5 * w,
        ],
        atol=1e-9,
    )


def test_jacobians_are_the_derivatives_along_chi(robot):
    rng = np.random.default_rng(2)
    for _ in range(20):
        q = random_q(robot, rng)
        for name in ("tool", "base", robot.config.tool.parent):
            frame = robot.frame(name)
            pose, jacobian = robot.at(q, frame)
            assert jacobian.shape == (6, robot.n)
            linear = along(robot, q, lambda x, frame=frame: robot.at(x, frame)[0].position)
            np.testing.assert_allclose(jacobian[:3], linear, atol=1e-7)
            turns = along(robot, q, lambda x, frame=frame: robot.at(x, frame)[0].rotation.ravel())
            for w, turn in zip(jacobian[3:].T, turns.T, strict=True):
                np.testing.assert_allclose(
                    turn.reshape(3, 3), np.cross(w, pose.rotation, axisb=0, axisc=0), atol=1e-7
                )
        centre, slope = robot.centre_of_mass(q)
        found = along(robot, q, lambda x: robot.centre_of_mass(x)[0])
        np.testing.assert_allclose(slope, found, atol=1e-7)
        assert centre.shape == (3,)


def test_the_rate_matrix_and_the_mass_matrix_are_those_of_chi(robot):
    rng, holonomic = (
        np.random.default_rng(3),
        lexstack.BaseConfig(chassis_mass=robot.config.base.chassis_mass),
    )
    config = lexstack.RobotConfig(
        "same", holonomic, robot.config.arm, robot.config.tool, robot.config.spheres
    )
    other = lexstack.RobotModel("same", config)
    q = random_q(robot, rng)
    rates = robot.rate_matrix(q)
    np.testing.assert_allclose(rates, along(robot, q, lambda x: x), atol=1e-9)
    np.testing.assert_allclose(
        robot.mass_matrix(q), rates.T @ other.mass_matrix(q) @ rates, rtol=1e-12, atol=1e-12
    )
    np.testing.assert_array_equal(other.rate_matrix(q), np.eye(other.n))


@pytest.fixture(scope="module")
def mixed():
    """Return a team of two differential robots, one of which mimics, around a holonomic one."""
    ridgeback = load_robot(CONFIG / "robots" / "ur10_ridgeback.yaml")
    robots = (
        driven("panda_summit", place="left"),
        lexstack.RobotModel("middle", ridgeback),
        driven("pr2", place="right"),
    )
    return lexstack.Team(robots, DT)


def of_team(team, rng):
    """Return a random configuration of a team."""
    return np.concatenate([random_q(robot, rng) for robot in team.robots])


def test_a_mixed_team_keeps_q_and_chi_apart(mixed):
    assert (mixed.n, mixed.nq) == (9 + 9 + 19, 10 + 9 + 20)
    q, chi = of_team(mixed, np.random.default_rng(4)), np.arange(float(mixed.n))
    moved = mixed.integrate(q, chi, DT)
    for robot, at, part in zip(mixed.robots, mixed.q_slices, mixed.slices, strict=True):
        np.testing.assert_array_equal(moved[at], robot.integrate(q[at], chi[part], DT))
    places = mixed.joint_positions(q)
    for robot, at, part in zip(mixed.robots, mixed.q_slices, mixed.slices, strict=True):
        np.testing.assert_array_equal(places[part][robot.arm], q[at][robot.arm_q])
        if robot.differential:
            assert (places[part][:2] == NO_POSITION).all()
        else:
            np.testing.assert_array_equal(places[part], q[at])
    state = mixed.after(mixed.at_rest(q), chi)
    assert state.q.shape == state.q_star.shape == (mixed.nq,)
    assert state.v.shape == state.command.shape == (mixed.n,)
    np.testing.assert_array_equal(state.q_star, moved)
    with pytest.raises(lexstack.InputError, match=r"Team\.after"):
        mixed.at_rest(q).after(chi, DT)


def test_the_rows_of_spheres_are_the_derivative_of_their_centers(mixed):
    rng = np.random.default_rng(5)
    for _ in range(5):
        q = of_team(mixed, rng)
        spheres = mixed.spheres(q)
        count = len(spheres.radii)
        chi = rng.uniform(-1.0, 1.0, mixed.n)
        ahead, behind = (
            mixed.spheres(mixed.integrate(q, chi, step)).centers for step in (STEP, -STEP)
        )
        rate = (ahead - behind) / (2.0 * STEP)
        directions = rng.normal(size=(count, 3))
        rows = mixed.spheres(q).rows(np.arange(count), directions)
        assert rows.shape == (count, mixed.n)
        np.testing.assert_allclose(rows @ chi, (rate * directions).sum(axis=1), atol=1e-7)
    for robot in mixed.robots:
        assert robot.spheres.moved_by.shape == (len(robot.spheres.radii), robot.n)


def test_drift_and_curvature_are_the_second_derivatives_along_chi(robot):
    team, rng = lexstack.Team((robot,), DT), np.random.default_rng(6)
    frame = robot.config.tool.parent
    for kind, parameters in (
        ("ee_pose", {}),
        ("ee_position", {}),
        ("frame_pose", {"frame": frame, "axes": "local"}),
        ("axis_alignment", {"frame": frame}),
    ):
        task = TASKS[kind](team, 0, parameters, "test")
        for _ in range(5):
            q, chi = random_q(robot, rng), rng.normal(size=robot.n)
            kinematics = team.kinematics(lexstack.RobotState.at_rest(q, team.n))
            now = task.linearise(kinematics, measured(team, q))
            weights = rng.normal(size=now.lower.size)
            bent = np.zeros((team.n, team.n))
            add_curvature(bent, now, weights, kinematics, {0: slice(0, team.n)})
            np.testing.assert_allclose(bent, bent.T, atol=1e-12)
            place = robot.frame("tool" if now.frame is None else frame)
            ahead, behind = (
                robot.at(robot.integrate(q, chi, step), place)[1] for step in (STEP, -STEP)
            )
            change = (ahead - behind) @ chi / (2.0 * STEP)  # (d J / dt) chi
            moving = team.kinematics(lexstack.RobotState(0, 0.0, q, chi, q, chi))
            name = "tool" if now.frame is None else frame
            found = -2.0 / team.dt * feed_forward(np.zeros(6), moving, team, 0, name)
            np.testing.assert_allclose(found, change, atol=1e-6)
            axes = np.eye(6)[: now.lower.size] if now.frame is None else now.frame.axes
            expected = -weights @ axes @ change
            np.testing.assert_allclose(chi @ bent @ chi, expected, atol=1e-6)


def test_centre_of_mass_bends_as_its_rows_turn_along_chi(robot):
    team, rng = lexstack.Team((robot,), DT), np.random.default_rng(7)
    parameters = {"target": [0.3, 0.2, 0.8], "mask": [True, True, True]}
    task = TASKS["centre_of_mass"](team, 0, parameters, "test")
    for _ in range(5):
        q, chi = random_q(robot, rng), rng.normal(size=robot.n)
        goals = measured(team, q)

        def rows(there, goals=goals):
            return task.linearise(team.kinematics(team.at_rest(there)), goals)

        ahead, behind = (rows(robot.integrate(q, chi, step)).matrix for step in (STEP, -STEP))
        weights, bent = rng.normal(size=3), np.zeros((team.n, team.n))
        add_curvature(bent, rows(q), weights, team.kinematics(team.at_rest(q)), {0: team.slices[0]})
        change = (ahead - behind) @ chi / (2.0 * STEP)
        np.testing.assert_allclose(chi @ bent @ chi, -weights @ change, atol=1e-6)


def test_the_second_of_two_robots_that_drive_bends_the_pose_between_them(mixed):
    team, rng = mixed, np.random.default_rng(8)
    task = TASKS["relative_pose"](team, 0, {"other": "right"}, "test")
    for _ in range(5):
        q, chi = of_team(team, rng), np.zeros(team.n)
        chi[team.slices[2]] = rng.normal(size=team.robots[2].n)
        goals = measured(team, q)

        def rows(there, goals=goals):
            return task.linearise(team.kinematics(team.at_rest(there)), goals)

        weights, bent = np.append(rng.normal(size=3), np.zeros(3)), np.zeros((team.n, team.n))
        kinematics = team.kinematics(team.at_rest(q))
        add_curvature(bent, rows(q), weights, kinematics, dict(enumerate(team.slices)))
        ahead, behind = (rows(team.integrate(q, chi, step)).matrix for step in (STEP, -STEP))
        change = (ahead - behind) @ chi / (2.0 * STEP)
        np.testing.assert_allclose(chi @ bent @ chi, -weights @ change, atol=1e-6)


def test_wrong_bases_are_refused_in_one_line():
    arm = {"description": "ur_description/urdf/ur10_robot.urdf"}
    for base, expected in (
        ({"type": "differential", "velocity": [1.0, 1.0, 2.0]}, "velocity: expected 2 values"),
        ({"velocity": [1.0, 2.0]}, "velocity: expected 3 values, got 2"),
        ({"type": "differential", "jerk": [1.0, -2.0]}, "jerk"),
        ({"type": "legs"}, "type: 'legs' is not one of: holonomic, differential"),
        ({"type": "differential", "turn": 1.0}, "unknown key 'turn'"),
    ):
        with pytest.raises(lexstack.ConfigurationError) as caught:
            build(RobotFile, {"name": "x", "arm": arm, "base": base}, "x.yaml")
        assert str(caught.value).startswith("x.yaml: base: ")
        assert expected in str(caught.value)
        assert "\n" not in str(caught.value)


def test_what_asks_for_the_position_of_a_velocity_is_refused(robot):
    team = lexstack.Team((robot,), DT)
    with pytest.raises(lexstack.ConfigurationError, match="base_v is a velocity of a differential"):
        TASKS["joint_coupling"](team, 0, {"joints": {"base_v": 1.0}}, "test")
    stack = {
        "name": "s",
        "description": "",
        "levels": [{"tasks": [{"type": "velocity_damping"}]}],
        "limits": {"robot": {"base_w": {"position": [-1.0, 1.0]}}},
    }
    with pytest.raises(lexstack.ConfigurationError, match="base_w: position: a velocity of a dif"):
        lexstack.build_stack(build(lexstack.StackConfig, stack, "s"), team)
    stack["limits"] = {"robot": {"base_w": {"velocity": 0.3}}}
    built = lexstack.build_stack(build(lexstack.StackConfig, stack, "s"), team)
    assert built.limits.velocity[1] == 0.3
