"""Bad input to live nodes: not a bit of the motion changes, and every refusal is told."""

import time
from itertools import cycle

import numpy as np
import pytest
from rosbags.highlevel import AnyReader, AnyReaderError
from std_srvs.srv import SetBool

from lexstack_bringup.processes import NODES
from lexstack_interfaces.msg import PlantState
from lexstack_ros.node.calls import wait_until
from lexstack_testing.faults.hostile import FORGED, Stranger
from lexstack_testing.played_run import apart, together
from lexstack_testing.user import PATIENCE, User
from support.runs import short_scenario
from support.scenario import team

pytestmark = pytest.mark.system
LIMIT = team().limits.acceleration
TICKS = 800  # long enough for some bursts, however fast they go by
_PAUSE = 0.03  # s between two bursts: a flood would push good messages out of the queues


def visit(run):
    """Return somebody beside the run who sends whatever is wrong, and hears what our nodes say."""
    return Stranger(User(run).node, list(team().names), team().n)


def goes_on(stranger):
    """Return whether the plant runs under the controller."""
    states = stranger.heard["/plant/state"]
    return states and states[-1].commander and states[-1].status != PlantState.PAUSED


def play_disturbed(folder):
    """Play a short run; returns the commands, what the nodes printed, and the stranger."""
    folder.mkdir()
    with apart(short_scenario(duration=0.01 * TICKS), folder) as run:
        stranger = visit(run)
        kinds, last = cycle(stranger.kinds), [0.0]

        def watch():
            run.check()
            if goes_on(stranger) and time.monotonic() - last[0] > _PAUSE:
                stranger.send(next(kinds))
                last[0] = time.monotonic()

        run.play(watch)
        assert run.end() == []
        codes = {c.name: c.process.returncode for c in run.supervisor.children}
        assert set(codes.values()) == {0}, codes
    logs = {name: (folder / "logs" / f"{name}.log").read_text("utf-8") for name in NODES}
    return commands_in(folder / "bag"), logs, stranger


def play_alone(folder):
    """Play the same run, all nodes in one process and nobody beside it; returns the commands."""
    folder.mkdir()
    with together(short_scenario(duration=0.01 * TICKS), folder) as run:
        run.play()
    return commands_in(folder / "bag")


def commands_in(bag):
    """Return the controller's own commands; what a stranger sent is in the bag too."""
    found = []
    with AnyReader([bag]) as reader:
        connections = [c for c in reader.connections if c.topic == "/robot_a/chi"]
        for connection, _, data in reader.messages(connections):
            try:
                message = reader.deserialize(data, connection.msgtype)
            except AnyReaderError:
                continue  # garbage
            # Some bytes that the stranger sends happen to be a message, of nobody.
            if message.header.frame_id != FORGED and message.sender.startswith("hqp_controller@"):
                found.append(message)
    return found


def test_bad_input_changes_no_bit_of_the_motion_and_is_told(tmp_path):
    clean = play_alone(tmp_path / "clean")
    dirty, logs, stranger = play_disturbed(tmp_path / "dirty")
    assert stranger.sent > 300
    chi = [np.asarray(m.chi).tobytes() for m in clean]
    assert [m.tick for m in clean] == [m.tick for m in dirty] == list(range(TICKS))
    assert [np.asarray(m.chi).tobytes() for m in dirty] == chi
    assert dirty[-1].stack == "reach_base"
    for name in ("hqp_controller", "stack_solver", "sim_bridge"):
        assert "refused: " in logs[name], name
        assert "Traceback" not in logs[name]
    refusals = [line for line in logs["hqp_controller"].splitlines() if "refused" in line]
    assert len(refusals) < 60, "throttled"
    assert all(len(line) < 1000 for line in refusals)


# ---- two commanders


def test_a_second_robot_a_is_refused_with_the_name_of_the_first(tmp_path):
    with apart(short_scenario(events=(), duration=600.0), tmp_path) as run:
        user = User(run)
        assert user.call(SetBool, "/sim_bridge/pause", data=False).success
        user.until(lambda: user.commands)
        first = user.commands[0].sender
        given = ["--ros-args", "-p", f"scenario:={tmp_path / 'scenario.yaml'}"]
        second = run.supervisor.start("second", NODES["hqp_controller"], given)
        assert wait_until(run.executor, lambda: second.process.poll() is not None, PATIENCE)
        assert second.process.returncode == 2
        told = second.log.read_text(encoding="utf-8")
        assert f"error: the robots are commanded already, by {first}" in told
        assert "Traceback" not in told
        assert user.states[-1].commander == first
        assert {s.commander for s in user.states} <= {"", first}
        assert {m.sender for m in user.commands} == {first}


def test_of_two_that_begin_together_one_commands(tmp_path):
    with apart(short_scenario(events=(), duration=2.0), tmp_path) as run:
        user = User(run)
        given = ["--ros-args", "-p", f"scenario:={tmp_path / 'scenario.yaml'}"]
        run.supervisor.start("second", NODES["hqp_controller"], given)
        run.supervisor.wait_printed(["second"], "ready", 30.0)
        run.play(lambda: None)
        both = [run.process("hqp_controller"), run.process("second")]
        wait_until(run.executor, lambda: any(p.poll() is not None for p in both), 10.0)
        assert sorted(p.poll() is None for p in both) == [False, True], "one has ended"
        assert {p.poll() for p in both} == {None, 2}
        names = {s.commander for s in user.states} - {""}
        assert len(names) == 1
        states = [s for s in user.states if s.status != PlantState.PAUSED]
        steps = np.abs(np.diff([s.command for s in states], axis=0)) / (0.01 * LIMIT)
        assert steps.max() <= 1.0001
