"""References that move in a scenario's events: what is wrong is one line with file and key."""

from pathlib import Path

import numpy as np
import pytest
import yaml

from lexstack.errors import ConfigurationError
from lexstack.references import Hold
from lexstack_bringup.event_messages import messages_of
from lexstack_config.checked import checked
from lexstack_config.event_targets import trajectory_targets
from lexstack_config.parts import build_team
from lexstack_config.resolved import load_scenario
from support.scenario import CONFIG

DOWN = [1.0, 0.0, 0.0, 0.0]
TREE = {
    "name": "moving",
    "description": "References that move.",
    "robots": {"robot_a": {"model": "panda_summit"}},
    "rate": 100.0,
    "duration": 9.0,
    "initial_stack": "track",
    "transition": {"duration": 1.0},
}
WAY = {"times": [0.0, 1.0], "positions": [[0.3, 0, 0.9], [0.3, 0.1, 0.9]], "orientations": [DOWN]}
ARM = [0.0, -0.8, 0.0, -2.3, 0.0, 1.6, 0.8]


def load(folder, **event):
    file = folder / "moving.yaml"
    file.write_text(yaml.safe_dump({**TREE, "events": [{"at": 1.0, **event}]}), encoding="utf-8")
    return checked(load_scenario(file, CONFIG), CONFIG, file)


def test_each_kind_is_a_target_and_a_message_of_the_same_time(tmp_path):
    event = {
        "ee_trajectory": {"robot_a": WAY},
        "base_path": {"robot_a": {"places": [[0, 0, 0], [0.5, 0, 0]]}},
        "posture_trajectory": {"robot_a": {"times": [1.0, 2.0], "positions": [ARM, [*ARM]]}},
        "ee_twist": {"robot_a": {"duration": 0.2, "linear": [0.1, 0, 0]}},
    }
    resolved = load(tmp_path, **event)
    team, (moving,) = build_team(resolved), resolved.scenario.events
    targets = list(trajectory_targets(moving, team, resolved.scenario.references))
    assert [target.at for target in targets] == pytest.approx([1.0] * 4 + [1.05, 1.1, 1.15])
    assert targets[1].base.end == pytest.approx(1.0 + 0.5 / 0.3 * 1.8, rel=0.05), "0.3 m/s at most"
    np.testing.assert_array_equal(targets[0].ee.at(2.0).position, [0.3, 0.1, 0.9])
    messages = dict(messages_of(moving, resolved))
    assert set(messages) == {f"/robot_a/{key}" for key in event}
    assert messages["/robot_a/ee_trajectory"].header.stamp.sec == 1


def test_without_times_or_places_the_reference_comes_to_rest(tmp_path):
    event = {
        "ee_trajectory": {"robot_a": {"times": [], "positions": [], "orientations": [DOWN]}},
        "base_path": {"robot_a": {"places": []}},
        "posture_trajectory": {"robot_a": {"times": [], "positions": []}},
    }
    resolved = load(tmp_path, **event)
    (moving,) = resolved.scenario.events
    targets = trajectory_targets(moving, build_team(resolved), resolved.scenario.references)
    assert [t.ee or t.base or t.posture for t in targets] == [Hold()] * 3


@pytest.mark.parametrize(
    ("event", "reason"),
    [
        ({"ee_trajectory": {"robot_x": WAY}}, "events[0].ee_trajectory: unknown robot 'robot_x'"),
        (
            {"ee_trajectory": {"robot_a": {**WAY, "times": [1.0, 1.0]}}},
            "ee_trajectory.robot_a: times[1]: 1 s is not after 1 s",
        ),
        (
            {"ee_trajectory": {"robot_a": {**WAY, "times": [1.0]}}},
            "ee_trajectory.robot_a: positions: expected 1, as many as times",
        ),
        (
            {"ee_trajectory": {"robot_a": {**WAY, "orientations": [[2.0, 0, 0, 0]]}}},
            "orientations[0]: norm must be 1",
        ),
        (
            {"ee_trajectory": {"robot_a": {**WAY, "orientations": [DOWN, [0.0, 0, 0, 1]]}}},
            "ee_trajectory.robot_a: poses[1]: turned by 3.142 rad",
        ),
        (
            {"ee_trajectory": {"robot_a": {**WAY, "frame": "nose"}}},
            "ee_trajectory.robot_a: robot robot_a: no frame 'nose'",
        ),
        (
            {"posture_trajectory": {"robot_a": {"times": [1.0], "positions": [ARM[:6]]}}},
            "posture_trajectory.robot_a: positions[0]: expected 7 values, got 6",
        ),
        (
            {"posture_trajectory": {"robot_a": {"times": [1.0], "positions": [[9.0] * 7]}}},
            "panda_joint1: 9 is outside its limits",
        ),
        (
            {"base_path": {"robot_a": {"places": [[0, 0, 0], [1, 0, 0]], "times": [0.0]}}},
            "base_path.robot_a: places: expected 1, as many as times",
        ),
        ({"ee_twist": {"robot_a": {"duration": 0.0}}}, "duration"),
    ],
)
def test_what_is_wrong_is_told_with_file_and_key(tmp_path, event, reason):
    with pytest.raises(ConfigurationError) as found:
        load(tmp_path, **event)
    line = str(found.value)
    assert line.startswith(str(tmp_path / "moving.yaml"))
    assert reason in line
    assert "\n" not in line


def test_a_robot_without_a_base_has_no_path(tmp_path):
    file = Path(tmp_path / "fixed.yaml")
    event = {"at": 1.0, "base_path": {"robot_a": {"places": [[0, 0, 0], [1, 0, 0]]}}}
    tree = {**TREE, "robots": {"robot_a": {"model": "panda"}}, "events": [event]}
    file.write_text(yaml.safe_dump(tree), encoding="utf-8")
    with pytest.raises(
        ConfigurationError, match=r"events.0..base_path: robot 'robot_a' has no base"
    ):
        load_scenario(file, CONFIG)
