"""Bad input to live nodes: not a bit of the motion changes, and every refusal is told."""

import copy
import time

import numpy as np
import pytest
import rclpy
from geometry_msgs.msg import PoseStamped
from rclpy.serialization import serialize_message
from rosbags.highlevel import AnyReader, AnyReaderError
from std_msgs.msg import String
from std_srvs.srv import SetBool

from lexstack_bringup.processes import NODES
from lexstack_interfaces.msg import Chi, PlantState, StackRequest
from lexstack_ros.messages.qos import LATCHED, STREAM
from lexstack_testing.played_run import apart
from support.runs import short_scenario
from support.scenario import team

pytestmark = pytest.mark.system
LIMIT = team().limits.acceleration
TOPICS = {
    "/plant/state": PlantState,
    "/robot_a/chi": Chi,
    "/robot_b/chi": Chi,
    "/robot_a/ee_target": PoseStamped,
    "/robot_b/base_target": PoseStamped,
    "/robot_a/request_stack": String,
    "/robot_a/stack_request": StackRequest,
}
TICKS = 800  # long enough for some bursts, however fast they go by
_PAUSE = 0.25  # s between two bursts: a flood would push good messages out of the queues
HEARD = ("/plant/state", "/robot_a/chi", "/robot_b/chi")


class Stranger:
    """A node that sends whatever is wrong, on the topics that our nodes hear."""

    def __init__(self, run):
        self.node = rclpy.create_node("stranger", context=run.context)
        run.executor.add_node(self.node)
        self.rng = np.random.default_rng(0)
        self.sent = 0
        self.heard = {topic: [] for topic in HEARD}
        self.out = {}
        for topic, kind in TOPICS.items():
            qos = LATCHED if kind is StackRequest else STREAM
            self.out[topic] = self.node.create_publisher(kind, topic, qos)
        for topic in HEARD:
            self.node.create_subscription(TOPICS[topic], topic, self.heard[topic].append, STREAM)

    def send(self, topic, message):
        self.out[topic].publish(message)
        self.sent += 1

    def garbage(self):
        """Send bytes that are no message, and messages with bytes changed."""
        for topic, kind in TOPICS.items():
            good = bytearray(serialize_message(kind()))
            for _ in range(3):
                at = int(self.rng.integers(4, len(good)))
                good[at] ^= 0xFF
            # A changed number may be a number still: only what cannot be a message is sent raw.
            self.send(topic, b"\x00\x01\x00\x00" + self.rng.bytes(7))
            self.send(topic, bytes(self.rng.bytes(int(self.rng.integers(0, 64)))))
            self.send(topic, bytes(good[: int(self.rng.integers(0, len(good)))]))

    def states(self, last):
        """Send states that are wrong, old, repeated, of the future, or another plant's."""
        for change in (
            {"q": [float("nan")] * 20},
            {"v": [float("inf")] * 20},
            {"q": [1e300] * 20},
            {"q": [0.0] * 3},
            {"command": []},
            {"robots": ["robot_b", "robot_a"]},
            {"robots": ["x" * 10_000]},
            {"sender": ""},
            {"sender": "other@host/1/0", "q": [0.1] * 20},
            {"sender": "other@host/1/0", "tick": 0, "resets": 7},
            {"tick": last.tick + 5000},
            {"tick": 0},
            {},  # once more
        ):
            state = copy.deepcopy(last)
            for field, value in change.items():
                setattr(state, field, value)
            self.send("/plant/state", state)
        for old in self.heard["/plant/state"][-60:-5:10]:
            self.send("/plant/state", old)

    def solutions(self, last):
        """Send chi that is wrong, old, of the future, or nobody's, for robot A and as robot A."""
        names = list(team().names)
        for topic in ("/robot_a/chi", "/robot_b/chi"):
            for values in (
                {"chi": [float("nan")] * 20},
                {"chi": [0.5] * 7},
                {"chi": [1e300] * 20},
                {"chi": [0.5] * 20, "robots": ["x", "y"]},
                {"chi": [0.5] * 20, "tick": last.tick + 1000},
                {"chi": [0.5] * 20, "tick": max(0, last.tick - 5)},
                {"chi": [0.5] * 20, "transition_id": 999},
            ):
                fields = {"robots": names, "tick": last.tick, "sender": "stranger@host/9/0"}
                if topic == "/robot_b/chi":
                    fields |= {"transition_id": 1} if "tick" in values else {"transition_id": 999}
                self.send(topic, Chi(**(fields | values)))
        # A whole command, for the very tick, by another process.
        command = {"robots": names, "chi": [0.5] * 20, "tick": last.tick}
        for sender in ("", "stranger@host/9/0", "x" * 10_000):
            self.send("/robot_a/chi", Chi(sender=sender, **command))

    def requests(self):
        """Send targets and requests that are refused."""
        for x, w, frame in ((np.nan, 1.0, "world"), (1.0, 0.0, "world"), (1.0, 1.0, "map")):
            pose = PoseStamped()
            pose.header.frame_id = frame
            pose.pose.position.x, pose.pose.orientation.w = float(x), w
            self.send("/robot_a/ee_target", pose)
            self.send("/robot_b/base_target", pose)
        for stack in ("dance", "", "x" * 100_000, "a\nb"):
            self.send("/robot_a/request_stack", String(data=stack))
        self.send("/robot_a/stack_request", StackRequest(id=9, stack="dance", active=True))

    def everything(self):
        """Send all of it once, if the plant runs under robot A."""
        states = self.heard["/plant/state"]
        if not states or not states[-1].commander or states[-1].status == PlantState.PAUSED:
            return
        self.garbage()
        self.states(states[-1])
        self.solutions(states[-1])
        self.requests()


def play(folder, stranger):
    """Play a short run; returns robot A's commands, what the nodes printed, and the stranger."""
    folder.mkdir()
    with apart(short_scenario(duration=0.01 * TICKS), folder) as run:
        visitor = Stranger(run)
        last = [0.0]

        def watch():
            run.supervisor.check()
            if stranger and time.monotonic() - last[0] > _PAUSE:
                visitor.everything()
                last[0] = time.monotonic()

        run.play(watch)
        assert run.end() == []
        codes = {c.name: c.process.returncode for c in run.supervisor.children}
        assert set(codes.values()) == {0}, codes
        visitor.node.destroy_node()
    logs = {name: (folder / "logs" / f"{name}.log").read_text("utf-8") for name in NODES}
    return commands_in(folder / "bag"), logs, visitor


def commands_in(bag):
    """Return robot A's own commands; what a stranger sent stands in the bag too, as it came."""
    found = []
    with AnyReader([bag]) as reader:
        connections = [c for c in reader.connections if c.topic == "/robot_a/chi"]
        for connection, _, data in reader.messages(connections):
            try:
                message = reader.deserialize(data, connection.msgtype)
            except AnyReaderError:
                continue  # garbage
            if message.sender.startswith("hqp_controller@"):
                found.append(message)
    return found


def test_bad_input_changes_no_bit_of_the_motion_and_is_told(tmp_path):
    clean, _, _ = play(tmp_path / "clean", stranger=False)
    dirty, logs, stranger = play(tmp_path / "dirty", stranger=True)
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
        visitor = Stranger(run)

        def until(condition):
            end = time.monotonic() + 30.0
            while not condition():
                run.supervisor.check(expected=["second"])
                assert time.monotonic() < end
                run.executor.spin_once(timeout_sec=0.02)

        pause = visitor.node.create_client(SetBool, "/sim_bridge/pause")
        until(pause.service_is_ready)
        pause.call_async(SetBool.Request(data=False))
        until(lambda: visitor.heard["/robot_a/chi"])
        first = visitor.heard["/robot_a/chi"][0].sender
        given = ["--ros-args", "-p", f"scenario:={tmp_path / 'scenario.yaml'}"]
        second = run.supervisor.start("second", NODES["hqp_controller"], given)
        until(lambda: second.process.poll() is not None)
        assert second.process.returncode == 2
        told = second.log.read_text(encoding="utf-8")
        assert f"error: the robots are commanded already, by {first}" in told
        assert "Traceback" not in told
        assert visitor.heard["/plant/state"][-1].commander == first
        assert {s.commander for s in visitor.heard["/plant/state"]} <= {"", first}
        assert {m.sender for m in visitor.heard["/robot_a/chi"]} == {first}
        visitor.node.destroy_node()


def test_of_two_that_begin_together_one_commands(tmp_path):
    with apart(short_scenario(events=(), duration=2.0), tmp_path) as run:
        visitor = Stranger(run)
        given = ["--ros-args", "-p", f"scenario:={tmp_path / 'scenario.yaml'}"]
        run.supervisor.start("second", NODES["hqp_controller"], given)
        run.supervisor.wait_printed(["second"], "ready", 30.0)
        run.play(lambda: None)
        both = [run.process("hqp_controller"), run.process("second")]
        end = time.monotonic() + 10.0
        while all(p.poll() is None for p in both) and time.monotonic() < end:
            time.sleep(0.05)
        assert sorted(p.poll() is None for p in both) == [False, True], "one has ended"
        assert {p.poll() for p in both} == {None, 2}
        names = {s.commander for s in visitor.heard["/plant/state"]} - {""}
        assert len(names) == 1
        states = [s for s in visitor.heard["/plant/state"] if s.status != PlantState.PAUSED]
        steps = np.abs(np.diff([s.command for s in states], axis=0)) / (0.01 * LIMIT)
        assert steps.max() <= 1.0001
        visitor.node.destroy_node()
