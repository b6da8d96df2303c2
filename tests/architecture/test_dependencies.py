"""What a package imports it declares, for pip and for ROS, and both say the same."""

import shutil
import sys
import xml.etree.ElementTree as ET

import pytest

from support.scenario import ROOT

sys.path.insert(0, str(ROOT / "tests"))
from dependencies import check, packages, pip_requirements, ros_dependencies

PACKAGES = packages()
# Packages of pip that ROS's own list knows by another name; it does not know the others.
KEYS = {
    "jinja2": "python3-jinja2",
    "matplotlib": "python3-matplotlib",
    "numpy": "python3-numpy",
    "pillow": "python3-pil",
    "pyyaml": "python3-yaml",
    "scipy": "python3-scipy",
}


ROSDEP = {
    *KEYS.values(),
    "python3-pytest",
    # Packages of Jazzy; those that this workspace builds itself are left out.
    *("action_msgs", "ament_cmake", "builtin_interfaces", "diagnostic_msgs", "geometry_msgs"),
    *("launch", "launch_ros", "nav_msgs", "rcl_interfaces", "rclpy", "rosgraph_msgs"),
    *("rosidl_default_generators", "rosidl_default_runtime", "sensor_msgs", "std_msgs"),
    *("std_srvs", "trajectory_msgs", "visualization_msgs"),
}
"""Keys of rosdep, by rosdep/python.yaml and jazzy/distribution.yaml of rosdistro."""


def name_of(requirement):
    """Return the name in a requirement, without its version."""
    return requirement.partition(">")[0].strip().lower()


def test_all_packages_are_looked_at():
    assert {"lexstack", "lexstack_config", "lexstack_sim"} <= {path.name for path in PACKAGES}
    messages = 3  # lexstack_interfaces; control_msgs and tf2_msgs for where there are none
    assert len(PACKAGES) == len([*(ROOT / "ros2_ws/src").glob("*/package.xml")]) - messages


@pytest.mark.parametrize("package", PACKAGES, ids=lambda path: path.name)
def test_setup_and_package_xml_name_the_same(package):
    required = {name_of(line) for line in pip_requirements(package)[0]}
    listed = set(ros_dependencies(package))
    ours = {name.replace("-", "_") for name in required if name.startswith("lexstack")}
    assert {n for n in listed if n.startswith("lexstack")} - {"lexstack_interfaces"} == ours
    assert {name for name in listed if name.startswith("python3-")} == {
        KEYS[name] for name in required if name in KEYS
    }


def test_every_key_of_every_package_is_known_to_rosdep():
    """What rosdep could not resolve, it would stop at on a user's machine."""
    files = [*(ROOT / "ros2_ws/src").glob("*/package.xml")]
    own = {file.parent.name for file in files}
    for file in files:
        tags = [e for e in ET.parse(file).getroot() if e.tag.endswith("depend")]
        names = {tag.text for tag in tags}
        assert names - own <= ROSDEP, file.parent.name
        assert len(names) > 0


@pytest.mark.parametrize(
    ("package", "statement", "word"),
    [
        ("lexstack", "import yaml", "'yaml'"),
        ("lexstack", "import rclpy", "'rclpy'"),
        ("lexstack_sim", "import casadi", "'casadi'"),
        ("lexstack_plant", "from visualization_msgs.msg import Marker", "'visualization_msgs'"),
    ],
)
def test_an_import_that_is_not_declared_is_told(tmp_path, package, statement, word):
    copy = tmp_path / package
    shutil.copytree(ROOT / "ros2_ws/src" / package, copy)
    with (copy / package / "__init__.py").open("a") as file:
        file.write(f"\n{statement}\n")
    assert word in check(copy)


def test_a_dependency_that_is_not_used_is_told(tmp_path):
    copy = tmp_path / "lexstack_config"
    shutil.copytree(ROOT / "ros2_ws/src/lexstack_config", copy)
    setup = copy / "setup.py"
    setup.write_text(setup.read_text().replace('"numpy>=2"', '"numpy>=2", "mujoco"'))
    assert "'mujoco' defined as a dependency but not used" in check(copy)
