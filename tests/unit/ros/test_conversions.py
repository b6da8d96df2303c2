"""The seam between messages and the library: nothing that does not fit gets through."""

import numpy as np
import pytest
from geometry_msgs.msg import PoseStamped

from lexstack.errors import InputError
from lexstack.robots import Pose, from_rpy, to_quaternion
from lexstack.transition import Announcement
from lexstack_experiments.loop import Loop
from lexstack_interfaces.msg import Chi, PlantState, StackRequest, TransitionStatus
from lexstack_ros.messages import conversions
from support.scenario import home, resolved, team


def plant_state():
    message = PlantState(robots=list(team().names), tick=7)
    message.header.stamp = conversions.to_time(0.07)
    for name in ("q", "v", "q_star", "command"):
        setattr(message, name, conversions.to_array(np.arange(20.0)))
    return message


def test_a_state_comes_through():
    state = conversions.to_state(plant_state(), team())
    assert (state.tick, state.stamp) == (7, pytest.approx(0.07))
    for name in ("q", "v", "q_star", "command"):
        np.testing.assert_array_equal(getattr(state, name), np.arange(20.0))


@pytest.mark.parametrize("field", ["q", "v", "q_star", "command"])
@pytest.mark.parametrize(
    ("values", "what"),
    [
        ([0.0] * 19, "expected 20 values, got 19"),
        ([], "expected 20 values, got 0"),
        ([0.0] * 19 + [float("nan")], "[19]: must be finite, got nan"),
        ([float("inf")] + [0.0] * 19, "[0]: must be finite, got inf"),
    ],
)
def test_a_wrong_vector_is_named(field, values, what):
    message = plant_state()
    setattr(message, field, values)
    with pytest.raises(InputError) as error:
        conversions.to_state(message, team())
    assert str(error.value).startswith(f"/plant/state: {field}")
    assert what in str(error.value)


@pytest.mark.parametrize("robots", [[], ["robot_b", "robot_a"], ["robot_a"]])
def test_a_message_about_other_robots_is_refused(robots):
    message = plant_state()
    message.robots = robots
    with pytest.raises(InputError, match="robots: expected robot_a, robot_b, got"):
        conversions.to_state(message, team())


def test_chi_becomes_a_sample():
    message = Chi(robots=list(team().names), tick=3, transition_id=2, status=Chi.SOLVED)
    message.chi = conversions.to_array(np.ones(20))
    sample = conversions.to_sample(message, team(), "/robot_b/chi")
    assert (sample.transition_id, sample.tick, sample.solved) == (2, 3, True)
    message.status = Chi.FAILED
    assert not conversions.to_sample(message, team(), "/robot_b/chi").solved
    message.chi = conversions.to_array(np.full(20, np.nan))
    with pytest.raises(InputError, match=r"/robot_b/chi: chi\[0\]: must be finite"):
        conversions.to_sample(message, team(), "/robot_b/chi")


def test_a_command_and_its_transition_go_out():
    loop = Loop(resolved())
    loop.controller.transition.ask("posture", 0.0, "", 1)
    loop.run(5)
    command = loop.record.commands[-1]
    chi = conversions.chi_of_command(command, Chi())
    np.testing.assert_array_equal(chi.chi, command.chi)
    np.testing.assert_array_equal(chi.lower, command.bounds.lower)
    assert (chi.tick, chi.stack, chi.transition_id) == (4, "posture", command.transition.id)
    assert (chi.status, chi.empty_bounds, chi.reason) == (Chi.SOLVED, 0, "")
    status = conversions.transition_status(command, command.transition)
    assert list(chi.transitions) == [status]
    assert status.robots == list(team().names)
    assert status.phase == TransitionStatus.BLENDING
    assert (status.from_stack, status.to_stack, status.source) == ("track", "posture", "robot_b")
    assert status.alpha == command.transition.alpha > 0.0


def test_phases_have_the_numbers_of_the_message():
    from lexstack.transition import Phase

    for phase in Phase:
        assert getattr(TransitionStatus, phase.name) == phase.value


def test_requests_to_a_source_go_there_and_back():
    announcement = Announcement(4, "posture", 17, active=True, robots=(1,))
    message = conversions.stack_request(announcement, 0.1, team())
    assert list(message.robots) == ["robot_b"]
    assert conversions.to_announcement(message, ("posture",), team()) == announcement
    with pytest.raises(InputError, match="unknown stack 'dance'; known: posture"):
        conversions.to_announcement(StackRequest(stack="dance"), ("posture",), team())
    message.robots = ["robot_z"]
    with pytest.raises(InputError, match="robots: unknown robot 'robot_z'; known: robot_a"):
        conversions.to_announcement(message, ("posture",), team())


def target(position=(1.0, 2.0, 3.0), rpy=(0.0, 0.0, 0.0), frame="world"):
    rotation = from_rpy(rpy)
    pose = Pose(np.array(position), rotation)
    message = conversions.pose_message(pose, 1.5, to_quaternion(rotation))
    message.header.frame_id = frame
    return message


def test_targets_come_through():
    got = conversions.to_ee_target(target(rpy=(0.1, 0.2, 0.3)), 1, "/robot_b/ee_target")
    assert (got.at, got.robot, got.base) == (pytest.approx(1.5), 1, None)
    np.testing.assert_allclose(got.ee.rotation, from_rpy((0.1, 0.2, 0.3)), atol=1e-9)
    got = conversions.to_base_target(target(rpy=(0.0, 0.0, 0.7)), 0, "/robot_a/base_target")
    np.testing.assert_allclose(got.base, [1.0, 2.0, 0.7], atol=1e-9)
    conversions.to_ee_target(target(frame=""), 0, "no frame means world")


@pytest.mark.parametrize(
    ("message", "what"),
    [
        (target(frame="map"), "frame_id: expected 'world', got 'map'"),
        (target(position=(np.nan, 0.0, 0.0)), "position[0]: must be finite"),
        (target(position=(5000.0, 0.0, 0.0)), "position: 5000 m away"),
        (PoseStamped(), None),
    ],
)
def test_a_wrong_target_is_named(message, what):
    message.pose.orientation.w = 1.0
    if what is None:
        message.pose.orientation.w = 0.5
        what = "orientation: norm must be 1, got 0.5"
    with pytest.raises(InputError) as error:
        conversions.to_ee_target(message, 0, "/robot_a/ee_target")
    assert f"/robot_a/ee_target: {what}" in str(error.value)


def test_a_tilted_base_is_refused():
    with pytest.raises(InputError, match=r"a tilt of 0\.500 rad"):
        conversions.to_base_target(target(rpy=(0.5, 0.0, 0.0)), 0, "/robot_a/base_target")


@pytest.mark.parametrize("seconds", [0.0, 0.01, 1.0, 17.0, 123.456789])
def test_time_goes_there_and_back(seconds):
    assert conversions.to_seconds(conversions.to_time(seconds)) == pytest.approx(seconds, abs=1e-9)


def test_home_is_a_state():
    message = plant_state()
    message.q = conversions.to_array(home())
    np.testing.assert_array_equal(conversions.to_state(message, team()).q, home())


def test_a_chi_of_some_robots_leaves_the_others_at_rest():
    second = team().slices[1]
    n = second.stop - second.start
    message = Chi(robots=["robot_b"], stack="track", chi=np.arange(1.0, n + 1.0).tolist())
    sample = conversions.to_sample(message, team(), "/robot_b/chi")
    assert (sample.robots, sample.stack) == ((1,), "track")
    np.testing.assert_array_equal(sample.chi[second], np.arange(1.0, n + 1.0))
    assert not sample.chi[team().slices[0]].any()


@pytest.mark.parametrize(
    "robots",
    [[], ["robot_b", "robot_a"], ["robot_a", "robot_a"], ["robot_c"], ["robot_a", "robot_c"]],
)
def test_a_chi_of_other_robots_is_refused(robots):
    message = Chi(robots=robots, chi=[0.0] * team().n)
    with pytest.raises(InputError, match="robots: expected some of robot_a, robot_b"):
        conversions.to_sample(message, team(), "/robot_b/chi")
