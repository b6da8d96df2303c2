"""The nodes of a run for users of a native ROS 2: ros2 launch lexstack_bringup run.launch.py.

The plant stands until ``ros2 service call /sim_bridge/pause std_srvs/srv/SetBool "{data: false}"``.
Nothing happens by itself then: events of a scenario are played by ``ros2 run lexstack_bringup
demo``, which starts the same nodes without launch.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from launch.actions import DeclareLaunchArgument, OpaqueFunction, Shutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from launch import LaunchContext, LaunchDescription
from lexstack_bringup.commands.demo import resolve_scenario, run_folder
from lexstack_bringup.naming import Naming
from lexstack_bringup.processes import executable_of, nodes_of, parameters_of
from lexstack_config.own_folder import own_config, own_root

ARGUMENTS = {
    "scenario": ("by-hand", "name of a scenario, or a file"),
    "namespace": ("", "of all nodes and topics, such as cell1"),
    "out": ("", "folder of the run; default: runs/SCENARIO-TIME"),
    "mode": ("", "lockstep or realtime; default: the scenario's"),
}


def generate_launch_description() -> LaunchDescription:
    """Return the arguments, and the nodes that follow from them."""
    declared = [
        DeclareLaunchArgument(name, default_value=default, description=what)
        for name, (default, what) in ARGUMENTS.items()
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=start)])


def start(context: LaunchContext) -> list[Any]:
    """Return the nodes of a run whose scenario is written to its folder."""
    given = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    options = argparse.Namespace(
        scenario=given["scenario"], config=[], mode=given["mode"] or None, seed=None
    )
    named = argparse.Namespace(namespace=given["namespace"], roles=False)
    resolved, naming = resolve_scenario(own_config(), options), Naming.of(named)
    out = run_folder(
        own_root(), Path(given["out"]) if given["out"] else None, resolved.scenario.name
    )
    path, nodes = out / "scenario.yaml", nodes_of(resolved.scenario)
    path.write_text(resolved.to_yaml(), encoding="utf-8")
    return [
        Node(
            package=executable_of(name)[0],
            executable=executable_of(name)[1],
            name=name,
            namespace=naming.namespace,
            parameters=[parameters_of(name, path, out / "bag", nodes)],
            remappings=[("/clock", "clock")] if naming.namespace else [],
            output="screen",
            on_exit=Shutdown(reason=f"{name} has ended"),
        )
        for name in nodes
    ]
