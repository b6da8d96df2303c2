"""What is known of a chain in which joints mimic others, against finite differences."""

from functools import cache

import numpy as np
import pytest

from lexstack.references import Motion, References
from lexstack.robots import Team, robot_from_urdf
from lexstack.tasks import TASKS
from lexstack.tasks.feed_forward import feed_forward
from lexstack.tasks.manipulability import log_manipulability
from lexstack.types import RobotState

H, DT = 1e-6, 0.01
AXES = ("0 0 1", "0 1 0", "1 0 0", "0 1 0", "0 0 1", "0 1 0")
MIMICS = {2: (0, -0.7), 4: (1, 1.5)}  # a joint, whom it follows, and how fast


def urdf():
    """Return a chain of six joints, two of which follow others below them."""
    inertial = (
        '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
        "</inertial>"
    )
    text = [f'<link name="l{i}">{inertial}</link>' for i in range(7)]
    for i, axis in enumerate(AXES):
        mimic = ""
        if i in MIMICS:
            primary, factor = MIMICS[i]
            mimic = f'<mimic joint="j{primary}" multiplier="{factor}" offset="0.2"/>'
        text.append(
            f'<joint name="j{i}" type="revolute"><parent link="l{i}"/><child link="l{i + 1}"/>'
            f'<origin xyz="0.1 0.05 0.3"/><axis xyz="{axis}"/>{mimic}'
            '<limit lower="-3" upper="3" velocity="2" effort="50"/></joint>'
        )
    return f'<robot name="chain">{"".join(text)}</robot>'


@cache
def team():
    return Team((robot_from_urdf(urdf(), tool="l6"),), DT)


def frame(q):
    kinematics = team().kinematics(RobotState(0, 0.0, q, 0 * q, q, 0 * q))
    return kinematics.frame(0, "l6")


def start(seed):
    rng = np.random.default_rng(seed)
    return rng.uniform(-1.0, 1.0, team().n), rng.normal(size=team().n), rng


@pytest.mark.parametrize("seed", range(4))
def test_the_drift_of_a_frame_is_the_derivative_of_its_jacobian(seed):
    q, chi, rng = start(seed)
    twist = rng.normal(size=6)
    kinematics = team().kinematics(RobotState(0, 0.0, q, chi, q, chi))
    ahead, behind = (frame(q + s * H * chi)[1] @ chi for s in (1, -1))
    expected = twist - 0.5 * DT * (ahead - behind) / (2.0 * H)
    for name in ("tool", "l6"):
        found = feed_forward(twist, kinematics, team(), 0, name)
        np.testing.assert_allclose(found, expected, atol=1e-8)


@pytest.mark.parametrize("rows", ["position", "orientation", "pose"])
@pytest.mark.parametrize("seed", range(3))
def test_the_gradient_of_the_manipulability_is_its_derivative(rows, seed):
    q, chi, _ = start(seed)
    part = {"position": slice(0, 3), "orientation": slice(3, 6), "pose": slice(0, 6)}[rows]
    parameters = {"rows": rows, "gain": 1.0, "max_speed": 1e9}
    task = TASKS["manipulability"](team(), 0, parameters, "here")
    kinematics = team().kinematics(RobotState(0, 0.0, q, chi, q, chi))
    asked = task.linearise(kinematics, References((), (), 0, Motion())).lower
    ahead, behind = (log_manipulability(frame(q + s * H * chi)[1], part) for s in (1, -1))
    assert asked @ chi == pytest.approx((ahead - behind) / (2.0 * H), abs=1e-4)
