"""Robots of a user: what their URDFs may have in the simulation, and what is refused or told."""

from __future__ import annotations

import shutil

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from lexstack.errors import ModelError
from lexstack.robots import RobotModel, Team, robot_from_urdf
from lexstack_config.resolved import load_robot
from lexstack_sim.contacts import joints_between
from lexstack_sim.coordinates import Coordinates
from lexstack_sim.geometry import mesh_path
from lexstack_sim.meshes import Mesh, arm_shapes, is_flat, missing_meshes
from lexstack_sim.notes import notes
from lexstack_sim.render import Renderer, RenderError
from lexstack_sim.urdf import robot_urdf
from lexstack_sim.world import MASSLESS, body_name, build_world
from support.scenario import CONFIG, ROOT

FOLDER = ROOT / "examples" / "own_robot"
KINDS = mujoco.mjtGeom


@pytest.fixture
def robot():
    return RobotModel("arm", load_robot(FOLDER / "lift_arm.yaml"), (0.5, 0.0, 0.1, 0.3))


@pytest.fixture
def team(robot):
    return Team((robot,), 0.01)


def urdf(**links: str) -> str:
    """Return a URDF with three joints in a row; ``links`` are the insides of its links."""
    inertial = (
        '<inertial><mass value="1"/>'
        '<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>'
    )
    bodies = "".join(f'<link name="l{i}">{links.get(f"l{i}", inertial)}</link>' for i in range(4))
    joints = "".join(
        f'<joint name="j{i}" type="revolute"><parent link="l{i}"/><child link="l{i + 1}"/>'
        '<origin xyz="0.3 0 0.1"/><axis xyz="0 0.6 0.8"/>'
        '<limit lower="-2" upper="2" velocity="2" effort="30"/></joint>'
        for i in range(3)
    )
    return f'<robot name="r">{bodies}{joints}</robot>'


def one(text: str, **values: object) -> Team:
    """Return a team of the robot that a URDF describes."""
    return Team((robot_from_urdf(text, name="r", **values),), 0.01)


def mass_of(world: mujoco.MjModel, q: np.ndarray, team: Team) -> np.ndarray:
    data, full = mujoco.MjData(world), np.zeros((world.nv, world.nv))
    places = Coordinates(world, team)
    places.put(data, q)
    mujoco.mj_fwdPosition(world, data)
    mujoco.mj_fullM(world, data, full)
    return places.matrix.T @ full @ places.matrix


def test_a_joint_that_mimics_stands_at_its_ratio_and_offset_in_the_world():
    limit = '<limit lower="-2" upper="2" velocity="2" effort="30"/></joint><joint name="j2"'
    follows = '<mimic joint="j0" multiplier="-0.5" offset="0.4"/>' + limit
    team = one(urdf().replace(limit, follows), tool="l3")
    (robot,) = team.robots
    assert robot.joints == ("j0", "j2")
    world, q = build_world(team), np.array([0.6, -0.3])
    data = mujoco.MjData(world)
    Coordinates(world, team).put(data, q)
    assert [float(data.joint(f"r/{j}").qpos[0]) for j in ("j0", "j1", "j2")] == pytest.approx(
        [0.6, 0.1, -0.3], abs=1e-12
    )


def test_shapes_of_all_kinds_touch_where_the_urdf_has_them(team):
    world = build_world(team)
    kinds = {world.geom(i).name.split("/")[-1]: world.geom(i) for i in range(world.ngeom)}
    assert KINDS(int(kinds["stand_0"].type[0])) == KINDS.mjGEOM_CYLINDER
    np.testing.assert_allclose(kinds["stand_0"].size[:2], [0.06, 0.2])
    assert KINDS(int(kinds["carriage_0"].type[0])) == KINDS.mjGEOM_BOX
    np.testing.assert_allclose(kinds["carriage_0"].size, [0.08, 0.08, 0.06])
    assert KINDS(int(kinds["upper_arm_0"].type[0])) == KINDS.mjGEOM_CAPSULE
    np.testing.assert_allclose(kinds["upper_arm_0"].size[:2], [0.045, 0.18])
    assert KINDS(int(kinds["hand_0"].type[0])) == KINDS.mjGEOM_SPHERE
    assert kinds["hand_0"].size[0] == pytest.approx(0.05)
    data = mujoco.MjData(world)
    Coordinates(world, team).put(data, team.home())
    mujoco.mj_kinematics(world, data)
    pose, _ = team.robots[0].at(team.home(), team.robots[0].frame("hand"))
    middle = pose.position + pose.rotation @ np.array([0.03, 0.0, 0.0])
    np.testing.assert_allclose(data.geom("arm/contact/hand_0").xpos, middle, atol=1e-9)


def test_a_mesh_that_is_not_there_is_named_in_one_line_and_left_out(robot, team):
    (line,) = missing_meshes(robot)
    assert line == (
        "robot arm: link 'carriage': visual: there is no mesh meshes/name_plate.stl; it is left out"
    )
    assert notes(team, team.home()) == (line,)
    names = [shape.name for shape in arm_shapes(robot, pin.GeometryType.VISUAL)]
    assert [name for name in names if name.startswith("carriage")] == ["carriage_0"]
    build_world(team, visuals=True)


def test_a_mesh_that_cannot_be_read_is_left_out_too(tmp_path):
    folder = shutil.copytree(FOLDER, tmp_path / "mine")
    (folder / "meshes").mkdir()
    (folder / "meshes" / "name_plate.stl").write_text("no mesh")
    robot = RobotModel("arm", load_robot(folder / "lift_arm.yaml"))
    world = build_world(Team((robot,), 0.01), visuals=True)
    assert world.nmesh == 0


def test_meshes_are_found_beside_the_urdf_in_packages_and_above(tmp_path):
    mesh = tmp_path / "ws" / "my_robot" / "meshes" / "a.stl"
    mesh.parent.mkdir(parents=True)
    mesh.write_text("")
    urdfs = tmp_path / "ws" / "my_robot" / "urdf"
    urdfs.mkdir()
    assert mesh_path("../meshes/a.stl", urdfs) == mesh
    assert mesh_path("package://my_robot/meshes/a.stl", urdfs) == mesh
    assert mesh_path("package://other_name/meshes/a.stl", urdfs) == mesh
    assert mesh_path("package://my_robot/meshes/a.stl", None, (str(tmp_path / "ws"),)) == mesh
    assert mesh_path(f"file://{mesh}", None) == mesh
    for name in ("package://my_robot/meshes/b.stl", "b.stl", "/b.stl", "file:///b.stl"):
        with pytest.raises(ModelError, match="there is no mesh"):
            mesh_path(name, urdfs)


@pytest.mark.parametrize("where", ["l1", "l3"])
def test_massless_links_change_no_mass_matrix(where):
    team = one(urdf(**{where: ""}))
    (robot,), world = team.robots, build_world(team)
    assert world.body("r/" + where).mass[0] == MASSLESS
    rng = np.random.default_rng(0)
    for _ in range(20):
        q = rng.uniform(-2.0, 2.0, 3)
        np.testing.assert_allclose(
            mass_of(world, q, team), robot.mass_matrix(q), rtol=0, atol=1e-12
        )


def test_a_joint_that_moves_nothing_is_refused():
    with pytest.raises(ModelError, match="robot r: joint j2: moves no mass and has no armature"):
        build_world(one(urdf(l3=""), armature=0.0))


def test_inertias_that_no_body_has_are_taken_while_the_mass_matrix_is_one():
    """Some URDFs have them; MuJoCo's compiler refuses what violates A + B >= C."""
    flat = (
        '<inertial><mass value="1"/>'
        '<inertia ixx="0.1" iyy="0.01" izz="0.3" ixy="0" ixz="0.02" iyz="0"/></inertial>'
    )
    team = one(urdf(l2=flat))
    (robot,), world, q = team.robots, build_world(team), np.array([0.3, -0.4, 0.5])
    np.testing.assert_allclose(mass_of(world, q, team), robot.mass_matrix(q), rtol=0, atol=1e-12)
    with pytest.raises(ModelError, match=r"joint j2: .*not positive definite|moves no mass"):
        build_world(one(urdf(l3=flat.replace('"0.1"', '"-9"').replace('"0.3"', '"-9"'))))


def test_a_joint_too_weak_for_its_home_is_told():
    team = one(urdf(), torque=2.0)
    (line,) = notes(team, team.home())  # g = 0.6 9.81 (0.6 + 0.3) of the first, 1.8 of the second
    assert "robot r: joint j0: its torque limit of 2 does not hold the 5.297 of gravity" in line
    assert notes(one(urdf()), np.zeros(3)) == ()


def test_the_description_names_the_robot_s_own_joints_and_is_the_same_robot(robot):
    model = pin.buildModelFromXML(robot_urdf(robot).replace("capsule", "cylinder"))
    names = [*robot.config.arm.joints, "right"]
    assert sorted(model.names[1:]) == sorted(names)
    q = robot.home()
    full = pin.neutral(model)
    values = dict(zip(robot.pinocchio.names[1:], robot.positions(q), strict=True))
    for i in range(1, model.njoints):
        joint, value = model.joints[i], values[model.names[i]]
        place = slice(joint.idx_q, joint.idx_q + joint.nq)
        full[place] = value if joint.nq == 1 else (np.cos(value), np.sin(value))
    data = model.createData()
    pin.framesForwardKinematics(model, data, full)
    pose = robot.tool(q)[0]
    found = data.oMf[model.getFrameId("tool")]
    np.testing.assert_allclose(found.translation, pose.position, atol=1e-12)
    np.testing.assert_allclose(found.rotation, pose.rotation, atol=1e-12)


def test_two_arms_of_one_robot_are_apart_along_the_tree():
    robot = RobotModel("pr2", load_robot(CONFIG / "robots" / "pr2.yaml"))
    model = robot.pinocchio
    left, right = (model.getJointId(f"{side}_wrist_roll_joint") for side in "lr")
    torso = model.getJointId("torso_lift_joint")
    assert joints_between(model, left, right) == 14
    assert joints_between(model, torso, right) == 7
    assert joints_between(model, left, left) == 0


def test_flat_meshes_are_thin_boxes():
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    faces = np.array([[0, 1, 2], [0, 2, 3]], dtype=np.int32)
    assert is_flat(Mesh(square, faces))
    assert is_flat(Mesh(square[:3], faces[:1]))
    square[0, 2] = 0.1
    assert not is_flat(Mesh(square, faces))


def test_an_arm_without_a_base_is_drawn(team):
    try:
        renderer = Renderer(team, (160, 160), fast=True)
    except RenderError as error:
        pytest.skip(str(error))
    with renderer:
        renderer.frame([team.home()])
        picture = renderer.picture(team.home())
    assert picture.std() > 10.0


def test_the_guide_shows_the_example_s_files():
    guide = (ROOT / "docs" / "robots.md").read_text(encoding="utf-8")
    for name in ("lift_arm.yaml", "reach.yaml"):
        assert (FOLDER / name).read_text(encoding="utf-8") in guide


def test_bodies_bear_the_names_of_links(robot):
    assert body_name(robot, robot.pinocchio.getJointId("turn")) == "arm/turntable"
