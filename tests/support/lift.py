"""A mobile manipulator whose first arm joint slides: a lift, and three joints that turn."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from lexstack.robots import FrameConfig, Team
from lexstack_config.parts import build_team
from lexstack_config.resolved import ResolvedScenario, load_robot
from support.scenario import CONFIG, resolved

JOINTS = ("lift", "a1", "a2", "a3")
_AXES = {"a1": "0 0 1", "a2": "0 1 0", "a3": "0 1 0"}
_LIMITS = {
    "home": (0.2, 0.0, 0.5, 0.5),
    "position_lower": (0.0, -2.9, -2.9, -2.9),
    "position_upper": (0.4, 2.9, 2.9, 2.9),
}


def urdf() -> str:
    """Return the arm's description."""
    inertial = (
        '<inertial><mass value="1.5"/>'
        '<inertia ixx="0.03" iyy="0.03" izz="0.03" ixy="0" ixz="0" iyz="0"/></inertial>'
    )
    links = "".join(f'<link name="l_{name}">{inertial}</link>' for name in ("root", *JOINTS))
    joints = "".join(
        f'<joint name="{name}" type="{"prismatic" if name == "lift" else "revolute"}">'
        f'<parent link="l_{parent}"/><child link="l_{name}"/><origin xyz="0 0 .25"/>'
        f'<axis xyz="{_AXES.get(name, "0 0 1")}"/>'
        '<limit lower="-2.9" upper="2.9" velocity="2" effort="80"/></joint>'
        for parent, name in zip(("root", *JOINTS), JOINTS, strict=False)
    )
    return f'<robot name="lift">{links}{joints}</robot>'


def lift_scenario(folder: Path) -> ResolvedScenario:
    """Return a scenario with this robot, its description in ``folder``."""
    file = folder / "share" / "robots" / "lift" / "urdf" / "lift.urdf"  # as deep as a package's
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(urdf(), encoding="utf-8")
    known = load_robot(CONFIG / "robots" / "panda_summit.yaml")
    lists = {
        name: getattr(known.arm, name)[:4]
        for name in (
            *("velocity", "acceleration", "jerk", "torque", "torque_rate"),
            *("stiffness", "damping", "armature", "q_star_distance"),
        )
    }
    arm = replace(
        known.arm,
        description=str(file),
        root="l_root",
        joints=JOINTS,
        fixed={},
        **lists,
        **_LIMITS,
    )
    tool = FrameConfig("l_a3", (0.0, 0.0, 0.1), (0.0, 0.0, 0.0))
    robot = replace(known, name="lift", arm=arm, tool=tool, spheres=())
    place = replace(resolved().scenario.robots["robot_a"], model="lift")
    scenario = replace(
        resolved().scenario, robots={"robot_a": place}, ee_target={}, base_target={}, events=()
    )
    return replace(resolved(), scenario=scenario, robots={"lift": robot})


def lift_team(folder: Path) -> Team:
    """Return that robot as a team of one."""
    return build_team(lift_scenario(folder))
