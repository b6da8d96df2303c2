"""Robots of any URDF against pinocchio alone, in random configurations."""

import dataclasses
import re

import numpy as np
import pytest

from lexstack.errors import LexstackError
from lexstack.robots import RobotModel, Team, robot_from_urdf
from lexstack_config.resolved import load_robot
from support.plain_urdf import PlainUrdf, urdfs
from support.scenario import CONFIG

TWELVE = (
    *("panda", "ur5", "ur10", "xarm7", "so101", "z1", "kinova"),
    *("tiago", "tiago_dual", "baxter", "pr2", "g1"),
)
URDFS = urdfs()
REFUSED = {  # of the package's URDFs; every one in one line that begins with its reason's place
    "alex_psyonic_hands.urdf": "joint 'Left_index_q2' mimics 'index_q1': not a joint",
    "centauro.urdf": "arm: j_wheel_1: position_lower >= position_upper",
    "double_pendulum.urdf": "arm: joint1: velocity: must be finite and > 0",
    "double_pendulum_continuous.urdf": "arm: joint1: velocity: must be finite and > 0",
    "double_pendulum_simple.urdf": "arm: joint1: velocity: must be finite and > 0",
    "iris.urdf": "arm: iris__rotor_0_joint: velocity: must be finite and > 0",
    "iris_simple.urdf": "no joint of the URDF moves",
    "quadrotor_base.urdf": "no joint of the URDF moves",
    "quadruped.urdf": "arm: BL_KFE: position_lower >= position_upper",
    "romeo.urdf": "arm: LHand: velocity: must be finite and > 0",
    "tiago_dual.urdf": "arm: caster_back_left_1_joint: velocity: must be finite and > 0, got inf",
    "ur3.urdf": "expected a <robot> with a name",
}


def random_q(robot: RobotModel, rng: np.random.Generator) -> np.ndarray:
    """Return a configuration within the limits; joints without any turn up to 10 rad."""
    lower, upper = robot.limits.position_lower[robot.arm], robot.limits.position_upper[robot.arm]
    free = ~np.isfinite(lower)
    arm = rng.uniform(np.where(free, -10.0, lower), np.where(free, 10.0, upper))
    return np.concatenate((rng.uniform(-10.0, 10.0, robot.base_q.stop), arm))


def same(found, expected):
    """Fail unless two arrays are the same to 1e-9 of the largest entry."""
    assert np.abs(found - expected).max() <= 1e-9 * max(1.0, np.abs(expected).max())


def compare(robot: RobotModel, plain: PlainUrdf, links: list[str], count: int) -> None:
    """Compare poses and Jacobians of links, and the mass matrix, in random configurations."""
    rng = np.random.default_rng(7)
    for _ in range(count):
        q = random_q(robot, rng)
        plain.set(q)
        same(robot.mass_matrix(q), plain.mass())
        for link in {*rng.choice(links, 2), links[-1]}:
            pose, jacobian = robot.at(q, robot.frame(link))
            expected, slopes = plain.frame(link)
            same(pose.position, expected.translation)
            same(pose.rotation, expected.rotation)
            same(jacobian, slopes)


def links_of(plain: PlainUrdf, robot: RobotModel) -> list[str]:
    """Return the links whose names are no frames of ours."""
    ours = {"tool", "base", *robot.config.tools} if robot.has_base else {"tool"}
    return [f.name for f in plain.model.frames if f.type.name == "BODY" and f.name not in ours]


@pytest.mark.parametrize("name", TWELVE)
def test_twelve_robots_are_those_of_pinocchio(name):
    config = load_robot(CONFIG / "robots" / f"{name}.yaml")
    robot = RobotModel(name, config, (0.3, -0.2, 0.7, 0.5))
    plain = PlainUrdf(URDFS[config.arm.description], robot)
    compare(robot, plain, links_of(plain, robot), 1000)


@pytest.mark.parametrize("name", TWELVE)
def test_their_files_are_short_and_their_tools_hang_on_links(name):
    assert len((CONFIG / "robots" / f"{name}.yaml").read_text().splitlines()) <= 25
    config = load_robot(CONFIG / "robots" / f"{name}.yaml")
    robot = RobotModel(name, config)
    plain = PlainUrdf(URDFS[config.arm.description], robot)
    q = robot.home()
    plain.set(q)
    for frame, tool in {"tool": config.tool, **config.tools}.items():
        expected, _ = plain.frame(tool.parent)
        pose, _ = robot.at(q, robot.frame(frame))
        same(pose.position, expected.act(np.array(tool.xyz)))
    limits, places = robot.limits, Team((robot,), 0.01).joint_positions(q)
    assert ((limits.position_lower <= places) & (places <= limits.position_upper)).all()


@pytest.mark.parametrize("path", URDFS, ids=lambda path: path.rsplit("/", 1)[1])
def test_every_urdf_of_the_package_loads_or_is_refused_in_one_line(path):
    file = path.rsplit("/", 1)[1]
    last = last_link(path)
    if file in REFUSED:
        with pytest.raises(LexstackError) as caught:
            robot_from_urdf(path, tool=last)
        assert REFUSED[file] in str(caught.value)
        assert "\n" not in str(caught.value)
        return
    robot = robot_from_urdf(path, tool=last)
    plain = PlainUrdf(URDFS[path], robot)
    compare(robot, plain, links_of(plain, robot), 20)


def last_link(path: str) -> str:
    """Return the name of the last link in a URDF."""
    names = re.findall(r"""<link\b[^>]*name=["']([^"']+)""", URDFS[path].read_text("utf-8"))
    return names[-1] if names else ""


@pytest.mark.parametrize(("joint", "value"), [("arm_2_joint", 0.4), ("wheel_left_joint", 2.0)])
def test_locked_joints_of_every_type_are_where_they_are_held(joint, value):
    config = load_robot(CONFIG / "robots" / "tiago.yaml")
    arm = config.arm
    kept = [i for i, name in enumerate(arm.joints) if name != joint]
    lists = {
        field.name: tuple(getattr(arm, field.name)[i] for i in kept)
        for field in dataclasses.fields(arm)
        if isinstance(getattr(arm, field.name), tuple) and field.name != "packages"
    }
    held = dataclasses.replace(arm, fixed={**arm.fixed, joint: value}, **lists)
    robot = RobotModel("tiago", dataclasses.replace(config, arm=held))
    plain = PlainUrdf(URDFS[arm.description], robot)
    compare(robot, plain, ["wheel_left_link", "hand_palm_link"], 50)


def test_a_continuous_joint_s_position_is_its_unwrapped_angle():
    robot = RobotModel("k", load_robot(CONFIG / "robots" / "kinova.yaml"))
    q = robot.home()
    turned = q + np.array([2.0 * np.pi, 0.0, 0.0, -4.0 * np.pi, 0.0, 0.0])
    same(robot.tool(turned)[0].position, robot.tool(q)[0].position)
    chi = np.arange(6.0)
    assert (robot.integrate(turned, chi, 0.1) == turned + 0.1 * chi).all()
    assert np.isinf(robot.limits.position_upper).tolist() == [True, False, False, True, False, True]
    assert np.isfinite(robot.posture).all()
