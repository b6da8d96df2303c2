"""The import contracts hold, and they fail where they should."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = [
    "lexstack",
    "lexstack_bag",
    "lexstack_bringup",
    "lexstack_config",
    "lexstack_experiments",
    "lexstack_plant",
    "lexstack_ros",
    "lexstack_sim",
    "lexstack_testing",
]


@pytest.fixture(scope="module")
def sources(tmp_path_factory):
    """Return a copy of all packages, side by side, and of the contracts."""
    folder = tmp_path_factory.mktemp("sources")
    shutil.copy(ROOT / "pyproject.toml", folder)
    for package in PACKAGES:
        source = ROOT / "ros2_ws/src" / package / package
        shutil.copytree(source, folder / package, ignore=shutil.ignore_patterns("__pycache__"))
    return folder


def lint_imports(folder):
    """Run import-linter on the packages of a folder."""
    return subprocess.run(
        [Path(sys.executable).with_name("lint-imports"), "--no-cache"],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(folder)},
        capture_output=True,
        text=True,
        check=False,
    )


def test_all_contracts_are_kept(sources):
    done = lint_imports(sources)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize(
    ("module", "statement", "contract"),
    [
        ("lexstack/types.py", "import mujoco", "The library knows no ROS"),
        ("lexstack/types.py", "import rclpy", "The library knows no ROS"),
        ("lexstack/types.py", "from std_msgs.msg import Header", "The library knows no ROS"),
        ("lexstack/types.py", "import lexstack_interfaces", "The library knows no ROS"),
        ("lexstack/types.py", "import lexstack_sim", "The library knows no ROS"),
        ("lexstack/errors.py", "import lexstack.control.controller", "Inside the library"),
        ("lexstack_sim/plant.py", "import rclpy", "Bag, simulation and experiments"),
        ("lexstack_sim/plant.py", "import lexstack_plant", "Between the packages"),
        ("lexstack_ros/__init__.py", "import lexstack_bringup", "Between the packages"),
        ("lexstack_bringup/__init__.py", "import lexstack_testing", "Between the packages"),
        ("lexstack_experiments/__init__.py", "import rclpy", "Bag, simulation and experiments"),
        ("lexstack_bag/__init__.py", "import rclpy", "Bag, simulation and experiments"),
        ("lexstack_bag/__init__.py", "import lexstack_ros", "Between the packages"),
    ],
)
def test_a_forbidden_import_breaks_its_contract(sources, module, statement, contract):
    file = sources / module
    before = file.read_text()
    file.write_text(f"{before}\n{statement}\n")
    try:
        done = lint_imports(sources)
    finally:
        file.write_text(before)
    assert done.returncode == 1
    broken = [line for line in done.stdout.splitlines() if " BROKEN" in line]
    assert any(line.startswith(contract) for line in broken), done.stdout
