"""A node that starts loads what it needs for its first tick, and nothing besides."""

import json
import subprocess
import sys

import pytest

from lexstack_bringup.processes import ADAPTER, MODULES, RECORDER
from lexstack_config.resolved import load_scenario
from support.scenario import CONFIG

SCENARIO = CONFIG / "scenarios" / "deliver-both.yaml"  # it needs every node

SLOW = ("viser", "scipy.linalg", "scipy.optimize", "scipy.special", "glfw", "rosbags", "matplotlib")
NOT_TO_BE_LOADED = {
    **dict.fromkeys(MODULES, (*SLOW, "casadi")),
    # numba loads scipy.linalg for its own linear algebra, whether the kernel has any or not.
    **dict.fromkeys(
        ("hqp_controller", "stack_solver", "htmpc"),
        (*(name for name in SLOW if name != "scipy.linalg"), "casadi", "lexstack_sim"),
    ),
    RECORDER: (*SLOW, "casadi", "pinocchio", "lexstack_bag.run.reader"),
}
LOADED = {"sim_bridge": "mujoco", "hqp_controller": "pinocchio", "stack_solver": "daqp"}
MAKE = """
import importlib, inspect, json, sys
import rclpy
from rclpy.node import Node
rclpy.init(args=sys.argv[1:])
module = importlib.import_module(sys.argv[1])
(kind,) = (
    value
    for _, value in inspect.getmembers(module, inspect.isclass)
    if issubclass(value, Node) and value.__module__ == module.__name__
)
kind()
print(json.dumps([name for name in sys.modules]))
"""


ARM = """
name: own
description: An arm on a table.
robots: {arm: {model: kinova, base: [0.5, 0.0, 1.0], z: 0.7}}
rate: 100.0
duration: 2.0
initial_stack: track
transition: {duration: 0.5}
htmpc: {always: true}
"""


@pytest.mark.parametrize("node", ["hqp_controller", "stack_solver", "htmpc"])
def test_nodes_start_for_an_arm_on_a_table(tmp_path, node):
    path = tmp_path / "own.yaml"
    path.write_text(ARM, encoding="utf-8")
    path.write_text(load_scenario(path, CONFIG).to_yaml(), encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-c", MAKE, MODULES[node], "--ros-args", "-p", f"scenario:={path}"],
        capture_output=True,
        text=True,
        timeout=100,
        check=False,
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("node", MODULES)
def test_a_node_is_made_without_modules_that_are_slow_to_load(tmp_path, node):
    path = tmp_path / "scenario.yaml"
    path.write_text(load_scenario(SCENARIO).to_yaml(), encoding="utf-8")
    given = ["-p", f"scenario:={path}"]
    if node == ADAPTER:
        given += ["-p", f"plant:={CONFIG / 'plants/two_pandas.yaml'}"]
    if node == RECORDER:
        given += ["-p", f"output:={tmp_path / 'bag'}"]
    done = subprocess.run(
        [sys.executable, "-c", MAKE, MODULES[node], "--ros-args", *given],
        capture_output=True,
        text=True,
        timeout=100,
        check=True,
    )
    loaded = set(json.loads(done.stdout.splitlines()[-1]))
    assert [name for name in NOT_TO_BE_LOADED[node] if name in loaded] == []
    assert MODULES[node] in loaded
    assert LOADED.get(node, "rclpy") in loaded
