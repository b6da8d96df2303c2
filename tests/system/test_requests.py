"""The controller's topics and services, as a user calls them, without our player's events."""

import numpy as np
import pytest
from geometry_msgs.msg import PoseStamped
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from std_msgs.msg import String
from std_srvs.srv import SetBool, Trigger

from lexstack_interfaces.msg import Chi, PlantState, TransitionStatus
from lexstack_interfaces.srv import SwitchStack
from lexstack_testing.played_run import together
from lexstack_testing.user import User
from support.runs import short_scenario

pytestmark = pytest.mark.system


@pytest.fixture(scope="module")
def user(tmp_path_factory):
    """Return a user of a long run without events."""
    scenario = short_scenario(events=(), duration=3000.0)
    with together(scenario, tmp_path_factory.mktemp("run")) as run:
        user = User(run)
        assert user.call(SetBool, "/sim_bridge/pause", data=False).success
        user.until(lambda: user.statuses)
        yield user


def test_a_switch_by_service_is_answered_at_once_and_adopted(user):
    answer = user.call(SwitchStack, "/robot_a/switch_stack", stack="reach_base", duration=0.3)
    assert answer.accepted
    assert answer.id > 0
    user.until(lambda: user.status().id == answer.id)
    user.until(lambda: user.status().phase == TransitionStatus.IDLE)
    assert user.status().to_stack == "reach_base"


@pytest.mark.parametrize(
    ("request_", "reason"),
    [
        ({"stack": "dance"}, "unknown stack 'dance'; known: "),
        ({"stack": ""}, "unknown stack ''"),
        ({"stack": "track", "duration": -1.0}, "duration: must be in"),
        ({"stack": "track", "duration": float("nan")}, "duration: must be in"),
        ({"stack": "track", "method": "jump"}, "unknown method 'jump'"),
        ({"stack": "track", "at_tick": 1}, "at_tick: 1 is over"),
    ],
)
def test_a_wrong_switch_is_refused_with_its_reason(user, request_, reason):
    answer = user.call(SwitchStack, "/robot_a/switch_stack", **request_)
    assert not answer.accepted
    assert answer.id == 0
    assert reason in answer.message


def test_a_switch_by_topic_needs_no_own_interfaces(user):
    before = user.status().id
    user.publisher(String, "/robot_a/request_stack").publish(String(data="posture"))
    user.until(lambda: user.status().id > before and user.status().phase == TransitionStatus.IDLE)
    assert user.status().to_stack == "posture"


def test_a_refused_switch_by_topic_is_told_in_the_transition(user):
    before = user.status()
    user.publisher(String, "/robot_a/request_stack").publish(String(data="dance"))
    user.until(lambda: "unknown stack 'dance'" in user.status().reason)
    assert user.status().to_stack == before.to_stack


def test_parameters_change_what_an_empty_request_stands_for(user):
    def set_parameter(value):
        parameter = Parameter(name="transition_duration", value=value)
        if isinstance(value, str):
            parameter = Parameter(name="transition_method", value=value)
        answer = user.call(
            SetParameters,
            "/hqp_controller/set_parameters",
            parameters=[parameter.to_parameter_msg()],
        )
        return answer.results[0]

    assert not set_parameter(-1.0).successful
    assert "unknown method 'jump'; known: bridge" in set_parameter("jump").reason
    assert set_parameter(0.25).successful
    assert user.call(SwitchStack, "/robot_a/switch_stack", stack="posture").accepted
    told = user.until_told(lambda status: status.phase == TransitionStatus.BLENDING)
    assert told.duration == 0.25
    user.until(lambda: user.status().phase == TransitionStatus.IDLE)


def test_cancel_goes_back(user):
    refused = user.call(Trigger, "/robot_a/cancel_transition")
    assert not refused.success
    assert refused.message == "there is no transition to cancel"
    origin = user.status().to_stack
    assert user.call(SwitchStack, "/robot_a/switch_stack", stack="track", duration=5.0).accepted
    user.until_told(lambda status: status.phase == TransitionStatus.BLENDING)
    assert user.call(Trigger, "/robot_a/cancel_transition").success
    user.until(lambda: any(s.phase == TransitionStatus.ABORTED for s in user.statuses))
    user.until(lambda: user.status().phase == TransitionStatus.IDLE)
    assert user.status().to_stack == origin


def test_a_target_moves_the_tool(user):
    assert user.call(SwitchStack, "/robot_a/switch_stack", stack="track", duration=0.2).accepted
    user.until(lambda: user.status().to_stack == "track" and user.status().phase == 0)
    poses = user.hear(PoseStamped, "/robot_a/ee_pose", [])
    user.until(lambda: poses)
    goal = poses[-1]
    goal.header.stamp.sec = goal.header.stamp.nanosec = 0
    goal.pose.position.x += 0.05
    user.publisher(PoseStamped, "/robot_a/ee_target").publish(goal)
    user.until(lambda: abs(poses[-1].pose.position.x - goal.pose.position.x) < 2e-3)


def test_wrong_messages_do_not_move_a_robot(user, capfd):
    """NaN, a wrong length, wrong robots and foreign ticks, on every topic that both hear."""
    calm = np.array(user.commands[-1].chi)
    seen = len(user.commands)
    send_wrong_messages(user)
    sent = len(user.commands)
    user.until(lambda: len(user.commands) > sent + 50)
    heard = user.commands[seen:]
    assert np.abs(np.array([m.chi for m in heard]) - calm).max() < 0.05
    assert heard[-1].tick - heard[0].tick < len(heard) + 5, "none left out"
    assert "refused: " in capfd.readouterr().err


def send_wrong_messages(user):
    """Send each of them once."""
    states = user.publisher(PlantState, "/plant/state")
    last = user.states[-1]
    for change in (
        {"q": [float("nan")] * 20},
        {"q": [0.0] * 3},
        {"robots": ["x"]},
        {"tick": 2, "q": [9.0] * 20},  # long over
    ):
        bad = PlantState(tick=last.tick + 1, robots=last.robots, q=last.q, v=last.v)
        bad.q_star, bad.command = last.q_star, last.command
        for field, value in change.items():
            setattr(bad, field, value)
        states.publish(bad)
    source = user.publisher(Chi, "/robot_b/chi")
    source.publish(Chi(robots=last.robots, chi=[float("nan")] * 20))
    source.publish(Chi(robots=last.robots, chi=[1.0] * 20, transition_id=999, tick=last.tick))
    targets = user.publisher(PoseStamped, "/robot_a/ee_target")
    wrong = PoseStamped()
    wrong.pose.position.x = float("nan")
    targets.publish(wrong)
