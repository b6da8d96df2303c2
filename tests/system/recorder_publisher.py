"""Publishes a known number of messages once a recorder listens; prints the counts as JSON."""

from __future__ import annotations

import json
import sys
import time
from array import array

import rclpy
from geometry_msgs.msg import PoseStamped
from rclpy.duration import Duration
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from std_msgs.msg import String

from lexstack_interfaces.msg import Chi, PlantState

COUNT = int(sys.argv[1])
HEARD = sys.argv[2:]  # topics that the recorder shall listen to; none: all
ROBOTS = ["robot_a", "robot_b"]
Q = array("d", [0.25] * 20)


def main() -> None:
    """Publish, wait until everything has arrived, and say what was sent."""
    rclpy.init()
    node = rclpy.create_node("publisher")
    reliable = QoSProfile(depth=1000)
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    careless = QoSProfile(depth=100, reliability=ReliabilityPolicy.BEST_EFFORT)
    publishers = {
        "/plant/state": node.create_publisher(PlantState, "/plant/state", reliable),
        "/robot_a/chi": node.create_publisher(Chi, "/robot_a/chi", reliable),
        "/robot_a/robot_description": node.create_publisher(
            String, "/robot_a/robot_description", latched
        ),
        "/found/by/itself": node.create_publisher(String, "/found/by/itself", careless),
    }
    publishers["/robot_b/ee_target"] = node.create_publisher(
        PoseStamped, "/robot_b/ee_target", careless
    )
    publishers["/robot_a/robot_description"].publish(String(data="<robot/>"))
    deadline = time.monotonic() + 20.0
    heard = [publishers[topic] for topic in HEARD or publishers]
    while not all(publisher.get_subscription_count() for publisher in heard):
        if time.monotonic() > deadline:
            sys.exit("the recorder did not subscribe to everything")
        time.sleep(0.02)
    time.sleep(0.3)  # matching is mutual: the recorder must know of the publishers, too
    publishers["/robot_b/ee_target"].publish(PoseStamped())
    time.sleep(0.1)  # best effort: alone
    for tick in range(COUNT):
        state = PlantState(tick=tick, robots=ROBOTS, q=Q, v=Q, q_star=Q, command=Q)
        state.header.stamp.sec, state.header.stamp.nanosec = divmod(tick * 10_000_000, 10**9)
        publishers["/plant/state"].publish(state)
        publishers["/robot_a/chi"].publish(
            Chi(header=state.header, tick=tick, robots=ROBOTS, chi=Q, lower=Q, upper=Q)
        )
        if tick % 10 == 0:
            publishers["/found/by/itself"].publish(String(data=str(tick)))
        time.sleep(0.0005)
    for publisher in (publishers["/plant/state"], publishers["/robot_a/chi"]):
        publisher.wait_for_all_acked(Duration(seconds=10.0))
    counts = {
        "/plant/state": COUNT,
        "/robot_a/chi": COUNT,
        "/robot_a/robot_description": 1,
        "/robot_b/ee_target": 1,
        "/found/by/itself": -(-COUNT // 10),
    }
    print(json.dumps(counts), flush=True)
    sys.stdin.readline()  # stay until the recorder has been stopped
    node.destroy_node()
    rclpy.shutdown()


main()
