"""A user's own robot and scenario, outside the clone: from the URDF to a smooth switch."""

import shutil
import subprocess
import sys

import numpy as np
import pytest
from rosbags.highlevel import AnyReader

from lexstack_config.parts import build_team
from lexstack_config.resolved import load_scenario
from support.runs import read
from support.scenario import ROOT

pytestmark = pytest.mark.system

FILES = ROOT / "examples" / "own_robot"
MOST_LINES = {"lift_arm.yaml": 25, "reach.yaml": 15}


def test_two_short_files_and_a_urdf_run_from_anywhere(tmp_path):
    folder = shutil.copytree(FILES, tmp_path / "mine")
    for name, most in MOST_LINES.items():
        assert len((folder / name).read_text().splitlines()) <= most
    out = tmp_path / "run"
    command = [sys.executable, "-m", "lexstack_bringup.commands.demo", "mine/reach.yaml"]
    done = subprocess.run(
        [*command, "--out", str(out)],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=200,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    log = (out / "logs" / "sim_bridge.log").read_text()
    assert "there is no mesh meshes/name_plate.stl; it is left out" in log
    resolved = load_scenario(folder / "reach.yaml", ROOT / "config")
    team = build_team(resolved)
    topics = ("/plant/state", "/robot_a/chi", "/robot_a/transition", "/arm/joint_states")
    bag = read(out / "bag", *topics)
    chi = np.array([message.chi for message in bag["/robot_a/chi"]])
    assert len(chi) == 600
    limits, slack = team.limits, 1.0 + 1e-9
    assert (np.abs(chi) <= slack * limits.velocity).all()
    steps = np.abs(np.diff(chi, axis=0, prepend=0.0)) / team.dt
    assert (steps <= slack * limits.acceleration).all()
    goal = resolved.scenario.ee_target["arm"].position
    for state in (bag["/plant/state"][300], bag["/plant/state"][-1]):
        assert np.linalg.norm(team.tools(np.array(state.q))[0].position - goal) < 1e-3
    told = bag["/robot_a/transition"]
    assert 3 in {message.phase for message in told}  # BLENDING
    assert (told[-1].phase, told[-1].to_stack) == (0, "posture")
    joints = bag["/arm/joint_states"][-1]
    assert list(joints.name) == ["lift", "turn", "shoulder", "elbow", "roll", "left", "right"]
    assert joints.position[-1] == pytest.approx(joints.position[-2], abs=1e-12)  # it mimics
    with AnyReader([out / "bag"]) as reader:
        assert "/arm/odom" not in reader.topics  # it has no base
