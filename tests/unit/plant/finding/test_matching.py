"""Plant files from lists of topics: what is found, what is left out, and what is said of it."""

from __future__ import annotations

from dataclasses import replace

import pytest

from lexstack_config.plant_file import PlantFile
from lexstack_config.reader import build
from lexstack_plant.finding.endpoints import (
    CLOCK,
    JOINT_STATE,
    ODOMETRY,
    TF,
    TRAJECTORY,
    TWIST,
    TWIST_STAMPED,
    VALUES,
    Controller,
    Endpoint,
    told,
)
from lexstack_plant.finding.matching import Wanted, find_plant_content

JOINTS = ("shoulder", "elbow", "wrist")
ARM = Wanted("arm_1", "my_arm", JOINTS, has_base=False)
MOBILE = replace(ARM, has_base=True)
STATES = Endpoint("/joint_states", JOINT_STATE, ("wheel", "wrist", "shoulder", "elbow"))
ARM_TOPIC = Endpoint("/arm_controller/joint_trajectory", TRAJECTORY, JOINTS)
BASE = [
    Endpoint("/base_controller/cmd_vel", TWIST_STAMPED),
    Endpoint("/base_controller/odom", ODOMETRY),
]


def found(*endpoints, wanted=(ARM,)):
    return find_plant_content("found", wanted, endpoints, 250.0)


def robot(*endpoints, wanted=ARM):
    result = found(*endpoints, wanted=(wanted,))
    return result.content["robots"]["arm_1"], result.notes


def test_an_arm_is_found_and_the_file_can_be_read():
    result = found(STATES, ARM_TOPIC)
    assert result.notes == ()
    plant = build(PlantFile, result.content, "found")
    assert plant.rate == 250.0
    arm = plant.robots["arm_1"]
    assert (arm.model, arm.joint_states.topic) == ("my_arm", "/joint_states")
    assert (arm.arm.command, arm.arm.type) == (ARM_TOPIC.topic, "joint_trajectory")
    assert arm.base is None


def test_a_platform_is_found():
    content, notes = robot(STATES, ARM_TOPIC, *BASE, wanted=MOBILE)
    assert content["base"] == {
        "odometry": "/base_controller/odom",
        "command": "/base_controller/cmd_vel",
        "type": "twist_stamped",
    }
    assert not notes


def test_a_twist_without_a_stamp_is_one():
    content, _ = robot(STATES, ARM_TOPIC, Endpoint("/cmd_vel", TWIST), BASE[1], wanted=MOBILE)
    assert content["base"]["type"] == "twist"


def test_odometry_near_the_command_is_better_than_another():
    other = Endpoint("/camera/odom", ODOMETRY)
    content, _ = robot(STATES, ARM_TOPIC, other, *BASE, wanted=MOBILE)
    assert content["base"]["odometry"] == "/base_controller/odom"


def test_without_odometry_the_pose_is_of_tf():
    content, notes = robot(STATES, ARM_TOPIC, BASE[0], Endpoint("/tf", TF), wanted=MOBILE)
    assert content["base"]["tf"] == {"frame": "base_link", "parent": "odom"}
    assert any("base.tf" in note for note in notes)


def test_names_with_a_prefix_are_mapped():
    states = replace(STATES, joints=tuple(f"left_{joint}" for joint in JOINTS))
    arm = replace(ARM_TOPIC, joints=states.joints)
    content, notes = robot(states, arm)
    assert content["joint_states"]["names"] == {joint: f"left_{joint}" for joint in JOINTS}
    assert content["arm"]["command"] == arm.topic
    assert not notes


def test_states_that_lack_a_joint_are_none():
    content, notes = robot(replace(STATES, joints=("shoulder", "elbow")), ARM_TOPIC)
    assert "joint_states" not in content
    assert notes == ("robots.arm_1.joint_states.topic: no JointState has shoulder, elbow, wrist",)


def test_states_of_this_arm_alone_are_better_than_those_of_all():
    own = Endpoint("/arm/states", JOINT_STATE, JOINTS)
    content, _ = robot(STATES, own, ARM_TOPIC)
    assert content["joint_states"]["topic"] == "/arm/states"


def test_the_controller_of_a_gripper_is_no_candidate():
    gripper = Endpoint("/gripper_controller/joint_trajectory", TRAJECTORY, ("finger",))
    content, notes = robot(STATES, gripper, ARM_TOPIC)
    assert content["arm"]["command"] == ARM_TOPIC.topic
    assert not notes


@pytest.mark.parametrize(
    ("joints", "reason"),
    [(JOINTS[:2], "its controller lacks wrist"), ((*JOINTS, "torso"), "has torso too")],
)
def test_a_controller_of_other_joints_is_refused_with_the_reason(joints, reason):
    content, notes = robot(STATES, replace(ARM_TOPIC, joints=joints))
    assert not content["arm"]
    assert any(reason in note for note in notes)


def test_a_trajectory_is_better_than_an_array():
    array = Endpoint("/velocity_controller/commands", VALUES, JOINTS, "velocity")
    content, _ = robot(STATES, array, ARM_TOPIC)
    assert content["arm"]["type"] == "joint_trajectory"


@pytest.mark.parametrize(
    ("array", "kind"),
    [
        (Endpoint("/a/commands", VALUES, JOINTS, "effort"), "effort"),
        (Endpoint("/forward_position_controller/commands", VALUES, JOINTS), "position"),
    ],
)
def test_the_type_of_an_array_is_its_controllers_or_in_its_name(array, kind):
    assert robot(STATES, array)[0]["arm"] == {"command": array.topic, "type": kind}


def test_an_array_of_unknown_type_is_not_guessed():
    content, notes = robot(STATES, Endpoint("/a/commands", VALUES, JOINTS))
    assert not content["arm"]
    assert "nothing says whether it is velocity, position or effort" in notes[0]


def test_of_two_equal_topics_none_is_taken():
    second = replace(ARM_TOPIC, topic="/other_controller/joint_trajectory")
    content, notes = robot(STATES, ARM_TOPIC, second)
    assert not content["arm"]
    assert notes == (f"robots.arm_1.arm.command: one of {ARM_TOPIC.topic}, {second.topic}",)


def test_unknown_joints_are_to_be_compared():
    content, notes = robot(STATES, replace(ARM_TOPIC, joints=()))
    assert content["arm"]["command"] == ARM_TOPIC.topic
    assert "are not known: compare them" in notes[0]


def test_robots_of_one_kind_are_told_apart_by_their_names():
    wanted = [replace(MOBILE, name=name) for name in ("left", "right")]
    topics = [
        replace(each, topic=f"/{name}{each.topic}", joints=each.joints if states else ())
        for name in ("left", "right")
        for each, states in ((STATES, True), (ARM_TOPIC, False), *((b, False) for b in BASE))
    ]
    content = found(*topics, wanted=wanted).content["robots"]
    for name in ("left", "right"):
        assert content[name]["joint_states"]["topic"] == f"/{name}/joint_states"
        assert content[name]["arm"]["command"] == f"/{name}{ARM_TOPIC.topic}"
        assert content[name]["base"]["command"] == f"/{name}{BASE[0].topic}"
    build(PlantFile, found(*topics, wanted=wanted).content, "found")


def test_one_topic_may_have_the_states_of_all():
    joints = [tuple(f"{name}_{joint}" for joint in JOINTS) for name in ("left", "right")]
    wanted = [
        replace(ARM, name=n, joints=j) for n, j in zip(("left", "right"), joints, strict=True)
    ]
    arms = [Endpoint(f"/c{i}/joint_trajectory", TRAJECTORY, j) for i, j in enumerate(joints)]
    result = found(replace(STATES, joints=joints[0] + joints[1]), *arms, wanted=wanted)
    for i, name in enumerate(("left", "right")):
        assert result.content["robots"][name]["joint_states"] == {"topic": "/joint_states"}
        assert result.content["robots"][name]["arm"]["command"] == f"/c{i}/joint_trajectory"


def test_nothing_at_all_is_said_key_by_key():
    _, notes = robot(wanted=MOBILE)
    keys = [note.split(":")[0].removeprefix("robots.arm_1.") for note in notes]
    assert keys == ["joint_states.topic", "base.command", "base.odometry", "arm.command"]


def test_a_simulators_time_is_used():
    assert found(STATES, ARM_TOPIC, Endpoint("/clock", CLOCK)).content["use_sim_time"]


# ---- what controllers say of their topics


def test_controllers_say_what_their_topics_are_about():
    topics = [
        STATES,
        replace(ARM_TOPIC, joints=()),
        Endpoint("/arm_controller_2/commands", VALUES),
        BASE[0],
    ]
    controllers = [
        Controller("/arm_controller", active=False, joints=JOINTS, interface="position"),
        Controller("/arm_controller_2", active=True, joints=JOINTS, interface="velocity"),
    ]
    states, arm, array, base = told(topics, controllers)
    assert (states, base) == (STATES, BASE[0])
    assert (arm.joints, arm.active) == (JOINTS, False)
    assert (array.joints, array.interface, array.active) == (JOINTS, "velocity", True)
    content, notes = robot(states, arm, array)
    assert content["arm"] == {"command": array.topic, "type": "velocity"}
    assert notes == (f"robots.arm_1.arm.command: not {arm.topic}: its controller is not active",)
