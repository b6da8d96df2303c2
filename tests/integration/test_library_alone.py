"""The library in an empty environment: its requirements suffice, without ROS and without YAML."""

import ast
import re
import shutil
import subprocess
import sys
from importlib.metadata import PackageNotFoundError
from pathlib import Path
from zipfile import ZipFile

import pytest

from support.empty_environment import EmptyEnvironment, closure

ROOT = Path(__file__).resolve().parents[2]
TESTS = ROOT / "tests"
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
OWN = {"lexstack", "lexstack_config"}
SAID = {  # lines of every example
    "carry_a_box": [
        r"the left hand rose by 0\.150 m",
        r"the hands stayed 0\.600 m apart, to 0\.\d\d mm",
    ],
    "changing_limits": [
        r"fastest joint before: 1\.\d\d rad/s",
        r"fastest joint after:  0\.20 rad/s",
        r"elbow: 1\.50 rad at most, and 1\.[12]\d rad at the end",
        r"accelerations used at most (100|\d\d) % of their limits",
    ],
    "deliveries": [r" \d\.\d\d s: pick is done", r" [2-5]\.\d\d s: home is done"],
    "differential_drive": [
        r"n_q = 10, n_v = 9: base_v, base_w and the arm",
        r"parked at x = -?[0-4]\.\d mm, y = 2(4[6-9]|5[0-4])\.\d mm, yaw = -?[0-4]\.\d mrad",
        r"the hand moved by at most [0-4]\.\d mm, and 0\.\d\d at the end",
    ],
    "figure_of_eight": [r"off the path by at most [0-4]\.\d um after 3 s"],
    "obstacle": [r"nearest to the ball: 0\.0[45]\d m; .*", r"it is back within 0\.\d mm"],
    "own_arm": [
        r"at 0\.05 s, level 1: robot/frame_position\(hand\) row 1 misses by .*, held by .*",
        r"the hand is at \[0\.3 0\.3 0\.5\] m",
    ],
    "own_task": [r"the tool is at a height of 0\.400 m", r"the circle's radius is 0\.100 m"],
    "swept_weight": [
        r"weight  0\.001: hand 0\.000\d m, posture 0\.8\d\d rad off",
        r"weight     10: hand 0\.3\d\d\d m, posture 0\.0\d\d rad off",
        r"two levels:    hand 0\.0000 m, posture 0\.8\d\d rad off",
    ],
    "switch_and_preempt": [
        r"accelerations used at most (100|\d\d) % of their limits",
        r"the base is at \[ ?0\.(40\d|4|39\d) .*\]",
    ],
    "teleoperation": [
        r"at 2 s the hand moves at 0\.150 m/s",
        r"the last twist came at 2\.24 s; at 3 s it moves at 0\.000 m/s",
    ],
}
SIMULATED = {  # of those that need lexstack_sim too
    "in_mujoco": [
        r"the hand is 0\.\d\d mm from its target",
        r"back at its posture .* 0\.0\d\d rad",
    ],
}
pytestmark = [pytest.mark.slow, pytest.mark.timeout(300)]


def wheel_of(package, folder):
    """Return the wheel of one of our packages, built from a copy of its folder."""
    source = folder / package
    shutil.copytree(
        ROOT / "ros2_ws/src" / package,
        source,
        ignore=shutil.ignore_patterns("build", "*.egg-info", "__pycache__"),
    )
    command = [sys.executable, "-m", "pip", "wheel", "--no-deps", "--no-build-isolation"]
    done = subprocess.run(
        [*command, "--wheel-dir", folder, source], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return next(folder.glob(f"{package}-*.whl"))


def requirements(wheel):
    """Return what a wheel requires, of other people's packages."""
    with ZipFile(wheel) as archive:
        name = next(name for name in archive.namelist() if name.endswith("METADATA"))
        text = archive.read(name).decode()
    lines = [line.removeprefix("Requires-Dist: ") for line in text.splitlines()]
    found = [a for a, b in zip(lines, text.splitlines(), strict=True) if a != b]
    return [line for line in found if not line.startswith("lexstack")]


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    """Return an environment with the library and what it requires."""
    folder = tmp_path_factory.mktemp("alone")
    wheel = wheel_of("lexstack", folder)
    environment = EmptyEnvironment(folder / "venv")
    environment.link(requirements(wheel))
    environment.install(wheel)
    return environment


def test_the_examples_are_short():
    assert {file.stem for file in EXAMPLES} == {*SAID, *SIMULATED}
    for file in EXAMPLES:
        assert len(file.read_text().splitlines()) <= 40, file


def check_said(printed, texts):
    """Check that an example said these lines, and not many others."""
    assert len(printed) <= 12
    for text in texts:
        assert any(re.fullmatch(text, line) for line in printed), printed


@pytest.mark.parametrize("example", SAID)
def test_an_example_runs_and_prints_what_came_out(alone, tmp_path, example):
    printed = alone.run(ROOT / "examples" / f"{example}.py", folder=tmp_path).splitlines()
    check_said(printed, SAID[example])


@pytest.mark.parametrize("example", SIMULATED)
def test_an_example_in_mujoco_runs_and_prints_what_came_out(tmp_path, example):
    program = ROOT / "examples" / f"{example}.py"
    done = subprocess.run(
        [sys.executable, program], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    check_said(done.stdout.splitlines(), SIMULATED[example])


def test_what_is_not_declared_is_not_there(alone, tmp_path):
    for module in ("yaml", "mujoco", "rclpy", "mcap", "pytest", "lexstack_config"):
        with pytest.raises(AssertionError, match="ModuleNotFoundError"):
            alone.run("-c", f"import {module}", folder=tmp_path)
    with pytest.raises(PackageNotFoundError):
        closure(["no-such-package-of-ours"])


def imported(file, seen):
    """Return the packages of ours that a test file imports, itself or by what it imports."""
    found = set()
    for node in ast.walk(ast.parse(file.read_text())):
        names = []
        if isinstance(node, ast.ImportFrom):
            names = [node.module or ""]
        elif isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        for name in names:
            top, _, rest = name.partition(".")
            helper = TESTS / top / f"{rest}.py"
            if top == "support" and helper not in seen:
                seen.add(helper)
                found |= imported(helper, seen)
            elif top.startswith("lexstack"):
                found.add(top)
    return found


def own_tests():
    """Return the library's unit tests that need nothing else of ours but its configuration."""
    folders = (TESTS / "unit/lexstack", TESTS / "unit/config")
    files = [file for folder in folders for file in sorted(folder.rglob("test_*.py"))]
    # Those of compiled code need numba, others a solver to compare with: neither is there.
    elsewhere = re.compile(r"\bkernels?\b|compiled|quadprog")
    files = [file for file in files if not elsewhere.search(file.read_text())]
    return [file for file in files if imported(file, set()) <= OWN]


def test_the_library_s_own_unit_tests_pass(alone, tmp_path):
    files = own_tests()
    assert len(files) > 25, files
    config = wheel_of("lexstack_config", tmp_path)
    alone.link([*requirements(config), "pytest", "pytest-timeout", "hypothesis"])
    alone.install(config)
    options = ("-q", "-x", "--no-header", "-p", "no:cacheprovider")
    printed = alone.run("-m", "pytest", *options, *files, folder=ROOT)
    assert " passed" in printed.splitlines()[-1], printed
