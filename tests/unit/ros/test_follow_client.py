"""What the MPC's node knows of the controller, without decoding what comes at every tick."""

from __future__ import annotations

from rclpy.node import Node
from rclpy.serialization import serialize_message

from lexstack_interfaces.msg import StackRequest, TransitionStatus
from lexstack_ros.planner.follow_client import FollowClient
from lexstack_testing.ros_session import ros_session
from support.scenario import resolved, team


def status(robots, from_stack, to_stack, phase):
    return serialize_message(
        TransitionStatus(robots=robots, from_stack=from_stack, to_stack=to_stack, phase=phase)
    )


def test_the_newest_status_of_a_robot_says_on_which_stack_it_is():
    with ros_session(children=False) as context:
        node = Node("planner", context=context)
        client = FollowClient(node, team(), resolved(), lambda *_: None)
        assert client.stack(0) == ""
        hear = client._hear
        hear(status(["robot_a", "robot_b"], "track", "track", TransitionStatus.IDLE))
        assert (client.stack(0), client.stack(1)) == ("track", "track")
        hear(status(["robot_b"], "track", "posture", TransitionStatus.PREPARING))
        hear(status(["robot_a"], "track", "reach_base", TransitionStatus.BLENDING))
        assert (client.stack(0), client.stack(1)) == ("reach_base", "track")
        hear(b"\x00\x01\x00\x00no message")
        assert (client.stack(0), client.stack(1)) == ("reach_base", "track")
        for _ in range(2):
            hear(status(["robot_a"], "track", "reach_base", TransitionStatus.ADOPTING))
            hear(status(["robot_b"], "track", "posture", TransitionStatus.BLENDING))
        assert (client.stack(0), client.stack(1)) == ("reach_base", "posture")
        assert len(client._statuses) == 2 * len(team().names), "no more is kept than is needed"
        node.destroy_node()


class Job:
    robot, at_tick, origin = 0, 5, ""


def test_the_way_back_leads_to_a_stack_that_a_user_sent():
    with ros_session(children=False) as context:
        node = Node("planner", context=context)
        client = FollowClient(node, team(), resolved(), lambda *_: None)
        client._hear(status(["robot_a"], "sent", "sent", TransitionStatus.IDLE))
        client.begin(unknown := Job())
        assert unknown.origin == resolved().scenario.initial_stack
        client._on_announced(StackRequest(stack="sent", stack_yaml="name: sent"))
        client.begin(known := Job())
        assert known.origin == "sent"
        node.destroy_node()
