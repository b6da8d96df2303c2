"""Robot files: what they may leave out, and what is refused in one line with file and key."""

import sys
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest
import yaml

from lexstack.errors import ConfigurationError, LexstackError
from lexstack.robots import RobotConfig, RobotModel, SphereConfig, Team, robot_from_urdf
from lexstack.types import RobotState
from lexstack_config.reader import build, plain
from lexstack_config.resolved import load_robot
from support.plain_urdf import urdfs

JOINT = (
    '<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
    '<origin xyz="0.1 0 .3" rpy="0.1 0 0"/><axis xyz="{axis}"/>{inner}</joint>'
)
LIMIT = '<limit lower="{}" upper="{}" velocity="{}" effort="{}"/>'
MASS = (
    '<inertial><mass value="1.5"/><origin xyz="0.1 0 0.1"/>'
    '<inertia ixx="0.03" iyy="0.03" izz="0.03" ixy="0" ixz="0" iyz="0"/></inertial>'
)


def chain(*joints, more=""):
    """Return a URDF of joints one after the other: (name, type, axis, what stands in it)."""
    links = "".join(f'<link name="l{i}">{MASS}</link>' for i in range(len(joints) + 1))
    parts = [
        JOINT.format(name=n, kind=k, axis=a, inner=x, parent=f"l{i}", child=f"l{i + 1}")
        for i, (n, k, a, x) in enumerate(joints)
    ]
    return f'<robot name="r">{links}{"".join(parts)}{more}</robot>'


def revolute(name, inner=""):
    """Return a joint about an axis that is none of x, y, z."""
    return name, "revolute", "0 0.6 -0.8", inner or LIMIT.format(-2, 2, 1, 9)


TWO = chain(revolute("a"), revolute("b"))


def written(folder, urdf=TWO, **values):
    """Return a robot file and its URDF, in a folder."""
    (folder / "r.urdf").write_text(urdf, encoding="utf-8")
    arm = {"description": "r.urdf", **values.pop("arm", {})}
    path = folder / "r.yaml"
    path.write_text(yaml.safe_dump({"name": "r", "arm": arm, **values}), encoding="utf-8")
    return path


FOLLOWERS = chain(
    revolute("a"),
    revolute("b", LIMIT.format(-9, 9, 9, 9) + '<mimic joint="a" multiplier="-2" offset="0.3"/>'),
    revolute("c", LIMIT.format(-9, 9, 9, 9) + '<mimic joint="b" multiplier="0.5" offset="-0.7"/>'),
)


def test_joints_that_mimic_have_their_ratio_and_their_offset_also_one_after_another():
    """By hand: b = -2 a + 0.3, and c = b / 2 - 0.7 = -a - 0.55."""
    robot = robot_from_urdf(FOLLOWERS, tool="l3")
    model = pin.buildModelFromXML(FOLLOWERS)  # takes no notice of who mimics whom
    data = model.createData()
    for a in np.linspace(-1.9, 1.9, 7):
        q = np.array([a, -2.0 * a + 0.3, -a - 0.55])
        pin.framesForwardKinematics(model, data, q)
        expected = data.oMf[model.getFrameId("l3")]
        pose, jacobian = robot.tool(np.array([a]))
        np.testing.assert_allclose(pose.position, expected.translation, atol=1e-12)
        np.testing.assert_allclose(pose.rotation, expected.rotation, atol=1e-12)
        full = pin.computeFrameJacobian(
            model, data, q, model.getFrameId("l3"), pin.LOCAL_WORLD_ALIGNED
        )
        np.testing.assert_allclose(jacobian, full @ [[1.0], [-2.0], [-1.0]], atol=1e-12)


def test_a_file_of_two_lines_is_a_robot_with_stated_defaults(tmp_path):
    config = load_robot(written(tmp_path))
    assert config.base is None
    assert config.arm.description == str((tmp_path / "r.urdf").resolve())
    assert (config.arm.root, config.tool.parent) == ("l0", "l2")
    assert (config.arm.joints, config.arm.home) == (("a", "b"), (0.0, 0.0))
    assert (config.arm.velocity, config.arm.torque) == ((1.0, 1.0), (9.0, 9.0))
    assert config.arm.acceleration == (1.0 / 0.4,) * 2
    assert config.arm.jerk == (1.0 / 0.4 / 0.01,) * 2
    robot = RobotModel("r", config, (1.0, 2.0, 0.5, np.pi / 2))
    assert robot.base_pose(robot.home()).tolist() == [1.0, 2.0, np.pi / 2]
    at, _ = robot.at(robot.home(), robot.frame("l0"))
    np.testing.assert_allclose(at.position, [1.0, 2.0, 0.5], atol=1e-15)


def test_values_are_for_all_joints_or_in_order_or_by_name(tmp_path):
    given = {"velocity": 0.5, "acceleration": [1.0, 2.0], "home": {"b": 0.3}, "jerk": {"a": 7.0}}
    arm = load_robot(written(tmp_path, arm=given)).arm
    assert (arm.velocity, arm.acceleration) == ((0.5, 0.5), (1.0, 2.0))
    assert (arm.home, arm.jerk) == ((0.0, 0.3), (7.0, 200.0))


FOLLOWS = chain(revolute("a"), revolute("b", LIMIT.format(-1, 1, 1, 1) + '<mimic joint="a"/>'))
WRONG = {
    "velocity": ({"urdf": chain(revolute("a", LIMIT.format(-1, 1, 0, 9)))}, "arm: a: velocity: "),
    "effort": ({"urdf": chain(revolute("a", LIMIT.format(-1, 1, 1, 0)))}, "arm: a: torque: must"),
    "range": (
        {"urdf": chain(revolute("a", LIMIT.format(1, 1, 1, 9)))},
        "arm: a: position_lower >= position_upper",
    ),
    "endless": (
        {"urdf": chain(revolute("a", LIMIT.format("-inf", "inf", 1, 9)))},
        "arm.description: r.urdf: joint 'a': limit: lower: got '-inf'",
    ),
    "unlimited": (
        {"arm": {"position_upper": float("inf")}},
        "arm: a: position_lower and _upper must be finite",
    ),
    "no limit": ({"urdf": chain(("a", "continuous", "0 0 1", ""))}, "arm: a: velocity: must be"),
    "inf": ({"arm": {"velocity": float("inf")}}, "arm: velocity: must be finite"),
    "negative": ({"arm": {"jerk": [-1.0, 1.0]}}, "arm: jerk[0]: must be finite and > 0, got -1"),
    "length": ({"arm": {"acceleration": [1.0]}}, "arm: acceleration: expected 2 values, got 1"),
    "name": ({"arm": {"stiffness": {"c": 1.0}}}, "arm: stiffness: 'c' is no controlled joint"),
    "type": ({"arm": {"velocity": "1e3"}}, "arm: velocity: expected float, got '1e3', which YAML"),
    "entry": ({"arm": {"velocity": [1.0, "x"]}}, "arm: velocity[1]: expected float, got 'x'"),
    "by name": ({"arm": {"velocity": {"a": "x"}}}, "arm: velocity.a: expected float, got 'x'"),
    "joint": ({"arm": {"joints": ["a", "c"]}}, "arm: joints: no joint 'c'; known: a, b"),
    "fixed": ({"arm": {"fixed": {"c": 1.0}}}, "arm: fixed: no joint 'c'; known: a, b"),
    "held": ({"arm": {"fixed": {"a": float("inf")}}}, "arm: fixed.a: must be finite"),
    "none": ({"arm": {"joints": []}}, "arm: joints: at least one joint"),
    "all held": ({"arm": {"fixed": {"a": 0.0, "b": 0.0}}}, "arm: joints: no joint of the URDF"),
    "twice": ({"arm": {"joints": ["a", "a"]}}, "arm: joints: 'a' stands twice"),
    "home": ({"arm": {"home": 3.0}}, "arm: a: home is outside the position limits"),
    "file": ({"arm": {"description": "none.urdf"}}, "arm.description: there is no file "),
    "package": (
        {"arm": {"description": "package://none/a.urdf"}},
        "arm.description: package://none/a.urdf: package 'none': unknown",
    ),
    "xml": ({"urdf": "<robot name='r'>"}, "arm.description: r.urdf: not valid XML"),
    "no robot": ({"urdf": "<sdf/>"}, "arm.description: r.urdf: expected a <robot>"),
    "entities": ({"urdf": '<!DOCTYPE r [<!ENTITY a "b">]><robot name="r"/>'}, "entities"),
    "floating": (
        {"urdf": chain(("a", "floating", "0 0 1", ""))},
        "arm.description: r.urdf: joint 'a': of type floating; known: revolute, continuous",
    ),
    "plane": ({"urdf": chain(("a", "planar", "1 0 0", ""))}, "joint 'a': planar, but not in the"),
    "cycle": (
        {"urdf": chain(revolute("a", '<limit/><mimic joint="a"/>'), revolute("b"))},
        "joint 'a' mimics itself",
    ),
    "nobody": (
        {"urdf": chain(revolute("a", '<limit/><mimic joint="z"/>'), revolute("b"))},
        "joint 'a' mimics 'z'",
    ),
    "factor": (
        {"urdf": chain(revolute("a"), revolute("b", '<mimic joint="a" multiplier="x"/>'))},
        "joint 'b': mimic: multiplier and offset are numbers",
    ),
    "follower": (
        {
            "urdf": chain(
                revolute("a"), revolute("b", LIMIT.format(-1, 1, 1, 1) + '<mimic joint="a"/>')
            ),
            "arm": {"joints": ["b"]},
        },
        "arm: joints: 'b' mimics 'a'",
    ),
    "xacro": ({"arm": {"description": "r.xacro"}}, "needs the package xacro"),
    "key": ({"arm": {"speed": 1.0}}, "arm: unknown key 'speed'"),
    "base": ({"base": {"type": "walking"}}, "base: type: 'walking' is not one of: holonomic"),
}


@pytest.mark.parametrize(("values", "text"), WRONG.values(), ids=WRONG)
def test_a_wrong_robot_file_is_refused_in_one_line_with_file_and_key(tmp_path, values, text):
    path = written(tmp_path, **{**values, "arm": dict(values.get("arm", {}))})
    (tmp_path / "r.xacro").write_text("<robot name='r'/>")
    with pytest.raises(ConfigurationError) as caught:
        load_robot(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert text in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("values", "text"),
    [
        ({"tool": {"parent": "x"}}, "robot r: tool.parent: no link 'x'"),
        ({"tools": {"l1": {"parent": "l2"}}}, "robot r: tools.l1: the robot has a frame 'l1'"),
        ({"tools": {"x": {"parent": "y"}}}, "robot r: tools.x.parent: no link 'y'"),
        ({"arm": {"root": "l9"}}, "robot r: arm.root: no link 'l9'"),
        ({"arm": {"root": "l1"}}, "robot r: arm.root: link 'l1' moves with a joint"),
        ({"arm": {"joints": ["b", "a"]}}, "robot r: arm.joints: 'a' carries 'b' and must come"),
        ({"arm": {"mount": {"parent": "l1"}}}, "robot r: arm.mount.parent: only 'base' is there"),
    ],
)
def test_what_does_not_fit_the_urdf_is_refused_when_the_model_is_built(tmp_path, values, text):
    with pytest.raises(LexstackError, match=text):
        RobotModel("r", load_robot(written(tmp_path, **values)))


def test_descriptions_come_as_text_packages_and_models(tmp_path, monkeypatch):
    by_text = robot_from_urdf(TWO.replace("<joint", "\r\n\t<joint"))
    text = yaml.safe_dump(plain(by_text.config))
    assert build(RobotConfig, yaml.safe_load(text), "bag") == by_text.config
    file = tmp_path / "share" / "mine" / "urdf" / "r.urdf"
    file.parent.mkdir(parents=True)
    file.write_text(TWO)
    q = np.array([0.4, -0.7])
    uri = "package://mine/urdf/r.urdf"
    given = robot_from_urdf(uri, packages=[str(tmp_path / "share")])
    itself = robot_from_urdf(uri, packages=[str(tmp_path / "share" / "mine")])
    index = tmp_path / "share/ament_index/resource_index/packages"
    index.mkdir(parents=True)
    (index / "mine").write_text("")
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path))
    model = pin.buildModelFromXML(TWO)
    for robot in (
        given,
        itself,
        robot_from_urdf(uri),
        robot_from_urdf(file),
        robot_from_urdf(model),
    ):
        assert (robot.tool(q)[1] == by_text.tool(q)[1]).all()


def test_a_planar_joint_is_x_y_and_yaw():
    urdf = chain(("p", "planar", "0 0 1", LIMIT.format(0, 0, 1, 9)), revolute("a"))
    robot = robot_from_urdf(urdf, velocity=1.0, torque=9.0)
    assert robot.joints == ("p_x", "p_y", "p_yaw", "a")
    assert robot.prismatic == (True, True, False, False)
    assert np.isinf(robot.limits.position_upper).tolist() == [True, True, True, False]
    model = pin.buildModelFromXML(urdf)
    data, q = model.createData(), np.array([0.4, -0.3, 2.0, 0.7])
    full = np.array([0.4, -0.3, np.cos(2.0), np.sin(2.0), 0.7])
    pin.framesForwardKinematics(model, data, full)
    expected = data.oMf[model.getFrameId("l2")]
    pose, jacobian = robot.tool(q)
    np.testing.assert_allclose(pose.position, expected.translation, atol=1e-12)
    np.testing.assert_allclose(pose.rotation, expected.rotation, atol=1e-12)
    step = 1e-6 * np.eye(4)
    slopes = [(robot.tool(q + s)[0].position - robot.tool(q - s)[0].position) / 2e-6 for s in step]
    np.testing.assert_allclose(jacobian[:3], np.array(slopes).T, atol=1e-8)


def test_links_and_joints_may_have_the_names_of_ours():
    urdf = TWO.replace('"l1"', '"tool"').replace('"l2"', '"b"').replace('"l0"', '"base"')
    robot = robot_from_urdf(urdf, tool="b", joints=["a"])
    q = np.array([0.3])
    known = robot_from_urdf(TWO, joints=["a"], tool="l2")
    assert (robot.tool(q)[1] == known.tool(q)[1]).all()
    middle, _ = robot.at(q, robot.frame("arm_tool"))
    expected, _ = known.at(q, known.frame("l1"))
    assert (middle.position == expected.position).all()
    with pytest.raises(LexstackError, match="no frame 'tol'; there is: tool"):
        robot.frame("tol")


def test_the_root_that_is_mounted_need_not_be_the_first_link(tmp_path):
    urdf = chain(("f", "fixed", "0 0 1", ""), revolute("a"))
    robot = RobotModel("r", load_robot(written(tmp_path, urdf, arm={"root": "l1"})))
    at, _ = robot.at(robot.home(), robot.frame("l1"))
    np.testing.assert_allclose(at.position, np.zeros(3), atol=1e-15)
    np.testing.assert_allclose(at.rotation, np.eye(3), atol=1e-15)


def test_frames_of_a_tick_are_worked_out_once_and_hold(monkeypatch):
    panda = robot_from_urdf(urdfs()["panda_description/urdf/panda.urdf"], name="one")
    team = Team((panda,), 0.01)
    kinematics = team.kinematics(RobotState.at_rest(team.home()))
    assert kinematics.frame(0, "tool")[0] is kinematics.tools[0]
    pose, jacobian = kinematics.frame(0, "panda_link4")
    before = jacobian.copy()
    team.kinematics(RobotState.at_rest(team.home() + 0.1)).frame(0, "panda_link4")
    again = kinematics.frame(0, "panda_link4")
    assert again[0] is pose
    assert again[1] is jacobian
    assert (jacobian == before).all()
    assert (jacobian[:, 4:] == 0.0).all()


def test_spheres_on_links_that_follow_move_with_what_they_follow():
    config = {"link": "panda_rightfinger", "xyz": (0.0, 0.0, 0.02), "radius": 0.01}
    known = robot_from_urdf(urdfs()["panda_description/urdf/panda.urdf"], name="one")
    robot = RobotModel("one", replace(known.config, spheres=(SphereConfig(**config),)))
    team = Team((robot,), 0.01)
    rng = np.random.default_rng(0)
    q = rng.uniform(robot.limits.position_lower, robot.limits.position_upper)
    spheres = team.spheres(q)
    pose, _ = robot.at(q, robot.frame("panda_rightfinger"))
    center = pose.position + pose.rotation @ np.array(config["xyz"])
    np.testing.assert_allclose(spheres.centers[0], center, atol=1e-12)
    assert robot.spheres.moved_by.tolist() == [[1.0] * 8]
    assert spheres.moved_by.tolist() == [[*[1.0] * 7, 0.0, 1.0]], "not by the other finger"
    rows = spheres.rows(np.zeros(3, dtype=int), np.eye(3)).copy()
    for k in range(8):
        step = np.zeros(8)
        step[k] = 1e-6
        ahead, behind = team.spheres(q + step).centers.copy(), team.spheres(q - step).centers.copy()
        np.testing.assert_allclose(rows[:, k], (ahead - behind)[0] / 2e-6, atol=1e-8)


def test_a_robot_may_have_a_single_joint():
    robot = robot_from_urdf(chain(("a", "continuous", "0 0.6 -0.8", "")), velocity=1.0, torque=9.0)
    q = np.array([0.3])
    _, jacobian = robot.tool(q)
    ahead, behind = robot.tool(q + 1e-6)[0], robot.tool(q - 1e-6)[0]
    np.testing.assert_allclose(
        jacobian[:3, 0], (ahead.position - behind.position) / 2e-6, atol=1e-9
    )
    assert robot.mass_matrix(q).shape == (1, 1)
    spheres = replace(robot.config, spheres=(SphereConfig("l1", (0.2, 0.0, 0.0), 0.1),))
    assert Team((RobotModel("r", spheres),), 0.01).spheres(q).twists.shape == (6, 1)


def test_a_xacro_file_is_expanded_where_the_package_is_there(tmp_path, monkeypatch):
    seen = []

    def process_file(path):
        seen.append(path)
        return SimpleNamespace(toxml=lambda: TWO)

    monkeypatch.setitem(sys.modules, "xacro", SimpleNamespace(process_file=process_file))
    file = tmp_path / "r.urdf.xacro"
    file.write_text("<robot/>")
    assert robot_from_urdf(file).joints == ("a", "b")
    assert set(seen) == {str(file)}
