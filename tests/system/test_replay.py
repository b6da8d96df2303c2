"""A recorded run, replayed: identical without changes, different at the right tick with them."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader
from std_srvs.srv import Trigger

from lexstack_bag.commands import replay as command
from lexstack_bag.replay.changes import Changes
from lexstack_bag.replay.nodes import REPLAYERS, Question, recorded_nodes, replay_controller
from lexstack_bag.run.reader import read_run
from lexstack_bringup.commands import replay as ros_command
from lexstack_bringup.domain import own_domain
from lexstack_config.scenario import EventConfig, PoseConfig
from lexstack_interfaces.msg import TransitionStatus
from lexstack_testing.played_run import together
from support.runs import short_scenario

pytestmark = pytest.mark.system

SWITCH = 100  # tick of the switch to reach_base, which blends for 1.5 s
TICKS = 400
COMPARED = "extensions=[lexstack_experiments.methods]"


def scenario():
    """Return a run of 4 s: a switch with new references, and a second one that pre-empts it."""
    first = short_scenario().scenario.events[0]
    lower = PoseConfig((0.9, 0.2, 1.1), (0.0, 1.0, 0.0, 0.0))
    events = (
        replace(first, base_target={"robot_a": (0.1, -0.3, 0.4)}),
        EventConfig(2.0, "posture"),
        EventConfig(3.2, "track", duration=0.5, ee_target={"robot_b": lower}),
    )
    return short_scenario(events=events)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    out = tmp_path_factory.mktemp("recorded")
    with together(scenario(), out) as run:
        run.play()
        assert run.end() == []
    return out


@pytest.fixture(scope="module")
def run(recorded):
    return read_run(recorded)


def outcome(run, node, **changes):
    what = Changes(**changes)
    return REPLAYERS[node](Question(run, what, what.applied(run.resolved)))


# ---- without changes


@pytest.mark.parametrize("node", ["robot_a", "robot_b"])
def test_a_lockstep_run_is_identical_bit_by_bit(run, node):
    found = outcome(run, node)
    assert found.identical, found.line()
    assert len(found.tick) >= (TICKS if node == "robot_a" else 200)


def test_one_flipped_bit_is_found_at_its_tick(run):
    chi = np.array(run.chi["robot_a"].chi)
    chi[257, 13] = np.nextafter(chi[257, 13], np.inf)
    tampered = replace(run, chi=run.chi | {"robot_a": replace(run.chi["robot_a"], chi=chi)})
    found = replay_controller(Question(tampered, Changes(), run.resolved))
    assert found.first == 257
    assert np.count_nonzero(found.different) == 1


def test_another_answer_of_robot_b_is_noticed_where_a_heard_it(run):
    chi = np.array(run.chi["robot_b"].chi)
    row = int(np.flatnonzero(run.chi["robot_b"].tick == 150)[0])
    chi[row, 0] += 1e-3
    tampered = replace(run, chi=run.chi | {"robot_b": replace(run.chi["robot_b"], chi=chi)})
    assert replay_controller(Question(tampered, Changes(), run.resolved)).first == 150


def test_a_cancelled_transition_is_replayed(tmp_path):
    cancelled = []
    with together(short_scenario(), tmp_path) as live:
        client = live.player.create_client(Trigger, "/robot_a/cancel_transition")

        def watch():
            status = live.player.transition
            blending = status is not None and status.phase == TransitionStatus.BLENDING
            if blending and status.alpha > 0.2 and not cancelled:
                cancelled.append(client.call_async(Trigger.Request()))

        live.play(watch)
        assert live.end() == []
    assert cancelled
    run = read_run(tmp_path)
    assert any("going back" in str(reason) for reason in run.transition.reason)
    for node in recorded_nodes(run):
        found = outcome(run, node)
        assert found.identical, found.line()


# ---- with changes


@pytest.mark.parametrize(
    "changes",
    [
        {"settings": ("transition.duration=0.4",)},
        {"settings": ("stacks.reach_base.levels.1.tasks.0.parameters.gain=2.0",)},
        {"method": "instant_limited", "settings": (COMPARED,)},
        {"stack": "reach_base=posture"},
    ],
    ids=lambda changes: next(iter(changes)),
)
def test_a_change_shows_from_its_first_tick_on(run, changes):
    found = outcome(run, "robot_a", **changes)
    # The blend begins with the command in force, whatever the source is: at the earliest the
    # first difference shows there, and it must show within the first ticks.
    if "transition.duration" in str(changes):
        assert found.first == SWITCH or found.first > 200, "the first blend named its duration"
    else:
        assert SWITCH <= found.first <= SWITCH + 2
    limits = run.team().limits.acceleration * run.period
    steps = np.abs(np.diff(found.replayed, axis=0))
    assert (steps <= limits * (1.0 + 1e-6)).all(), "its own commands keep the limits"


def test_another_solver_finds_the_same_within_its_accuracy(run):
    for node in recorded_nodes(run):
        found = outcome(run, node, solver="proxqp")
        assert len(found.tick) > 100
        assert max(value for value, *_ in found.largest()) < 1e-6


def test_the_command_writes_figures_and_a_picture(recorded, tmp_path, capsys):
    setting = "stacks.reach_base.levels.1.tasks.0.parameters.gain=2.0"
    code = command.main([str(recorded), "--set", setting, "--out", str(tmp_path)])
    assert code == 0
    content = json.loads((tmp_path / "replay.json").read_text(encoding="utf-8"))
    assert content["changes"] == setting
    assert content["open_loop"] is True
    by_node = {node["node"]: node for node in content["nodes"]}
    assert by_node["robot_b"]["first_different_tick"] == SWITCH
    assert {entry["unit"] for entry in by_node["robot_a"]["largest"]} == {"m/s", "rad/s"}
    assert (tmp_path / "replay.png").stat().st_size > 20_000
    assert f"robot_b: differs first at tick {SWITCH} (1.00 s)" in capsys.readouterr().out


def test_identical_writes_nothing_and_ends_with_0(recorded, capsys):
    before = set(recorded.iterdir())
    assert command.main([str(recorded)]) == 0
    assert f"robot_a: identical over all {TICKS} ticks" in capsys.readouterr().out
    assert set(recorded.iterdir()) == before


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["nowhere"], "nowhere: no such file or folder"),
        (["BAG", "--set", "speed=3"], "unknown key 'speed'"),
        (
            ["BAG", "--method", "jump"],
            "method=jump: transition.method: unknown method 'jump'; known: bridge",
        ),
        (["BAG", "--solver", "magic"], "solver"),
        (["BAG", "--node", "robot_x"], "invalid choice: 'robot_x'"),
        (["BAG", "--publish", "robot_x"], "invalid choice: 'robot_x'"),
        (["BAG", "--publish", "--rate", "-1"], "--rate: must be in [0, 1000], got -1.0"),
        (["BAG", "--publish", "--regex", "("], "regex: '(': missing )"),
        (["BAG", "--publish", "robot_a", "--patience", "2"], "hqp_controller is not there"),
    ],
)
def test_bad_arguments_give_one_line_and_exit_code_2(
    recorded, capfd, monkeypatch, arguments, message
):
    given = [str(recorded) if word == "BAG" else word for word in arguments]
    with own_domain() as domain:
        monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
        try:
            code = ros_command.main(given)
        except SystemExit as end:  # argparse
            code = end.code
    said = capfd.readouterr().err
    assert code == 2, said
    assert message in said
    assert "Traceback" not in said


# ---- years later


def test_a_bag_alone_is_analysed_and_replayed(recorded, tmp_path, monkeypatch, run_command):
    """In an empty folder, with the configuration out of reach."""
    alone = tmp_path / "alone"
    alone.mkdir()
    shutil.copy(recorded / "bag" / "bag_0.mcap", alone / "found.mcap")
    monkeypatch.chdir(alone)
    monkeypatch.setenv("LEXSTACK_ROOT", str(tmp_path / "nothing"))
    for module in ("lexstack_bag.commands.analyze", "lexstack_bringup.commands.replay"):
        done = run_command(module, "found.mcap")
        assert done.returncode == 0, done.stderr
    assert "robot_b: identical" in done.stdout
    assert (alone / "metrics.json").is_file()
    provenance = read_run(alone / "found.mcap").provenance
    assert {"commit", "lexstack", "numpy", "daqp", "pin", "mujoco", "mode", "seed"} <= set(
        provenance
    )


def test_other_tools_read_every_message_without_a_workspace(recorded, monkeypatch):
    monkeypatch.delenv("AMENT_PREFIX_PATH")
    total = sum(read_run(recorded).messages.values())
    with AnyReader([recorded / "bag"]) as reader:
        read = [reader.deserialize(data, c.msgtype) for c, _, data in reader.messages()]
    assert len(read) == total
    with (recorded / "bag" / "bag_0.mcap").open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        assert sum(1 for _ in reader.iter_decoded_messages()) == total


# ---- to live nodes


@contextmanager
def live(module, scenario, domain):
    process = subprocess.Popen(
        [sys.executable, "-m", module, "--ros-args", "-p", f"scenario:={scenario}"],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        env=os.environ | {"ROS_DOMAIN_ID": str(domain)},
    )
    yield
    process.terminate()
    output, _ = process.communicate(timeout=20)
    assert "Traceback" not in output


@pytest.mark.parametrize(
    ("node", "module"),
    [
        ("robot_a", "lexstack_ros.controller.node"),
        ("robot_b", "lexstack_ros.solver.node"),
    ],
)
def test_one_live_node_among_recorded_ones_gives_the_recorded_chi(
    recorded, tmp_path, monkeypatch, capfd, node, module
):
    path = tmp_path / "scenario.yaml"
    assert ros_command.main([str(recorded), "--publish", "--scenario", str(path)]) == 0
    with own_domain() as domain, live(module, path, domain):
        monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
        code = ros_command.main(
            [str(recorded), "--publish", node, "--rate", "0", "--patience", "90"]
        )
    said = capfd.readouterr().out
    assert code == 0, said
    assert f"{node}: identical over all" in said


def test_all_is_played_at_its_pace_with_the_clock(recorded, tmp_path, monkeypatch):
    """Recorded again, a bag that is played gives the same messages in the same time."""
    topics = ["/plant/state", "/robot_a/chi", "/robot_a/transition", "/robot_b/chi", "/clock"]
    with own_domain() as domain:
        environment = os.environ | {"ROS_DOMAIN_ID": str(domain)}
        parameters = [f"output:={tmp_path / 'bag'}", f"scenario:={recorded / 'scenario.yaml'}"]
        recorder = subprocess.Popen(
            [sys.executable, "-m", "lexstack_ros.recorder.node", "--ros-args"]
            + [word for pair in parameters for word in ("-p", pair)],
            stdout=subprocess.PIPE,
            text=True,
            env=environment,
        )
        assert recorder.stdout.readline() == "ready\n"
        monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
        arguments = ["--publish", "--rate", "1", "--topics", *topics]
        assert ros_command.main([str(recorded), *arguments]) == 0
        recorder.terminate()
        recorder.communicate(timeout=20)
    one, other = read_run(recorded), read_run(tmp_path)
    assert {t: one.messages[t] for t in topics} == {t: other.messages[t] for t in topics}
    np.testing.assert_array_equal(one.plant.q, other.plant.q)
    np.testing.assert_array_equal(one.chi["robot_a"].chi, other.chi["robot_a"].chi)
    sent = [run.chi["robot_a"].sent for run in (one, other)]
    assert sent[1][-1] - sent[1][0] == pytest.approx(sent[0][-1] - sent[0][0], rel=0.2)
