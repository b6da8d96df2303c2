"""The set-up: which ROS, which Python, which packages, which include paths."""

import pytest

from workspace.errors import SetupError
from workspace.ros import (
    Ros,
    brought_along,
    find_ros,
    patch_cmake,
    python_version,
    select_packages,
    split_lock,
)

LOCK = """\
# a header
daqp==0.11.0 \\
    --hash=sha256:aa
    # via -r requirements.txt
ros-jazzy-rclpy==7.1.6 \\
    --hash=sha256:bb
ros-std-msgs==5.3.6 ; sys_platform == 'linux' \\
    --hash=sha256:cc \\
    --hash=sha256:dd
rosbags==0.11.9 \\
    --hash=sha256:ee
"""


@pytest.fixture
def native(tmp_path):
    """Return a prefix that looks like a native Jazzy."""
    (tmp_path / "jazzy/lib/python3.12/site-packages/rclpy").mkdir(parents=True)
    return tmp_path / "jazzy"


@pytest.mark.parametrize("environ", [{}, {"ROS_DISTRO": ""}, {"AMENT_PREFIX_PATH": "/some/where"}])
def test_without_a_sourced_ros_it_comes_from_wheels(environ):
    assert find_ros(environ) == Ros()


def test_native_jazzy_is_used_with_its_own_python(native, tmp_path):
    overlay = tmp_path / "overlay"
    environ = {"ROS_DISTRO": "jazzy", "AMENT_PREFIX_PATH": f"{overlay}:{native}"}
    assert find_ros(environ) == Ros(native, ((3, 12),))


@pytest.mark.parametrize("distro", ["humble", "rolling"])
def test_another_distribution_is_refused_by_name(distro, native):
    with pytest.raises(SetupError, match=distro):
        find_ros({"ROS_DISTRO": distro, "AMENT_PREFIX_PATH": str(native)})


@pytest.mark.parametrize("prefixes", ["", "/no/such/folder"])
def test_jazzy_without_rclpy_is_refused(prefixes):
    with pytest.raises(SetupError, match="rclpy"):
        find_ros({"ROS_DISTRO": "jazzy", "AMENT_PREFIX_PATH": prefixes})


def test_jazzy_for_an_unsupported_python_is_refused(tmp_path):
    (tmp_path / "lib/python3.9/site-packages/rclpy").mkdir(parents=True)
    with pytest.raises(SetupError, match=r"3\.11 to 3\.13"):
        find_ros({"ROS_DISTRO": "jazzy", "AMENT_PREFIX_PATH": str(tmp_path)})


def test_packages_that_a_native_ros_has_itself_are_not_built(native):
    assert brought_along(Ros()) == ()
    assert brought_along(Ros(native)) == (), "it may be a small installation"
    (native / "share/tf2_msgs").mkdir(parents=True)
    assert brought_along(Ros(native)) == ("tf2_msgs",)
    (native / "share/control_msgs").mkdir(parents=True)
    assert brought_along(Ros(native)) == ("control_msgs", "tf2_msgs")


def test_python_version_is_compared_as_numbers():
    assert python_version("python3.9") < python_version("python3.11") == (3, 11)


def test_lock_is_split_into_whole_entries():
    entries = split_lock(LOCK)
    assert list(entries) == ["daqp", "ros-jazzy-rclpy", "ros-std-msgs", "rosbags"]
    assert entries["ros-std-msgs"].count("--hash") == 2


def test_wheels_take_the_whole_lock():
    assert list(split_lock(select_packages(LOCK, Ros()))) == list(split_lock(LOCK))


def test_native_ros_takes_all_but_the_ros_wheels(native):
    assert list(split_lock(select_packages(LOCK, Ros(native)))) == ["daqp", "rosbags"]


def test_cmake_files_get_this_machines_include_paths():
    text = (
        'INTERFACE_INCLUDE_DIRECTORIES "/opt/python/cp311-cp311/include/python3.11;'
        '/opt/python/cp311-cp311/lib/python3.11/site-packages/numpy/_core/include;${_DIR}/include"'
    )
    patched = patch_cmake(text, "/py/include", r"/np\1/include")
    expected = r'INTERFACE_INCLUDE_DIRECTORIES "/py/include;/np\1/include;${_DIR}/include"'
    assert patched == expected
    assert patch_cmake(patched, "/py/include", r"/np\1/include") == expected


def test_a_package_with_a_pin_for_each_python_keeps_them_all():
    lock = (
        "contourpy==1.3.3 ; python_full_version < '3.12' \\\n    --hash=sha256:aa\n"
        "contourpy==1.4.0 ; python_full_version >= '3.12' \\\n    --hash=sha256:bb\n"
    )
    assert select_packages(lock, Ros()) == lock
