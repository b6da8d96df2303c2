"""The set-up: the environment in which commands run."""

import os
import subprocess
from pathlib import Path

import pytest

from workspace.environment import build_variables, shell_script
from workspace.ros import Ros

NATIVE = Ros(Path("/opt/ros/jazzy"), ((3, 12),))


@pytest.fixture
def clone(tmp_path):
    """Return a built clone, in a folder whose name needs quotes."""
    root = tmp_path / "a clone"
    for file in (
        "ros2_ws/src/core/setup.py",
        "ros2_ws/install/core/share/core/package.xml",
        "ros2_ws/install/msgs/share/msgs/package.xml",
        "ros2_ws/install/msgs/lib/libmsgs.so",
        "ros2_ws/install/msgs/lib/python3.11/site-packages/msgs/__init__.py",
        ".venv/lib/python3.11/site-packages/ros_rcl.libs/librcl.so",
    ):
        (root / file).parent.mkdir(parents=True, exist_ok=True)
        (root / file).touch()
    return root


def enter(script, **environ):
    """Return the variables of a shell that has sourced the script."""
    command = ["/bin/sh", "-euc", script + "/usr/bin/env"]
    shell = subprocess.run(command, env=environ, capture_output=True, text=True, check=True)
    return dict(line.split("=", 1) for line in shell.stdout.splitlines())


def test_wheels_environment_is_complete_and_free_of_others(clone):
    script = shell_script(clone, Ros(), "python3.11")
    got = enter(script, PATH="/bin", AMENT_PREFIX_PATH="/other", PYTHONPATH="/mine")
    install = clone / "ros2_ws/install"
    assert got["LEXSTACK_ROOT"] == str(clone)
    assert got["PATH"] == f"{clone}/.venv/bin:/bin"
    assert got["AMENT_PREFIX_PATH"] == f"{install}/core:{install}/msgs:{clone}/.venv"
    packages = f"{install}/msgs/lib/python3.11/site-packages"
    assert got["PYTHONPATH"] == f"{clone}/ros2_ws/src/core:{packages}:/mine"
    wheels = f"{clone}/.venv/lib/python3.11/site-packages/ros_rcl.libs"
    assert got["LD_LIBRARY_PATH"] == f"{install}/msgs/lib:{clone}/.venv/lib:{wheels}"
    assert got["RMW_IMPLEMENTATION"] == "rmw_fastrtps_cpp"
    assert got["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "LOCALHOST"


def test_a_home_that_cannot_be_written_is_replaced_so_that_ros_can_log(clone, tmp_path):
    """In a container an unknown account has the home /, or none: ROS ends at //.ros/log."""
    script = shell_script(clone, Ros(), "python3.11")
    own = tmp_path / "home"
    own.mkdir()
    temporary = {"PATH": "/usr/bin:/bin", "TMPDIR": str(tmp_path)}
    assert enter(script, **temporary, HOME=str(own))["HOME"] == str(own)
    for environ in (temporary, {**temporary, "HOME": ""}, {**temporary, "HOME": "/no/such/home"}):
        home = Path(enter(script, **environ)["HOME"])
        assert home == tmp_path / f"lexstack-home-{os.getuid()}"
        assert home.stat().st_mode & 0o777 == 0o700
    # Where another account's folder has that name, an own one is made.
    home.rmdir()
    home.touch()
    other = Path(enter(script, **temporary)["HOME"])
    assert other.is_dir()
    assert other != home


def test_users_discovery_range_is_kept(clone):
    script = shell_script(clone, Ros(), "python3.11")
    got = enter(script, ROS_AUTOMATIC_DISCOVERY_RANGE="SUBNET")
    assert got["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "SUBNET"


def test_native_environment_goes_on_top_of_what_is_sourced(clone):
    script = shell_script(clone, NATIVE, "python3.11")
    got = enter(script, AMENT_PREFIX_PATH="/opt/ros/jazzy", RMW_IMPLEMENTATION="rmw_zenoh_cpp")
    assert got["AMENT_PREFIX_PATH"].endswith(":/opt/ros/jazzy")
    assert str(clone / ".venv:") not in got["AMENT_PREFIX_PATH"] + ":"
    assert got["RMW_IMPLEMENTATION"] == "rmw_zenoh_cpp"


def test_build_sees_no_other_environment_unless_ros_is_native(clone):
    sourced = {"PATH": "/bin", "PYTHONPATH": "/p", "AMENT_PREFIX_PATH": "/opt/ros/jazzy"}
    wheels = build_variables(clone, Ros(), sourced)
    assert "PYTHONPATH" not in wheels
    assert wheels["AMENT_PREFIX_PATH"] == wheels["CMAKE_PREFIX_PATH"] == f"{clone}/.venv"
    native = build_variables(clone, NATIVE, sourced)
    assert native["PYTHONPATH"] == "/p"
    assert native["AMENT_PREFIX_PATH"] == "/opt/ros/jazzy"
    assert native["PATH"] == wheels["PATH"] == f"{clone}/.venv/bin:/bin"
