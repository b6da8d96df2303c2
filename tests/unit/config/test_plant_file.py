"""Plant files: what they take, what they must agree with, and how commands find them."""

from __future__ import annotations

import argparse
from pathlib import Path

import pytest
import yaml

from lexstack.errors import ConfigurationError
from lexstack_bringup.commands import demo
from lexstack_bringup.real_plant import real_plant
from lexstack_config.plant_file import check_plant, load_plant
from support.scenario import CONFIG, ROOT, resolved

FILE = Path(CONFIG) / "plants" / "two_pandas.yaml"


def written(tmp_path, change):
    """Return a plant file with something changed."""
    content = yaml.safe_load(FILE.read_text(encoding="utf-8")) | {"name": "mine"}
    change(content)
    path = tmp_path / "mine.yaml"
    path.write_text(yaml.safe_dump(content), encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda c: c["robots"]["robot_a"]["arm"].update(type="jerk"), "arm: type"),
        (lambda c: c["robots"]["robot_a"]["arm"].update(command="a b"), "arm: command"),
        (lambda c: c["robots"]["robot_a"]["arm"].update(ahead=0), "arm: ahead"),
        (lambda c: c["robots"]["robot_a"]["base"].pop("odometry"), "odometry"),
        (lambda c: c["robots"]["robot_a"]["base"].update(tf={"parent": "a b"}), "tf: parent"),
        (lambda c: c.update(robots={}), "robots"),
        (lambda c: c.update(rate=0), "rate"),
        (lambda c: c.update(safety={"speed": 0.5}), "safety: speed"),
        (lambda c: c.update(name="other"), "name"),
        (lambda c: c.update(sped=1), "sped"),
    ],
)
def test_a_wrong_file_is_refused_with_its_key(tmp_path, change, reason):
    with pytest.raises(ConfigurationError, match=reason):
        load_plant(written(tmp_path, change))


def test_a_base_may_be_placed_by_tf_alone(tmp_path):
    def change(content):
        base = content["robots"]["robot_a"]["base"]
        base.pop("odometry")
        base["tf"] = {}

    tf = load_plant(written(tmp_path, change)).robots["robot_a"].base.tf
    assert (tf.frame, tf.parent, tf.topic) == ("base_link", "odom", "/tf")


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda c: c["robots"].pop("robot_b"), "scenario transition-sequence has 'robot_b'"),
        (lambda c: c["robots"]["robot_a"].update(model="ur10"), "robot is a 'panda_summit'"),
        (lambda c: c["robots"]["robot_a"].pop("base"), "base: the base of 'panda_summit' is"),
        (
            lambda c: c["robots"]["robot_a"]["joint_states"].update(names={"elbow": "e"}),
            "has no joint 'elbow'",
        ),
    ],
)
def test_a_plant_must_have_the_robots_of_the_scenario(tmp_path, change, reason):
    plant = load_plant(written(tmp_path, change))
    with pytest.raises(ConfigurationError, match=reason):
        check_plant(plant, resolved(), "mine.yaml")


def options(plant, config=(), enable=False):
    return argparse.Namespace(plant=plant, config=list(config), enable=enable)


def test_a_plant_is_a_file_or_a_name_in_the_folders(tmp_path):
    path = written(tmp_path, lambda c: c.update(rate=50.0))
    assert real_plant(ROOT, options(None), resolved()) is None
    assert real_plant(ROOT, options("two_pandas"), resolved()).path == FILE.resolve()
    for named, config in ((str(path), ()), ("mine", [tmp_path])):
        real = real_plant(ROOT, options(named, config), resolved())
        applied = real.applied(resolved()).scenario
        assert (applied.rate, applied.mode) == (50.0, "realtime")


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (["--plant", "no_such"], "no_such.yaml"),
        (["--enable"], "--enable: only robots of --plant are enabled"),
        (["carry", "--plant", "two_ur10"], "robots.robot_a.model"),
    ],
)
def test_the_demo_refuses_a_wrong_plant(arguments, reason, monkeypatch, capsys):
    monkeypatch.setenv("LEXSTACK_ROOT", str(ROOT))
    assert demo.main(arguments) == 2
    assert reason in capsys.readouterr().err
