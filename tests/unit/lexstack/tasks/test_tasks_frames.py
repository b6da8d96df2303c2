"""Tasks on any frame: their rows are derivatives, and what is wrong is refused in one line."""

import math

import numpy as np
import pinocchio as pin
import pytest

from lexstack.errors import ConfigurationError
from lexstack.hqp.curvature import add_curvature
from lexstack.references import Motion, References
from lexstack.robots import Pose
from lexstack.tasks import TASKS, pose_error
from lexstack.tasks.manipulability import log_gradient, log_manipulability
from support.scenario import random_q, state_at, team

H = 1e-6
ELBOW, HAND = "panda_link4", "panda_hand"
DIAGONAL = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]


def make(kind, robot=0, **parameters):
    return TASKS[kind](team(), robot, parameters, "here")


def references(q, frames=None, **motion):
    places = tuple(q[part][:3] for part in team().slices)
    return References(team().tools(q), places, 1, Motion(frames=frames or {}, **motion))


def rows(task, q, wanted):
    return task.linearise(team().kinematics(state_at(q)), wanted)


def slope(task, q, chi, wanted, end="lower"):
    """Return the derivative of what a task asks for, along chi."""
    ahead, behind = (getattr(rows(task, q + s * H * chi, wanted), end) for s in (1, -1))
    return (ahead - behind) / (2.0 * H)


def frame(q, name, robot=0):
    return team().kinematics(state_at(q)).frame(robot, name)


def start(seed):
    rng = np.random.default_rng(seed)
    return random_q(rng), rng.normal(size=team().n), rng


MASK = [True, False, True, False, True, True]
FULL = (np.diag(DIAGONAL) + 0.3 * np.random.default_rng(5).normal(size=(6, 6))).tolist()
CHOICES = [
    ("frame_pose", {"frame": ELBOW}, range(6)),
    ("frame_pose", {"frame": ELBOW, "mask": MASK}, (0, 2, 4, 5)),
    ("frame_pose", {"frame": HAND, "axes": "local", "mask": MASK}, (0, 2, 4, 5)),
    ("frame_pose", {"axes": ELBOW, "mask": MASK}, (0, 2, 4, 5)),
    ("frame_pose", {"frame": HAND, "gain": DIAGONAL, "mask": MASK}, (0, 2, 4, 5)),
    ("frame_pose", {"frame": HAND, "gain": FULL, "axes": "local"}, range(6)),
    ("frame_position", {"frame": ELBOW, "axes": "local", "mask": [True, True, False]}, (0, 1)),
    ("frame_orientation", {"frame": HAND, "mask": [True, True, False]}, (3, 4)),
    ("frame_orientation", {"axes": "local", "gain": [1.0, 2.0, 3.0]}, (3, 4, 5)),
]


def gain_matrix(kind, parameters, kept):
    gain = parameters.get("gain", 3.0)
    if not isinstance(gain, list):
        return gain * np.eye(len(kept))
    full = np.array(gain)
    full = np.diag(full) if full.ndim == 1 else full
    first = 3 if kind == "frame_orientation" else 0
    places = [row - first for row in kept]
    return full[np.ix_(places, places)]


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(("kind", "parameters", "kept"), CHOICES)
def test_the_rows_of_a_frame_are_the_derivative_of_its_error(kind, parameters, kept, seed):
    q, chi, _ = start(seed)
    name = parameters.get("frame", "tool")
    wanted = references(q, {(0, name): frame(q, name)[0]})
    task = make(kind, **parameters)
    now = rows(task, q, wanted)
    assert now.matrix.shape == (len(kept), team().n)
    np.testing.assert_array_equal(now.lower, now.upper)
    np.testing.assert_allclose(now.lower, 0.0, atol=1e-7)
    expected = -gain_matrix(kind, parameters, list(kept)) @ now.matrix @ chi
    np.testing.assert_allclose(slope(task, q, chi, wanted), expected, atol=1e-5)


@pytest.mark.parametrize(
    ("new", "old"), [("frame_pose", "ee_pose"), ("frame_position", "ee_position")]
)
def test_by_default_they_are_the_tasks_of_the_tool_bit_for_bit(new, old):
    q, _, rng = start(1)
    twist = rng.normal(size=6)
    for motion in ({}, {"twists": {(0, "tool"): twist}}):
        wanted = references(random_q(rng), **motion)
        one, other = rows(make(new), q, wanted), rows(make(old), q, wanted)
        np.testing.assert_array_equal(one.matrix, other.matrix)
        np.testing.assert_array_equal(one.lower, other.lower)
        assert one.frame is None
        assert (one.curve.gain, one.curve.limits) == (other.curve.gain, other.curve.limits)


def test_the_feed_forward_is_added_after_the_saturation_and_is_no_error():
    q, _, rng = start(2)
    goal, twist = Pose(rng.normal(size=3), pin.exp3(rng.normal(size=3))), rng.normal(size=6)
    still = references(q, {(0, ELBOW): goal})
    moving = references(q, {(0, ELBOW): goal}, twists={(0, ELBOW): twist})
    task = make("frame_pose", frame=ELBOW)
    one, other = rows(task, q, still), rows(task, q, moving)
    np.testing.assert_allclose(other.lower - one.lower, twist, atol=1e-12)
    np.testing.assert_allclose(other.correction, one.lower, atol=1e-12)


def test_a_frame_without_a_target_is_asked_to_rest():
    q, _, _ = start(3)
    assert not rows(make("frame_pose", frame=ELBOW), q, references(q)).lower.any()


CURVED = [
    {"frame": ELBOW},
    {"frame": ELBOW, "mask": [True, False, True, True, True, True]},
    {"frame": HAND, "axes": "local"},
    {"mask": [False, False, True, True, True, True]},
]


@pytest.mark.parametrize("parameters", CURVED)
def test_the_curvature_of_a_frame_is_that_of_half_of_its_squared_error(parameters):
    """B(e) = d2(|e|^2 / 2)/dq2 - J^T J near zero error, up to terms of second order in e."""
    q, chi, rng = start(4)
    name = parameters.get("frame", "tool")
    pose = frame(q, name)[0]
    away = 1e-3 * rng.normal(size=6)
    goal = Pose(pose.position + away[:3], pin.exp3(away[3:]) @ pose.rotation)
    wanted = references(q, {(0, name): goal})
    chi[10:] = 0.0
    chi /= np.linalg.norm(chi)
    task = make("frame_pose", **parameters)

    def squared(s):
        linear = rows(task, q + s * chi, wanted)
        axes = np.eye(6) if linear.frame is None else linear.frame.axes
        error = axes @ pose_error(frame(q + s * chi, name)[0], goal)
        return 0.5 * float(error @ error)

    h = 1e-3
    second = (squared(h) - 2.0 * squared(0.0) + squared(-h)) / h**2
    now = rows(task, q, wanted)
    error = now.frame.axes @ pose_error(pose, goal) if now.frame else pose_error(pose, goal)
    bent = np.zeros((10, 10))
    kinematics = team().kinematics(state_at(q))
    add_curvature(bent, now, error, kinematics, {0: slice(0, 10)})
    moved = now.matrix @ chi
    assert abs(chi[:10] @ bent @ chi[:10]) > 1e-5
    assert second - moved @ moved == pytest.approx(chi[:10] @ bent @ chi[:10], abs=2e-5)


@pytest.mark.parametrize("seed", range(5))
def test_the_rows_of_axis_tasks_are_the_derivative_of_their_error(seed):
    q, chi, rng = start(seed)
    axis = rng.normal(size=3).tolist()
    pose, _ = frame(q, HAND)
    along = pose.rotation @ np.array(axis)
    point = pose.position + 0.8 * along / np.linalg.norm(along)
    aligned = make("axis_alignment", frame=HAND, axis=axis, direction=along.tolist(), gain=2.0)
    looking = make("look_at", frame=HAND, axis=axis, point=point.tolist(), gain=2.0)
    for task in (aligned, looking):
        now = rows(task, q, references(q))
        np.testing.assert_allclose(now.lower, 0.0, atol=1e-7)
        found = slope(task, q, chi, references(q))
        np.testing.assert_allclose(found, -2.0 * now.matrix @ chi, atol=1e-5)


def test_an_axis_turns_into_its_direction_also_from_the_opposite_one():
    q, _, _ = start(0)
    axis = frame(q, HAND)[0].rotation[:, 2]
    for direction in (-axis, [0.0, 1.0, 0.0]):
        task = make("axis_alignment", frame=HAND, direction=list(direction), max_angular=1e6)
        now = rows(task, q, references(q))
        turn = now.frame.axes[:, 3:].T @ now.lower
        angle = math.acos(np.clip(axis @ np.array(direction), -1.0, 1.0))
        assert np.linalg.norm(turn) == pytest.approx(3.0 * angle, rel=1e-6)
        moved = pin.exp3(1e-4 * turn) @ axis
        assert moved @ np.array(direction) > axis @ np.array(direction)


@pytest.mark.parametrize("seed", range(5))
def test_the_rows_of_centre_of_mass_and_joint_coupling_are_derivatives(seed):
    q, chi, _ = start(seed)
    model = team().robots[0]
    centre, _ = model.centre_of_mass(q[:10])
    task = make("centre_of_mass", target=centre.tolist(), mask=[True, True, True], gain=2.0)
    found = slope(task, q, chi, references(q))
    np.testing.assert_allclose(found, -2.0 * rows(task, q, None).matrix @ chi, atol=1e-5)
    masses = np.array([inertia.mass for inertia in model.pinocchio.inertias])
    data = model.pinocchio.createData()
    pin.forwardKinematics(model.pinocchio, data, q[:10])
    places = [data.oMi[i].act(y.lever) for i, y in enumerate(model.pinocchio.inertias)]
    np.testing.assert_allclose(centre, masses @ np.array(places) / masses.sum(), atol=1e-9)
    joints = {"panda_joint1": 1.0, "panda_joint3": -0.5}
    coupling = make("joint_coupling", joints=joints, value=0.3, gain=2.0)
    now = rows(coupling, q, references(q))
    assert now.lower[0] == pytest.approx(2.0 * (0.3 - q[3] + 0.5 * q[5]))
    found = slope(coupling, q, chi, references(q))
    np.testing.assert_allclose(found, -2.0 * now.matrix @ chi, atol=1e-5)


@pytest.mark.parametrize("part", [slice(0, 3), slice(3, 6), slice(0, 6)])
@pytest.mark.parametrize("seed", range(3))
def test_the_gradient_of_the_manipulability_is_its_derivative(part, seed):
    q, _, rng = start(seed)
    step = np.zeros(team().n)
    step[3:10] = rng.normal(size=7)
    ahead, behind = (
        log_manipulability(frame(q + s * H * step, HAND)[1][:, 3:], part) for s in (1, -1)
    )
    gradient = log_gradient(frame(q, HAND)[1][:, 3:], part)
    assert gradient @ step[3:10] == pytest.approx((ahead - behind) / (2.0 * H), abs=1e-5)


def test_manipulability_rises_where_nothing_else_is_asked():
    q, _, _ = start(1)
    task, before = make("manipulability"), frame(q, "tool")[1]
    for _ in range(50):
        linear = rows(task, q, references(q))
        q = q + 0.01 * linear.matrix.T @ linear.lower
    after = frame(q, "tool")[1]
    part = slice(0, 6)
    assert log_manipulability(after[:, 3:], part) > log_manipulability(before[:, 3:], part) + 0.01


@pytest.mark.parametrize("seed", range(5))
def test_the_rows_of_half_space_and_cone_are_the_derivatives_of_their_rooms(seed):
    q, chi, rng = start(seed)
    normal = rng.normal(size=3)
    row = rows(make("half_space", normal=normal.tolist(), frame=HAND), q, None).matrix @ chi

    def height(s):
        return normal @ frame(q + s * H * chi, HAND)[0].position / np.linalg.norm(normal)

    assert row[0] == pytest.approx((height(1) - height(-1)) / (2.0 * H), abs=1e-6)
    cone = rows(make("cone", angle=0.5, direction=normal.tolist(), frame=HAND), q, None)

    def angle(s):
        axis = frame(q + s * H * chi, HAND)[0].rotation[:, 2]
        return math.acos(axis @ normal / np.linalg.norm(normal))

    expected = (angle(1) - angle(-1)) / (2.0 * H)
    assert (cone.matrix @ chi)[0] == pytest.approx(expected, abs=1e-6)
    assert (cone.upper[0] < 0.0) == (angle(0) > 0.5), "beyond the edge it leads back"
    assert cone.lower[0] == -np.inf


def test_a_half_space_is_kept_by_whoever_goes_as_fast_towards_it_as_it_allows():
    """The room shrinks to zero and never below, with the deceleration that was asked for."""
    q = np.zeros(team().n)
    q[3:10] = team().robots[0].posture
    height = frame(q, "tool")[0].position[2]
    task = make("half_space", normal=[0.0, 0.0, 1.0], offset=height - 0.1, deceleration=0.5)
    speeds, rooms = [], []
    for _ in range(300):
        linear = rows(task, q, None)
        speeds.append(-linear.lower[0])
        rooms.append(frame(q, "tool")[0].position[2] - (height - 0.1))
        q = q - 0.01 * np.linalg.pinv(linear.matrix)[:, 0] * speeds[-1]
    assert min(rooms) > -1e-4
    assert rooms[-1] < 1e-3
    assert np.diff(speeds).min() > -0.5 * 0.01 - 1e-4


def test_a_velocity_limit_has_a_row_for_each_axis_with_a_limit():
    q, chi, _ = start(0)
    task = make(
        "frame_velocity_limit",
        frame=HAND,
        axes="local",
        linear=[0.1, math.inf, 0.3],
        angular=[math.inf, 1.0, math.inf],
    )
    linear = rows(task, q, None)
    pose, jacobian = frame(q, HAND)
    velocity = np.concatenate(np.split(jacobian @ chi[:10], 2))
    local = np.concatenate((pose.rotation.T @ velocity[:3], pose.rotation.T @ velocity[3:]))
    np.testing.assert_allclose(linear.matrix @ chi, local[[0, 2, 4]], atol=1e-12)
    np.testing.assert_array_equal(linear.upper, [0.1, 0.3, 1.0])
    np.testing.assert_array_equal(linear.lower, [-0.1, -0.3, -1.0])


def test_a_posture_of_some_joints_has_their_rows_times_the_roots_of_their_weights():
    q, _, _ = start(0)
    whole = rows(make("posture", gain=2.0), q, references(q))
    some = make("posture", gain=2.0, joints=["panda_joint4", "panda_joint2"], weights=[4.0, 9.0])
    now = rows(some, q, references(q))
    np.testing.assert_allclose(now.matrix, whole.matrix[[3, 1]] * np.array([[2.0], [3.0]]))
    np.testing.assert_allclose(now.lower, whole.lower[[3, 1]] * np.array([2.0, 3.0]))
    arm, rate = np.arange(7.0), np.arange(7.0) + 1.0
    moving = references(q, postures={0: arm}, posture_rates={0: rate})
    expected = 2.0 * (arm - q[3:10]) + rate
    np.testing.assert_allclose(rows(make("posture", gain=2.0), q, moving).lower, expected)
    found = rows(some, q, moving)
    np.testing.assert_allclose(found.lower, expected[[3, 1]] * np.array([2.0, 3.0]))


def test_the_frames_of_a_tick_are_worked_out_once():
    kinematics = team().kinematics(state_at(start(0)[0]))
    assert kinematics.frame(0, ELBOW) is kinematics.frame(0, ELBOW)
    assert kinematics.frame(1, "tool") == (kinematics.tools[1], kinematics.jacobians[1])


NAN3 = [math.inf, 0.0, 0.0]
WRONG = [
    ("frame_pose", {"frame": "wing"}, r"frame: .*no frame 'wing'; there is: base, "),
    ("frame_pose", {"axes": "wing"}, r"axes: .*no frame 'wing'"),
    ("frame_pose", {"mask": [False] * 6}, "mask: it leaves no axis"),
    ("frame_pose", {"mask": [True] * 3}, "mask: expected 6 values, got 3"),
    ("frame_pose", {"gain": [1.0, 2.0]}, "gain: expected a number, 6 numbers, or 6 rows of 6"),
    ("frame_pose", {"gain": [[1.0, 2.0], [1.0]]}, "gain: expected a number, 6 numbers, or"),
    ("frame_pose", {"gain": [1.0] * 5 + [0.0]}, "gain: must be finite and > 0"),
    ("frame_pose", {"gain": (-np.eye(6)).tolist()}, "gain: must be a positive definite matrix"),
    ("frame_pose", {"max_linear": -1.0}, "max_linear: must be finite and > 0, got -1.0"),
    ("frame_position", {"max_linear": 0.0}, "max_linear: must be finite and > 0, got 0.0"),
    ("frame_position", {"gain": [1.0] * 6}, "gain: expected a number, 3 numbers, or 3 rows of 3"),
    ("frame_orientation", {"max_angular": 0.0}, "max_angular: must be finite and > 0, got 0.0"),
    ("axis_alignment", {"axis": [0.0, 0.0, 0.0]}, r"axis: must not be zero, got \(0.0, 0.0, 0.0\)"),
    ("axis_alignment", {"direction": NAN3}, r"direction\[0\]: must be finite, got inf"),
    ("axis_alignment", {"frame": "wing"}, "frame: .*no frame 'wing'"),
    ("look_at", {}, "key 'point' is missing"),
    ("look_at", {"point": NAN3}, r"point\[0\]: must be finite, got inf"),
    ("look_at", {"point": [1.0, 0, 0], "nearest": 0.0}, "nearest: must be finite and > 0"),
    ("centre_of_mass", {}, "key 'target' is missing"),
    ("centre_of_mass", {"target": [0.0] * 3, "mask": [False] * 3}, "mask: it leaves no axis"),
    ("joint_coupling", {"joints": {"knee": 1.0}}, "joints: unknown joint 'knee'; known: base_x"),
    ("joint_coupling", {"joints": {"panda_joint1": 0.0}}, "joints: no joint has a coefficient"),
    ("joint_coupling", {"joints": {"panda_joint1": math.inf}}, "joints.panda_joint1: must be fin"),
    ("manipulability", {"rows": "all"}, "rows: 'all' is not one of: position, orientation, pose"),
    ("manipulability", {"max_speed": 0.0}, "max_speed: must be finite and > 0, got 0.0"),
    (
        "frame_velocity_limit",
        {"linear": [0.0, 1.0, 1.0]},
        r"linear\[0\]: must be finite and > 0, got 0",
    ),
    ("frame_velocity_limit", {"linear": [math.inf] * 3}, "linear: no limit is given, nor in ang"),
    ("half_space", {}, "key 'normal' is missing"),
    ("half_space", {"normal": [0.0] * 3}, "normal: must not be zero"),
    ("half_space", {"normal": [0, 0, 1.0], "gain": 101.0}, "gain: must be <= 100 1/s, one over"),
    ("half_space", {"normal": [0, 0, 1.0], "margin": -1.0}, "margin: must be finite and >= 0"),
    ("cone", {"angle": 4.0}, r"angle: must be in \(0, 3.14159\), got 4.0"),
    ("cone", {"angle": 0.5, "deceleration": 0.0}, "deceleration: must be finite and > 0, got 0.0"),
    ("posture", {"joints": ["knee"]}, "joints: 'knee': unknown; known: panda_joint1, "),
    ("posture", {"joints": ["panda_joint1"] * 2}, "joints: 'panda_joint1': stands in it twice"),
    ("posture", {"weights": [1.0]}, "weights: expected 7 values, got 1"),
    ("posture", {"weights": [0.0] * 7}, r"weights\[0\]: must be finite and > 0, got 0.0"),
]


@pytest.mark.parametrize(("kind", "parameters", "text"), WRONG)
def test_a_wrong_parameter_is_refused_in_one_line_with_its_key(kind, parameters, text):
    with pytest.raises(ConfigurationError, match=f"^here: {text}") as error:
        make(kind, **parameters)
    assert "\n" not in str(error.value)
