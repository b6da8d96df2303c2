"""The nodes of the launch file run: by launch where it is, otherwise as it would start them."""

from __future__ import annotations

import pytest
import rclpy
from std_srvs.srv import SetBool

from lexstack_bag.run.reader import read_run
from lexstack_bringup.supervisor import Supervisor
from lexstack_interfaces.msg import Chi
from lexstack_ros.messages.qos import STREAM
from lexstack_ros.node.calls import call, wait_until
from lexstack_ros.node.readiness import READY
from lexstack_testing.ros_session import ros_session
from support.launch_file import IS_HERE, LAUNCH, command_line, loaded, stand_in

pytestmark = pytest.mark.system
CELL = "cell1"
PATIENCE = 90.0  # s
SERVICE = f"""
import sys
from launch import LaunchDescription, LaunchService
from launch.actions import IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource
given = [tuple(word.split(":=", 1)) for word in sys.argv[1:]]
source = PythonLaunchDescriptionSource({str(LAUNCH)!r})
service = LaunchService()
service.include_launch_description(
    LaunchDescription([IncludeLaunchDescription(source, launch_arguments=given)])
)
sys.exit(service.run())
"""


def start(supervisor, given, folder, monkeypatch):
    """Start what the launch file says."""
    if IS_HERE:
        module = folder / "by_launch.py"
        module.write_text(SERVICE, encoding="utf-8")
        monkeypatch.syspath_prepend(folder)
        supervisor.start("launch", module.stem, [f"{key}:={value}" for key, value in given.items()])
        return
    stand_in(monkeypatch)
    nodes = loaded().start(given)
    for node in nodes:
        module, arguments = command_line(node, folder)
        supervisor.start(node.name, module, arguments)
    supervisor.wait_printed([node.name for node in nodes], READY, PATIENCE)


def test_the_nodes_of_the_launch_file_run_in_their_namespace(tmp_path, monkeypatch):
    given = {
        "scenario": "transition-sequence",
        "namespace": CELL,
        "out": str(tmp_path / "run"),
        "mode": "lockstep",
    }
    heard = []
    with ros_session(children=True) as context:
        supervisor = Supervisor(tmp_path / "logs")
        try:
            start(supervisor, given, tmp_path, monkeypatch)
            node = rclpy.create_node("looks", context=context, namespace=CELL)
            node.create_subscription(Chi, "robot_a/chi", heard.append, STREAM)
            executor = rclpy.executors.SingleThreadedExecutor(context=context)
            executor.add_node(node)
            request = SetBool.Request(data=False)
            asked = (SetBool, f"/{CELL}/sim_bridge/pause", request)
            assert call(node, executor, *asked, PATIENCE, watch=supervisor.check).success
            assert wait_until(executor, lambda: len(heard) > 200, PATIENCE, supervisor.check)
            topics = {name for name, _ in node.get_topic_names_and_types()}
            own = {name for name in topics if name.startswith(f"/{CELL}/")}
            assert topics - own <= {"/rosout", "/parameter_events"}
            executor.shutdown()
            node.destroy_node()
        finally:
            killed = supervisor.end()
    assert killed == []
    assert all(child.process.returncode == 0 for child in supervisor.children)
    run = read_run(tmp_path / "run")
    assert len(run.chi["robot_a"].tick) > 200
