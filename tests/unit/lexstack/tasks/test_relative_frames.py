"""Relative pose of any two frames: of one robot with two arms, or of two robots."""

from functools import cache

import numpy as np
import pinocchio as pin
import pytest

from lexstack.hqp.curvature import add_curvature
from lexstack.references import Motion, References
from lexstack.robots import Pose, RobotModel, Team, to_quaternion
from lexstack.tasks import TASKS, other_end, pose_error
from lexstack_config.resolved import load_robot
from support.scenario import CONFIG, state_at

H = 1e-6
MASK = [True, False, True, False, True, True]
GAINS = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
TWO_ARMS = {"frame": "left_gripper", "other_frame": "right_gripper"}
TORSO = {"frame": "torso", "other_frame": "right_gripper"}  # all that moves a moves b too
TWO_ROBOTS = {"frame": "left_wrist", "other": "panda", "other_frame": "panda_link6"}
CASES = [
    TWO_ARMS,
    TWO_ARMS | {"mask": MASK},
    TWO_ARMS | {"mask": MASK, "gain": GAINS},
    TORSO,
    TWO_ROBOTS,
    TWO_ROBOTS | {"mask": MASK},
]
PART = [True, False, True, True, True, True]  # how a part of a rotation bends is left out
CURVED = [TWO_ARMS, TORSO, TWO_ROBOTS, TWO_ARMS | {"mask": PART}, TWO_ROBOTS | {"mask": PART}]
CURVED += [TWO_ARMS | {"mask": PART, "gain": GAINS}]
LOCAL = [TWO_ARMS | {"axes": "local"}, TWO_ROBOTS | {"axes": "left_lower_elbow", "mask": MASK}]


@cache
def team():
    """Return a robot with two arms, and one with another."""
    names = ("baxter", "panda")
    return Team(
        tuple(RobotModel(name, load_robot(CONFIG / f"robots/{name}.yaml")) for name in names), 0.01
    )


def make(**parameters):
    return TASKS["relative_pose"](team(), 0, {"max_linear": 1e9, "max_angular": 1e9, **parameters},
                                  "here")  # fmt: skip


def ends(parameters, q):
    """Return the poses of both frames."""
    kinematics = team().kinematics(state_at(q))
    other = 1 if "other" in parameters else 0
    return (
        kinematics.frame(0, parameters["frame"])[0],
        kinematics.frame(other, parameters["other_frame"])[0],
    )


def start(seed):
    rng = np.random.default_rng(seed)
    limits = team().limits
    share = rng.uniform(0.1, 0.9, team().n)
    q = limits.position_lower + share * (limits.position_upper - limits.position_lower)
    return q, rng.normal(size=team().n), rng


def references(q, parameters, **motion):
    other = 1 if "other" in parameters else 0
    keys = ((0, parameters["frame"]), (other, parameters["other_frame"]))
    frames = dict(zip(keys, ends(parameters, q), strict=True))
    return References(team().tools(q), team().base_poses(q), 1, Motion(frames=frames, **motion))


def rows(task, q, wanted):
    return task.linearise(team().kinematics(state_at(q)), wanted)


def placed(parameters, q, away=None):
    """Return the parameter ``pose`` that asks for what is at q, and ``away`` in the axes of a."""
    one, other = ends(parameters, q)
    shift, turn = (np.zeros(3), np.eye(3)) if away is None else (away[:3], pin.exp3(away[3:]))
    return {
        "xyz": (one.rotation.T @ (other.position - one.position) + shift).tolist(),
        "quaternion": to_quaternion(turn @ one.rotation.T @ other.rotation).tolist(),
    }


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("parameters", CASES + LOCAL)
@pytest.mark.parametrize("told", ["references", "pose"])
def test_the_rows_are_the_derivative_of_the_error(told, parameters, seed):
    q, chi, _ = start(seed)
    given = parameters | ({"pose": placed(parameters, q)} if told == "pose" else {})
    task, wanted = make(**given), references(q, parameters)
    now = rows(task, q, wanted)
    kept = np.flatnonzero(parameters.get("mask", [True] * 6))
    assert now.matrix.shape == (len(kept), team().n)
    np.testing.assert_allclose(now.lower, 0.0, atol=1e-6)
    ahead, behind = (rows(task, q + s * H * chi, wanted).lower for s in (1, -1))
    gain = np.broadcast_to(parameters.get("gain", 3.0), 6)[kept]
    np.testing.assert_allclose((ahead - behind) / (2.0 * H), -gain * (now.matrix @ chi), atol=1e-5)


@pytest.mark.parametrize("parameters", CURVED)
def test_the_curvature_is_that_of_half_of_its_squared_error(parameters):
    """B(e) = d2(|e|^2 / 2)/dq2 - J^T J near zero error, up to terms of second order in e."""
    q, chi, rng = start(4)
    chi /= np.linalg.norm(chi)
    task = make(**parameters, pose=placed(parameters, q, 1e-3 * rng.normal(size=6)))
    kept = np.flatnonzero(parameters.get("mask", [True] * 6))
    gain = np.broadcast_to(parameters.get("gain", 3.0), 6)[kept]

    def error(s):
        return rows(task, q + s * chi, references(q, parameters)).lower / gain

    h, now = 1e-3, rows(task, q, references(q, parameters))
    second = sum(w * 0.5 * error(s) @ error(s) for w, s in ((1, h), (-2, 0), (1, -h))) / h**2
    bent = np.zeros((team().n, team().n))
    places = dict(enumerate(team().slices))
    add_curvature(bent, now, error(0.0), team().kinematics(state_at(q)), places)
    moved = now.matrix @ chi
    assert abs(chi @ bent @ chi) > 1e-5
    assert second - moved @ moved == pytest.approx(chi @ bent @ chi, abs=2e-5)


def test_joints_that_carry_both_frames_have_no_part_in_it_at_its_goal():
    q, _, _ = start(0)
    parameters = {"frame": "left_lower_forearm", "other_frame": "left_gripper"}
    now = rows(make(**parameters, pose=placed(parameters, q)), q, None)
    carried = [name for name in team().robots[0].joints if name.startswith(("left_s", "left_e"))]
    places = [team().robots[0].joints.index(name) for name in carried]
    assert len(places) == 4
    np.testing.assert_allclose(now.matrix[:, places], 0.0, atol=1e-12)
    assert np.abs(now.matrix[:, team().robots[0].joints.index("left_w2")]).max() > 0.1


def test_two_tools_of_two_robots_are_the_rows_as_they_were():
    q, _, _ = start(1)
    wanted = references(start(2)[0], TWO_ROBOTS)
    plain = rows(make(other="panda"), q, wanted)
    full = rows(make(other="panda", gain=[3.0] * 6), q, wanted)
    assert plain.frame is None
    np.testing.assert_allclose(full.matrix, plain.matrix, atol=1e-12)
    np.testing.assert_allclose(full.lower, plain.lower, atol=1e-12)
    kinematics = team().kinematics(state_at(q))
    goal = other_end(kinematics.tools[0], wanted.ee[0], wanted.ee[1])
    np.testing.assert_allclose(plain.lower, 3.0 * pose_error(kinematics.tools[1], goal))


def test_frames_without_references_and_without_a_pose_stay_as_they_are():
    q, _, _ = start(3)
    now = rows(make(**TWO_ARMS), q, References(team().tools(q), team().base_poses(q)))
    assert not now.lower.any()
    assert now.matrix.any()


def test_references_that_turn_against_each_other_ask_for_that_velocity_too():
    q, _, rng = start(5)
    twist = rng.normal(size=6)
    moving = references(q, TWO_ARMS, twists={(0, "right_gripper"): twist})
    np.testing.assert_allclose(rows(make(**TWO_ARMS), q, moving).feed, twist, atol=1e-12)
    masked = rows(make(**TWO_ARMS, mask=MASK), q, moving)
    np.testing.assert_allclose(masked.feed, twist[[0, 2, 4, 5]], atol=1e-12)


def test_its_name_tells_the_frames():
    assert make(**TWO_ARMS).name == "baxter/relative_pose(left_gripper, right_gripper)"
    assert make(**TWO_ARMS).robots == (0,)
    assert make(other="panda").name == "baxter/relative_pose"
    assert make(**TWO_ROBOTS).robots == (0, 1)


def test_a_goal_given_as_a_pose_is_where_the_other_frame_goes():
    """Following the rows exactly, the grippers come to stand as the pose says."""
    q, _, _ = start(0)
    there = q + 0.1
    one, other = ends(TWO_ARMS, there)
    task = make(**TWO_ARMS, pose=placed(TWO_ARMS, there), gain=5.0)
    for _ in range(400):
        now = rows(task, q, None)
        q = q + 0.01 * np.linalg.pinv(now.matrix, rcond=1e-3) @ now.lower
    goal = Pose(one.rotation.T @ (other.position - one.position), one.rotation.T @ other.rotation)
    left, right = ends(TWO_ARMS, q)
    np.testing.assert_allclose(left.rotation.T @ (right.position - left.position), goal.position,
                               atol=1e-4)  # fmt: skip
    np.testing.assert_allclose(left.rotation.T @ right.rotation, goal.rotation, atol=1e-4)
