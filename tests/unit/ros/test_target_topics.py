"""Topics of targets: what fits is taken, what does not is refused in one line and counted."""

import math
from dataclasses import replace

import numpy as np
import pytest
from geometry_msgs.msg import (
    PoseStamped,
    Transform,
    TransformStamped,
    Twist,
    TwistStamped,
)
from nav_msgs.msg import Path
from rclpy.serialization import serialize_message
from tf2_msgs.msg import TFMessage
from trajectory_msgs.msg import (
    JointTrajectory,
    JointTrajectoryPoint,
    MultiDOFJointTrajectory,
    MultiDOFJointTrajectoryPoint,
)

from lexstack.references import ReferenceSchedule, measured
from lexstack.robots import RobotModel, Team, to_quaternion
from lexstack.tasks import LevelConfig, StackConfig, TaskConfig
from lexstack_config.reference_topics import ReferenceTopicsConfig
from lexstack_config.resolved import load_robot
from lexstack_ros.controller.target_topics import TargetTopics
from lexstack_ros.intake import transform_topics
from lexstack_ros.messages.conversions import to_time
from support.scenario import CONFIG, home, state_at, team

ELBOW = "panda_link4"
STACK = StackConfig(
    "elbow", "", (LevelConfig((TaskConfig("frame_pose", "robot_a", parameters={"frame": ELBOW}),)),)
)


class Node:
    """Stands in for a node: keeps who listens to what, and what is said."""

    def __init__(self):
        self.listeners, self.said = {}, []

    def create_subscription(self, kind, topic, take, _qos, **_how):
        self.listeners[f"/{topic}"] = kind, take  # relative, in no namespace

    def get_logger(self):
        return self

    def warning(self, text, **_how):
        self.said.append(text)


class Bench:
    """Topics, a schedule, and time that goes on."""

    def __init__(self, lead_in=0.5):
        self.node = Node()
        self.schedule = ReferenceSchedule(
            measured(team(), home()), lead_in=lead_in, horizon=60.0, dt=team().dt
        )
        options = ReferenceTopicsConfig()
        self.topics = TargetTopics(self.node, team(), self.schedule, options, [STACK])
        self.tick = -1
        self.go()

    def go(self, ticks=1, q=None):
        for _ in range(ticks):
            self.tick += 1
            state = state_at(home() if q is None else q, tick=self.tick)
            self.topics.see(state)
            self.schedule.decide(state.stamp + team().dt)
        return self

    def send(self, topic, message):
        kind, take = self.node.listeners[topic]
        assert isinstance(message, kind)
        take(message)
        return self

    def at(self, stamp):
        return self.schedule.timeline.newest.references(stamp)

    def refused(self):
        assert self.topics.refused == len(self.node.said) == 1
        return self.node.said[0]


@pytest.fixture
def bench():
    return Bench()


def tool(robot=0):
    return team().tools(home())[robot]


def header(message, frame="", stamp=0.0):
    message.header.frame_id = frame
    message.header.stamp = to_time(stamp)
    return message


def goal(position, quaternion=(0.0, 0.0, 0.0, 1.0), frame="", stamp=0.0):
    message = PoseStamped()
    place, turn = message.pose.position, message.pose.orientation
    place.x, place.y, place.z = map(float, position)
    turn.x, turn.y, turn.z, turn.w = map(float, quaternion)
    return header(message, frame, stamp)


def twist(linear=(0.1, 0.0, 0.0), angular=(0.0, 0.0, 0.0), frame="", stamp=0.0):
    message = TwistStamped(twist=twist_of(linear, angular))
    return header(message, frame, stamp)


def twist_of(linear, angular):
    value = Twist()
    value.linear.x, value.linear.y, value.linear.z = map(float, linear)
    value.angular.x, value.angular.y, value.angular.z = map(float, angular)
    return value


def transform(pose):
    value = Transform()
    there, turn = value.translation, value.rotation
    there.x, there.y, there.z = pose.position.tolist()
    turn.x, turn.y, turn.z, turn.w = to_quaternion(pose.rotation).tolist()
    return value


def moved(pose, *away):
    return replace(pose, position=pose.position + np.array(away))


def way(*poses, names=(), times=None, twists=None, stamp=0.0, frame=""):
    message = MultiDOFJointTrajectory(joint_names=list(names))
    for k, pose in enumerate(poses):
        point = MultiDOFJointTrajectoryPoint(transforms=[transform(p) for p in np.atleast_1d(pose)])
        point.time_from_start = duration(times[k] if times else float(k + 1))
        if twists is not None:
            point.velocities = [twist_of(twists[k][:3], twists[k][3:])]
        message.points.append(point)
    return header(message, frame, stamp)


def duration(seconds):
    message = JointTrajectoryPoint().time_from_start
    message.sec, message.nanosec = int(seconds), round(1e9 * (seconds - int(seconds)))
    return message


def arm(positions, names=None, times=None, velocities=None):
    joints = team().robots[0].joints[3:]
    message = JointTrajectory(joint_names=list(joints if names is None else names))
    for k, row in enumerate(positions):
        point = JointTrajectoryPoint(positions=[float(x) for x in row])
        point.time_from_start = duration(times[k] if times else float(k + 1))
        if velocities is not None:
            point.velocities = [float(x) for x in velocities[k]]
        message.points.append(point)
    return message


def path(places, stamps=None, frame="", stamp=0.0):
    message = Path()
    for k, (x, y, yaw) in enumerate(places):
        quaternion = (0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2))
        entry = goal((x, y, 0.0), quaternion, stamp=0.0 if stamps is None else stamps[k])
        message.poses.append(entry)
    return header(message, frame, stamp)


# ---- what is taken


def test_a_twist_is_followed_and_fades_when_no_other_one_comes(bench):
    bench.go(10).send("/robot_a/ee_twist", twist((0.1, 0.0, 0.0))).go()
    assert bench.at(0.3).twist(0)[0] == pytest.approx(0.1)
    assert bench.at(1.0).twist(0) is None
    gone = bench.at(1.0).ee[0].position[0] - tool().position[0]
    assert gone == pytest.approx(0.1 * 0.2, abs=1e-9), "0.2 s of it, ramps in and out"
    assert bench.topics.refused == 0


def test_a_stream_of_twists_goes_on(bench):
    for _ in range(50):
        bench.send("/robot_a/ee_twist", twist((0.1, 0.0, 0.0))).go(2)
    assert bench.at(0.01 * bench.tick).twist(0)[0] == pytest.approx(0.1)


def test_a_twist_in_the_axes_of_the_tool(bench):
    bench.send("/robot_a/ee_twist", twist((0.0, 0.0, 0.1), frame="robot_a/tool")).go()
    linear = bench.at(0.15).twist(0)[:3]
    np.testing.assert_allclose(linear, 0.1 * tool().rotation[:, 2], atol=1e-9)


@pytest.mark.parametrize(
    ("frame", "axes"),
    [
        ("", 0.0),
        ("world", 0.0),
        ("robot_a/odom", 0.0),
        ("robot_a/base", 1.0),
        ("robot_b/tool", 2.0),
    ],
)
def test_a_twist_of_a_base_in_the_axes_of_its_frame(bench, frame, axes):
    q = home()
    q[2] = 1.0  # yaw of robot_a, seen by its frames
    bench.send(
        "/robot_a/base_target", goal((q[0], q[1], 0.0), (0.0, 0.0, math.sin(0.5), math.cos(0.5)))
    )
    bench.go(60, q)
    angular = (0.0, 0.0, 0.0)
    linear = (0.0, 0.1, 0.0) if axes == 2.0 else (0.1, 0.0, 0.0)
    bench.send("/robot_a/base_twist", twist(linear, angular, frame=frame)).go(2, q)
    rate = bench.at(0.01 * bench.tick + 0.15).motion.bases[0]
    yaw = 1.0 if axes == 1.0 else 0.0
    if axes == 2.0:  # y of a tool that looks down
        down = team().tools(q)[1].rotation[:, 1]
        yaw = math.atan2(down[1], down[0])
    np.testing.assert_allclose(rate, (0.1 * math.cos(yaw), 0.1 * math.sin(yaw), 0.0), atol=1e-6)


def test_a_twist_of_a_base_fades_when_no_other_one_comes(bench):
    bench.go(10).send("/robot_a/base_twist", twist((0.1, 0.0, 0.0), (0.0, 0.0, 0.3))).go()
    np.testing.assert_allclose(bench.at(0.3).motion.bases[0], (0.1, 0.0, 0.3), atol=1e-9)
    assert 0 not in bench.at(1.0).motion.bases
    assert bench.at(1.0).base[0][0] > home()[0] + 0.015


def test_timed_poses_are_met_at_their_times(bench):
    first, second = moved(tool(), 0.1, 0.0, 0.0), moved(tool(), 0.1, 0.2, 0.0)
    bench.go(4).send("/robot_a/ee_trajectory", way(first, second, stamp=2.0)).go(250)
    before = bench.schedule.timeline.at(1.99)
    np.testing.assert_allclose(before.ee[0].position, tool().position, atol=1e-9)
    np.testing.assert_allclose(bench.at(3.0).ee[0].position, first.position, atol=1e-9)
    np.testing.assert_allclose(bench.at(4.0).ee[0].position, second.position, atol=1e-9)


def test_without_a_stamp_times_count_from_now_on(bench):
    bench.go(100).send("/robot_a/ee_trajectory", way(tool(), moved(tool(), 0.0, 0.1, 0.0))).go()
    begun = bench.schedule.timeline.newest.at
    assert begun == pytest.approx(1.02)
    np.testing.assert_allclose(bench.at(begun + 2.0).ee[0].position[1], tool().position[1] + 0.1)


def test_twists_at_the_poses_are_met(bench):
    poses = (tool(), moved(tool(), 0.1, 0.0, 0.0), moved(tool(), 0.2, 0.0, 0.0))
    twists = [[0.05, 0, 0, 0, 0, 0], [0.1, 0, 0, 0, 0, 0.2], [0.0] * 6]
    message = way(*poses, times=[0.0, 1.0, 2.0], twists=twists)
    begun = bench.send("/robot_a/ee_trajectory", message).go().schedule.timeline.newest.at
    np.testing.assert_allclose(bench.at(begun + 1.0).twist(0), twists[1], atol=1e-6)


def test_the_first_pose_is_reached_at_its_time_from_wherever_the_reference_is(bench):
    poses = (moved(tool(), 0.4, 0.0, 0.0), moved(tool(), 0.6, 0.0, 0.0))
    message = way(*poses, times=[2.0, 4.0], twists=[[0.2, 0, 0, 0, 0, 0], [0.0] * 6])
    begun = bench.send("/robot_a/ee_trajectory", message).go().schedule.timeline.newest.at
    np.testing.assert_allclose(bench.at(begun).ee[0].position, tool().position, atol=1e-9)
    np.testing.assert_allclose(bench.at(begun + 2.0).ee[0].position, poses[0].position, atol=1e-9)
    np.testing.assert_allclose(bench.at(begun + 2.0).twist(0)[0], 0.2, atol=1e-9)
    speeds = [bench.at(begun + t).twist(0)[0] for t in np.arange(0.0, 3.9, 0.05)]
    assert min(speeds) > -0.01
    assert max(speeds) < 0.5


def test_several_frames_of_one_robot_in_one_message(bench):
    elbow = bench.topics._frames(header(PoseStamped(), f"robot_a/{ELBOW}").header, "here")
    pairs = [[tool(), elbow], [moved(tool(), 0.1, 0, 0), moved(elbow, 0.0, 0.1, 0.0)]]
    message = way(*pairs, names=["robot_a/tool", ELBOW])
    begun = bench.send("/robot_a/ee_trajectory", message).go().schedule.timeline.newest.at
    end = bench.at(begun + 2.0)
    np.testing.assert_allclose(end.ee[0].position[0], tool().position[0] + 0.1)
    np.testing.assert_allclose(end.motion.frames[0, ELBOW].position[1], elbow.position[1] + 0.1)


def test_a_frame_that_a_stack_names_has_topics_of_its_own(bench):
    assert f"/robot_a/{ELBOW}/ee_target" in bench.node.listeners
    assert f"/robot_b/{ELBOW}/ee_target" not in bench.node.listeners
    bench.send(f"/robot_a/{ELBOW}/ee_target", goal((0.5, 0.0, 0.9))).go()
    elbow = bench.topics._frames(header(PoseStamped(), f"robot_a/{ELBOW}").header, "here")
    begun = bench.at(bench.schedule.timeline.newest.at).motion.frames[0, ELBOW]
    np.testing.assert_allclose(begun.position, elbow.position, atol=1e-12)
    np.testing.assert_allclose(bench.at(5.0).motion.frames[0, ELBOW].position, [0.5, 0.0, 0.9])
    bench.send(f"/robot_a/{ELBOW}/ee_twist", twist((0.0, 0.1, 0.0))).go()
    assert bench.topics.refused == 0


def test_a_frame_that_a_robot_has_not_has_no_topics(bench):
    task = TaskConfig("frame_pose", "robot_a", parameters={"frame": "nose"})
    before = set(bench.node.listeners)
    bench.topics.add_frames(StackConfig("nose", "", (LevelConfig((task,)),)))
    assert set(bench.node.listeners) == before


def test_every_tool_of_a_robot_has_topics_of_its_own():
    robot = RobotModel("duo", load_robot(CONFIG / "robots/tiago_dual.yaml"))
    assert robot.config.tools
    pair, node = Team((robot,), 0.01), Node()
    schedule = ReferenceSchedule(measured(pair, pair.home()), dt=0.01)
    TargetTopics(node, pair, schedule, ReferenceTopicsConfig())
    for name in robot.config.tools:
        assert f"/duo/{name}/ee_target" in node.listeners


def test_one_pose_with_a_time_is_reached_at_that_time(bench):
    there = moved(tool(), 0.3, 0.0, 0.0)
    bench.send("/robot_a/ee_trajectory", way(there, times=[2.0])).go()
    begun = bench.schedule.timeline.newest.at
    assert bench.at(begun + 1.0).ee[0].position[0] - tool().position[0] == pytest.approx(0.15)
    assert bench.at(begun + 1.0).twist(0)[0] > 0.2, "its velocity is followed"
    np.testing.assert_allclose(bench.at(begun + 2.0).ee[0].position, there.position)


@pytest.mark.parametrize("topic", ["ee_trajectory", "base_path", "posture_trajectory"])
def test_an_empty_message_ends_a_trajectory_smoothly(bench, topic):
    q = home()[3:10]
    start = {
        "ee_trajectory": way(tool(), moved(tool(), 1.0, 0.0, 0.0), times=[0.0, 4.0]),
        "base_path": path([(0, 0, 0), (1, 0, 0)], stamps=[0.02, 4.0]),
        "posture_trajectory": arm([q, q + 0.3], times=[0.0, 4.0]),
    }[topic]
    bench.send(f"/robot_a/{topic}", start).go(200)
    bench.send(f"/robot_a/{topic}", type(start)()).go()
    newest = bench.schedule.timeline.newest
    point = {"e": newest.ee[0], "b": newest.base[0], "p": newest.postures.get(0)}[topic[0]]
    assert np.abs(point.rate(newest.at)).max() > 0.05, "it does not stop at once"
    assert point.end == pytest.approx(newest.at + 0.5)
    assert bench.topics.refused == 0


def test_a_posture_by_names_in_any_order(bench):
    q = home()[3:10]
    joints = list(team().robots[0].joints[3:])
    order = [3, 1, 0, 2, 6, 5, 4]
    names = [f"robot_a/{joints[k]}" for k in order]
    rows = [(q + 0.1)[order], (q + 0.2)[order]]
    rates = [np.full(7, 0.1)[order], np.zeros(7)]
    bench.send("/robot_a/posture_trajectory", arm(rows, names, velocities=rates)).go()
    assert bench.node.said == []
    begun = bench.schedule.timeline.newest.at
    np.testing.assert_allclose(bench.at(begun).motion.postures[0], q, atol=1e-9)
    np.testing.assert_allclose(bench.at(begun + 1.0).motion.postures[0], q + 0.1, atol=1e-9)
    np.testing.assert_allclose(bench.at(begun + 1.0).motion.posture_rates[0], 0.1, atol=1e-6)


def test_a_path_without_stamps_is_driven_at_the_stated_speed(bench):
    places = [(0, 0, 0), (1, 0, 0), (2, 0, 1), (2, 1, 1.57), (2, 1, 1.57)]
    bench.send("/robot_a/base_path", path(places)).go()
    point = bench.schedule.timeline.newest.base[0]
    rates = np.array([point.goal.rate(t) for t in np.linspace(0.1, point.end - 0.1, 2000)])
    fastest = np.hypot(rates[:, 0], rates[:, 1]).max()
    assert 0.2 < fastest <= 0.303 or np.abs(rates[:, 2]).max() == pytest.approx(0.5, rel=0.02)
    assert fastest <= 0.303
    np.testing.assert_allclose(bench.at(point.end).base[0], places[-1], atol=1e-9)


# ---- frames


def test_a_target_in_the_frame_of_the_other_robots_tool(bench):
    bench.go(20).send("/robot_a/ee_target", goal((0.0, 0.0, 0.2), frame="robot_b/tool")).go()
    there = tool(1).position + 0.2 * tool(1).rotation[:, 2]
    np.testing.assert_allclose(bench.at(5.0).ee[0].position, there, atol=1e-12)


@pytest.mark.parametrize("frame", ["robot_a/base", "robot_a/base_link"])
def test_a_target_in_the_frame_of_a_base_at_its_stamp(frame):
    bench, q = Bench(), home()
    for k in range(20):
        q = q.copy()
        q[:3] = [0.1 * k, 0.5, math.pi / 2]
        bench.go(q=q)
    bench.send("/robot_a/base_target", goal((1.0, 0.0, 0.0), frame=frame, stamp=0.105)).go()
    # tick 10 is the tenth of the loop: x = 0.9, and half a tick later 0.95
    np.testing.assert_allclose(bench.at(5.0).base[0], [0.95, 1.5, math.pi / 2], atol=1e-9)


@pytest.mark.parametrize("frame", ["world", "robot_a/world", "robot_b/odom", "/world"])
def test_frames_that_are_the_world(bench, frame):
    bench.send("/robot_a/ee_target", goal((0.4, 0.1, 0.8), frame=frame)).go()
    np.testing.assert_array_equal(bench.at(5.0).ee[0].position, [0.4, 0.1, 0.8])


def hear(bench, parent, child, position, stamp=0.0, *, static=False):
    message = TransformStamped(child_frame_id=child)
    header(message, parent, stamp)
    there, message.transform.rotation.w = message.transform.translation, 1.0
    there.x, there.y, there.z = map(float, position)
    bench.topics._frames.transforms.hear([message], static=static)


def tree(*children, stamp=0.0, x=0.0):
    """Return the bytes of a message of /tf."""
    transforms = [TransformStamped(child_frame_id=child) for child in children]
    for each in transforms:
        header(each, "world", stamp)
        each.transform.rotation.w = 1.0
        each.transform.translation.x, each.transform.translation.z = x, 0.5
    return serialize_message(TFMessage(transforms=transforms))


def test_of_the_plants_own_tree_only_what_its_states_do_not_say_is_read(bench, monkeypatch):
    bench.go(10)
    own = ("robot_a/base", "robot_a/panda_link3", "robot_b/tool", "robot_b/odom", "/robot_a/world")
    _, take = bench.node.listeners["/tf"]
    transforms = bench.topics._frames.transforms
    take(tree(*own))
    assert transforms.frames == ()
    take(tree(*own[:2], "robot_a/camera", *own[2:]))
    monkeypatch.setattr(
        transform_topics, "deserialize_message", None
    )  # from now on nothing is decoded
    take(tree(*own[:2], "robot_a/camera", *own[2:], stamp=0.09, x=0.25))
    monkeypatch.undo()
    assert transforms.frames == ("robot_a/camera",)
    bench.send("/robot_a/ee_target", goal((0.0, 0.1, 0.0), frame="robot_a/camera", stamp=0.09))
    np.testing.assert_allclose(bench.go().at(5.0).ee[0].position, [0.25, 0.1, 0.5], atol=1e-12)
    take(tree("robot_c"))
    assert set(transforms.frames) == {"robot_a/camera", "robot_c"}


def test_bytes_that_are_no_transforms_are_counted(bench):
    _, take = bench.node.listeners["/tf_static"]
    take(tree("camera")[:30])
    assert bench.topics._frames.transforms.refused == 1


def test_a_name_that_is_no_utf_8_beside_a_robots_own_frame_ends_nothing(bench):
    _, take = bench.node.listeners["/tf"]
    transforms = bench.topics._frames.transforms
    data = tree("robot_a/base", "robot_c", "robot_d").replace(b"robot_d", b"\xa6obot_d")
    for _ in range(2):
        take(data)
    assert "robot_c" in transforms.frames
    take(tree("robot_a/base", *[f"f{i}" for i in range(11_000)]))  # more than a layout takes
    assert "f0" in transforms.frames


def test_a_target_in_a_frame_that_is_heard_on_tf_behind_a_robots_own(bench):
    bench.go(10)
    hear(bench, "robot_b/tool", "camera", (0.0, 0.0, 0.1), static=True)
    for stamp in (0.05, 0.1):
        hear(bench, "camera", "cup", (10.0 * stamp, 0.0, 0.0), stamp)
    bench.send("/robot_a/ee_target", goal((0.0, 0.0, 0.0), frame="cup", stamp=0.06)).go()
    there = tool(1).position + tool(1).rotation @ [0.6, 0.0, 0.1]
    np.testing.assert_allclose(bench.at(5.0).ee[0].position, there, atol=1e-9)


def test_a_target_that_overtakes_its_state_waits_for_it(bench):
    bench.go(10).send("/robot_a/ee_target", goal((0, 0, 0.1), frame="robot_a/tool", stamp=0.12))
    revision = bench.schedule.timeline.newest.revision
    bench.go()
    assert bench.schedule.timeline.newest.revision == revision
    bench.go(2)
    assert bench.schedule.timeline.newest.revision == revision + 1
    assert bench.topics.refused == 0


# ---- what is refused


def ahead(frame):
    return goal((0.0, 0.0, 0.0), frame=frame, stamp=9.0)


def stamped_badly():
    message = goal((0.4, 0.0, 0.8))
    message.header.stamp.sec = -1
    return message


TWO = (tool(), moved(tool(), 0.1, 0.0, 0.0))
ARM = home()[3:10]
MOVING = [[0.1, 0, 0, 0, 0, 0]] * 2
JOINTS = list(team().robots[0].joints[3:])


@pytest.mark.parametrize(
    ("kind", "message", "reason"),
    [
        (
            "ee_target",
            goal((0, 0, 0), frame="nowhere"),
            "frame_id: unknown 'nowhere'; known: world",
        ),
        ("ee_target", goal((0, 0, 0), frame="robot_a/no"), "frame_id: unknown 'robot_a/no'"),
        ("ee_target", ahead("robot_a/tool"), "'robot_a/tool' at 9.000 s is not known yet"),
        ("ee_target", stamped_badly(), "header.stamp: expected a time from 0 on, got -1 s"),
        ("ee_target", goal((0, 0, 0), stamp=99.0), "stamp 99.000 s is 98.69 s ahead"),
        ("ee_target", goal((0, 0, 2000.0)), "position: 2000 m away"),
        ("ee_twist", twist((math.nan, 0, 0)), "twist[0]: must be finite"),
        ("ee_twist", twist((99.0, 0, 0)), "twist: 99, at most 10"),
        ("ee_twist", twist(stamp=0.05), "header.stamp: it is 0.270 s old, at most 0.2 s"),
        ("ee_twist", twist(frame="nowhere"), "frame_id: unknown 'nowhere'"),
        ("base_twist", twist((0, 0, 0.1)), "a base moves on the floor"),
        ("base_twist", twist(angular=(0.1, 0, 0)), "a base moves on the floor"),
        ("base_twist", twist((math.inf, 0, 0)), "twist[0]: must be finite"),
        ("base_twist", twist(stamp=0.05), "header.stamp: it is 0.270 s old, at most 0.2 s"),
        ("base_twist", twist(frame="robot_a/no"), "frame_id: unknown 'robot_a/no'"),
        ("ee_trajectory", way(*TWO, names=["nose"]), "joint_names: robot robot_a: no frame 'nose'"),
        ("ee_trajectory", way(*TWO, names=["tool", "tool"]), "a frame stands in it twice"),
        ("ee_trajectory", way(*TWO, names=["tool", ELBOW]), "transforms: expected 2, got 1"),
        ("ee_trajectory", way(*TWO, times=[1.0, 1.0]), "points[1]: 1 s is not after 1 s"),
        ("ee_trajectory", way(*TWO, times=[0.1, 0.2], stamp=0.05), "it ended at 0.250 s"),
        ("ee_trajectory", way(*TWO, stamp=99.0), "stamp 99.000 s is 98.69 s ahead"),
        (
            "ee_trajectory",
            way(*TWO, times=[0.0, 1.0], twists=MOVING),
            "twists[1]: must be zero: the reference rests at the end",
        ),
        ("ee_trajectory", way(*[tool()] * 1001), "points: expected at most 1000, got 1001"),
        ("ee_trajectory", way(tool(), moved(tool(), 30, 0, 0)), "points[1]: 30 m/s or rad/s from"),
        ("base_path", path([(0, 0, 0), (30, 0, 0)], stamps=[2, 3]), "poses[1]: 30 m/s or rad/s"),
        ("base_path", path([(0, 0, 0), (1, 0, 0)], stamps=[2.0, 1.0]), "1 s is not after 2 s"),
        ("base_path", path([(0, 0, 0), (1, 0, 0)], stamps=[0.1, 0.2]), "it ended at 0.200 s"),
        ("base_path", path([(0, 0, 0), (1e4, 0, 0)]), "poses[1]: position: 10000 m away"),
        ("posture_trajectory", arm([ARM, ARM], ["x"] * 7), "joint_names: 'x': unknown; known:"),
        ("posture_trajectory", arm([ARM], JOINTS[:6]), f"joint_names: {JOINTS[6]} missing"),
        ("posture_trajectory", arm([ARM[:6]]), "points[0].positions: expected 7 values, got 6"),
        ("posture_trajectory", arm([ARM + 9.0]), "is outside its limits"),
        ("posture_trajectory", arm([ARM, ARM], velocities=[[], [0] * 7]), "velocities: expected 7"),
    ],
)
def test_what_does_not_fit_is_refused_in_one_line(bench, kind, message, reason):
    bench.go(30)
    revision = bench.schedule.timeline.newest.revision
    bench.send(f"/robot_a/{kind}", message).go(5)
    line = bench.refused()
    assert line.startswith(f"refused: /robot_a/{kind}: ")
    assert reason in line
    assert "\n" not in line
    assert bench.topics.report() == line
    assert bench.schedule.timeline.newest.revision == revision


def test_a_transform_that_is_old_or_of_another_clock_is_refused(bench):
    bench.go(300)
    hear(bench, "world", "old", (0, 0, 0), 0.1)
    bench.send("/robot_a/ee_target", goal((0, 0, 0), frame="old"))
    assert "the newest transform of 'old' on /tf is of 0.100 s, simulated time is 3" in (
        bench.refused()
    )


def test_a_circle_on_tf_leads_nowhere(bench):
    hear(bench, "one", "other", (0, 0, 0), static=True)
    hear(bench, "other", "one", (0, 0, 0), static=True)
    bench.send("/robot_a/ee_target", goal((0, 0, 0), frame="one"))
    assert "unknown 'one'" in bench.refused()
