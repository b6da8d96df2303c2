"""A sequence with a goal of a frame and one of joints, sent through the action and carried out."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from rclpy.action import ActionClient
from std_srvs.srv import SetBool

from lexstack.mpc import SequenceTask
from lexstack_bag.replay.changes import Changes
from lexstack_bag.replay.nodes import REPLAYERS, Question
from lexstack_bag.run.reader import read_run
from lexstack_config.resolved import load_scenario
from lexstack_interfaces.action import ExecuteSequence
from lexstack_ros.messages.plans import task_message
from lexstack_testing.played_run import together
from lexstack_testing.user import User
from support.scenario import CONFIG, team

pytestmark = pytest.mark.system
FRAME, MODEL = "panda_link5", team().robots[0]
ARM, JOINT = slice(3, 10), 5  # of robot_a in q; a wrist
BY = np.array([0.5, 0.3, -0.1])  # m: farther than the arm reaches without its base
NEAR, TURNED = 0.02, 0.05  # m, rad


@pytest.fixture(scope="module")
def executed(tmp_path_factory):
    """Return what was asked, the states until both goals are met, what was told, the folder."""
    resolved = load_scenario(CONFIG / "scenarios/deliver-one.yaml")
    values = {"events": (), "duration": 3000.0}
    resolved = dataclasses.replace(
        resolved, scenario=dataclasses.replace(resolved.scenario, **values)
    )
    folder, told = tmp_path_factory.mktemp("run"), []
    with together(resolved, folder) as run:
        user = User(run)
        client = ActionClient(user.node, ExecuteSequence, "/htmpc/execute_sequence")
        assert user.call(SetBool, "/sim_bridge/pause", data=False).success
        user.until(lambda: user.commands and client.server_is_ready())
        user.spin(0.5)
        asked = tasks(user.states[-1])
        goal = ExecuteSequence.Goal(robot="robot_a", tasks=list(map(task_message, asked)))
        sent = client.send_goal_async(goal, lambda m: told.append(m.feedback.status))
        user.until(sent.done, "an answer")
        assert sent.result().accepted
        answer = sent.result().get_result_async()
        user.patience = 120.0  # s
        user.until(answer.done, "the result")
        states = list(user.states)
        user.until(lambda: user.status().to_stack != "plan_robot_a", "the way back")
        assert run.end() == []
    return asked, states, told, answer.result().result, folder


def tasks(state):
    """Return a goal of a link, and then one of a joint of the wrist."""
    place = link(state) + BY
    wrist = float(np.array(state.q_star)[ARM][JOINT]) + 0.4
    name = MODEL.joints[MODEL.arm][JOINT]
    return (
        SequenceTask("elbow", "ee_position", (tuple(place),), tolerance=NEAR, frame=FRAME),
        SequenceTask(
            "wrist", "joint_positions", ((wrist,),), tolerance_angle=TURNED, joints=(name,)
        ),
    )


def link(state):
    """Return where the commands have brought the link [m]: by that the MPC judges."""
    return MODEL.at(np.array(state.q_star)[:10], MODEL.frame(FRAME))[0].position


def test_both_goals_are_met(executed):
    (elbow, wrist), states, told, result, _ = executed
    assert (result.success, result.done, result.message) == (True, 2, "")
    assert list(dict.fromkeys(status.task for status in told))[:2] == ["elbow", "wrist"]
    ways = [np.linalg.norm(link(state) - elbow.points[0]) for state in states]
    assert ways[0] > 0.5
    assert min(ways) < NEAR
    joint = [np.array(state.q_star)[ARM][JOINT] for state in states]
    assert abs(joint[0] - wrist.points[0][0]) > 0.3
    assert joint[-1] == pytest.approx(wrist.points[0][0], abs=TURNED)
    moved = np.abs(np.subtract(states[-1].q, states[-1].q_star)).max()
    assert moved < 0.05, "the robot is where the commands have it"


def test_the_run_is_replayed_bit_for_bit(executed):
    run = read_run(executed[-1])
    for node in REPLAYERS:
        found = REPLAYERS[node](Question(run, Changes(), run.resolved))
        assert found.identical, found.line()
