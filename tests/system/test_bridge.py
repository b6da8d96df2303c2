"""The bridge, with a controller that this test plays."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from array import array

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped, Vector3, Wrench
from nav_msgs.msg import Odometry
from rclpy.experimental import EventsExecutor
from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from std_srvs.srv import SetBool, Trigger

from lexstack_bringup.processes import NODES, arguments_of
from lexstack_config.scenario import TimeoutsConfig
from lexstack_interfaces.msg import Chi, PlantState
from lexstack_interfaces.srv import ApplyWrench
from lexstack_plant.adapters.mujoco import SimBridge
from lexstack_ros.messages.qos import LATCHED, STREAM
from lexstack_ros.node.options import NodeOptions
from lexstack_testing.ros_session import ros_session
from lexstack_testing.user import Bystander
from support.plants import make_plant, sine
from support.scenario import changed, team

pytestmark = pytest.mark.system

DURATION = 0.6  # s, 60 ticks
PATIENCE = 20.0  # s of wall time for anything


class Controller:
    """Answers every state with a sine, as long as ``answers`` says so, and keeps all states."""

    def __init__(self, node):
        self.node = node
        self.plant = make_plant()
        self.states, self.times, self.others = [], [], {}
        self.answers = lambda _tick: True
        self.alter = lambda message: message
        self.out = node.create_publisher(Chi, "/robot_a/chi", STREAM)
        node.create_subscription(PlantState, "/plant/state", self.on_state, STREAM)
        for name, kind, qos in (
            ("/clock", Clock, STREAM),
            ("/robot_a/joint_states", JointState, STREAM),
            ("/robot_b/ee_pose", PoseStamped, STREAM),
            ("/robot_b/odom", Odometry, STREAM),
            ("/robot_a/robot_description", String, LATCHED),
            ("/diagnostics", DiagnosticArray, STREAM),
        ):
            received = self.others.setdefault(name, [])
            node.create_subscription(kind, name, received.append, qos)

    def on_state(self, state):
        self.states.append(state)
        self.times.append(time.monotonic())
        if state.status != PlantState.PAUSED and self.answers(state.tick):
            self.send(state.tick)

    def send(self, tick):
        chi = array("d", sine(self.plant, tick).tobytes())
        self.out.publish(
            self.alter(Chi(tick=tick, sender="test", robots=list(team().names), chi=chi))
        )

    @property
    def last(self):
        return self.states[-1] if self.states else PlantState()


class System(Bystander):
    """A bridge, in this process or as one of its own, and a node beside it in the same domain."""

    patience = PATIENCE

    def __init__(self, folder, context, mode, *, apart, **parameters):
        timeouts = TimeoutsConfig(command_wall=0.5)
        scenario = changed(duration=DURATION, timeouts=timeouts, events=(), mode=mode)
        path = folder / "scenario.yaml"
        path.write_text(scenario.to_yaml())
        parameters = {"scenario": str(path)} | parameters
        self.process, self.bridge = None, None
        self.executor = EventsExecutor(context=context)
        super().__init__(self, Node("test_controller", context=context))
        self.executor.add_node(self.node)
        self.controller = Controller(self.node)
        if apart:
            given = arguments_of("sim_bridge", parameters)
            self.process = subprocess.Popen(
                [sys.executable, "-m", NODES["sim_bridge"], *given],
                env=os.environ | {"ROS_PYTHON_CHECK_FIELDS": "1"},
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
            )
        else:
            self.bridge = SimBridge(NodeOptions(context, parameters=parameters))
            self.executor.add_node(self.bridge)

    def check(self):
        assert self.process is None or self.process.poll() is None, self.process.stdout.read()

    def place(self):
        return f" at tick {self.controller.last.tick}"

    def call(self, name, kind=Trigger, **request):
        return super().call(kind, f"/sim_bridge/{name}", **request)

    def ready(self):
        controller = self.controller
        self.until(lambda: controller.states and controller.out.get_subscription_count() > 0)
        return controller

    def release(self):
        assert self.call("pause", SetBool, data=False).success

    def stop(self, number=signal.SIGTERM):
        self.process.send_signal(number)
        output, _ = self.process.communicate(timeout=PATIENCE)
        return self.process.returncode, output

    def close(self):
        if self.process is not None and self.process.poll() is None:
            self.process.terminate()  # a kill would leave its participant to the others
            self.process.communicate(timeout=PATIENCE)
        self.executor.shutdown()
        self.node.destroy_node()
        if self.bridge is not None:
            self.bridge.destroy_node()


@pytest.fixture
def bring_up(tmp_path):
    with ros_session(children=True) as context:
        systems = []

        def make(mode="lockstep", *, apart=False, **parameters):
            while systems:  # of an attempt before
                systems.pop().close()
            systems.append(System(tmp_path, context, mode, apart=apart, **parameters))
            return systems[-1]

        yield make
        for system in systems:
            system.close()


def running(states):
    return [state for state in states if state.status != PlantState.PAUSED]


def test_lockstep_runs_the_plant_to_the_bit_and_ends_paused(bring_up):
    system = bring_up(apart=True)
    controller = system.ready()
    assert controller.last.status == PlantState.PAUSED
    assert list(controller.last.robots) == list(team().names)
    system.spin(0.3)
    assert controller.last.tick == 0  # nothing moves before it is released
    system.release()
    system.until(lambda: controller.last.tick == 60)
    assert controller.last.status == PlantState.PAUSED
    states = running(controller.states)
    assert [state.tick for state in states] == list(range(60))
    plant = make_plant(duration=DURATION)
    for state in [*states, controller.last]:
        expected = plant.state()
        for name in ("q", "v", "q_star", "command"):
            np.testing.assert_array_equal(getattr(state, name), getattr(expected, name))
        assert state.header.stamp.nanosec == round(state.tick * 1e7)
        plant.step(sine(plant, state.tick))
    assert controller.last.late_ticks == controller.last.missing_ticks == 0
    assert not system.call("pause", SetBool, data=False).success  # the scenario has ended
    code, output = system.stop()
    assert code == 0, output
    assert "finished: 60 ticks" in output
    assert "Traceback" not in output


def test_tools_get_joint_states_poses_odometry_clock_and_description(bring_up):
    system = bring_up()
    controller = system.ready()
    system.release()
    system.until(lambda: controller.last.tick == 60)
    system.until(lambda: controller.others["/diagnostics"])
    system.spin(0.3)
    got = controller.others
    joints = got["/robot_a/joint_states"]
    seconds = controller.times[-1] - controller.times[0]
    assert len(joints) <= 50.0 * seconds + 3.0, "50 Hz of wall time"
    assert 2 <= len(got["/clock"]) <= 100.0 * seconds + 3.0
    assert {len(m.name) for m in joints} == {len(joints[0].position)} == {len(joints[0].effort)}
    by_stamp = {state.header.stamp.nanosec: state for state in controller.states}
    last = joints[-1]
    np.testing.assert_allclose(last.position[:10], by_stamp[last.header.stamp.nanosec].q[:10])
    assert max(abs(effort) for effort in last.effort) > 5.0
    pose = got["/robot_b/ee_pose"][-1]
    tool = team().tools(np.array(by_stamp[pose.header.stamp.nanosec].q))[1]
    place = pose.pose.position
    np.testing.assert_allclose([place.x, place.y, place.z], tool.position, atol=1e-9)
    odometry = got["/robot_b/odom"][-1]
    state = by_stamp[odometry.header.stamp.nanosec]
    assert odometry.pose.pose.position.x == pytest.approx(state.q[10])
    speed = np.hypot(odometry.twist.twist.linear.x, odometry.twist.twist.linear.y)
    assert speed == pytest.approx(np.hypot(state.v[10], state.v[11]))
    last = controller.last.header.stamp
    assert got["/clock"][-1].clock == last, "told again while the plant stands"
    assert "<robot" in got["/robot_a/robot_description"][-1].data
    status = next(s for m in got["/diagnostics"] for s in m.status if s.name == "sim_bridge")
    assert {"tick", "missing ticks", "refused commands"} <= {value.key for value in status.values}


def test_pause_step_and_reset(bring_up):
    system = bring_up()
    controller = system.ready()
    assert system.call("step").success
    system.until(lambda: controller.last.tick == 1)
    system.spin(0.3)
    assert controller.last.tick == 1
    assert controller.last.status == PlantState.PAUSED
    controller.answers = lambda tick: tick < 20
    system.release()
    assert not system.call("step").success  # it runs
    system.until(lambda: controller.last.tick == 20)
    assert system.call("pause", SetBool, data=True).success
    controller.answers = lambda _tick: True
    controller.send(20)
    system.until(lambda: controller.last.status == PlantState.PAUSED)
    assert controller.last.tick >= 21
    assert system.call("reset").success
    system.until(lambda: controller.last.tick == 0)
    system.release()
    system.until(lambda: controller.last.tick == 60)
    first, second = ([s for s in running(controller.states) if s.tick == 15][i] for i in (0, -1))
    np.testing.assert_array_equal(first.q, second.q)


def test_a_push_moves_the_link_and_a_wrong_one_is_refused(bring_up):
    system = bring_up()
    controller = system.ready()
    controller.alter = lambda message: Chi(
        tick=message.tick, robots=message.robots, chi=array("d", [0.0] * 20)
    )
    wrong = system.call("apply_wrench", ApplyWrench, robot="robot_c", link="tool", duration=0.1)
    assert not wrong.success
    assert "unknown robot 'robot_c'; known: robot_a, robot_b" in wrong.message
    wrong = system.call("apply_wrench", ApplyWrench, robot="robot_a", link="tool")
    assert "duration: must be finite and > 0" in wrong.message
    push = Wrench(force=Vector3(x=30.0))
    given = {"robot": "robot_b", "link": "panda_link4", "wrench": push, "duration": 0.2}
    assert system.call("apply_wrench", ApplyWrench, **given).success
    system.release()
    system.until(lambda: controller.last.tick == 60)
    moved = np.abs(np.array([s.q for s in controller.states]) - controller.states[0].q).max(axis=0)
    assert moved[13:].max() > 2e-3, "the arm that was pushed"
    assert moved[:10].max() < 1e-6, "the other robot"
    assert np.abs(np.array(controller.last.q) - controller.states[0].q).max() < 1e-3, "back"


def test_wrong_commands_are_refused_and_the_right_one_still_counts(bring_up, capfd):
    system = bring_up()
    controller = system.ready()
    wrongs = [
        {"tick": 7},
        {"robots": ["robot_b", "robot_a"]},
        {"chi": array("d", [0.0] * 19)},
        {"chi": array("d", [float("nan")] * 20)},
        {"status": Chi.FAILED},
    ]

    def with_wrongs(message):
        for wrong in wrongs:
            fields = {name: getattr(message, name) for name in ("tick", "robots", "chi", "status")}
            controller.out.publish(Chi(**(fields | wrong)))
        return message

    controller.alter = with_wrongs
    system.release()
    system.until(lambda: controller.last.tick == 60)
    assert controller.last.missing_ticks == 0
    expected = make_plant(duration=DURATION)
    for tick in range(60):
        state = expected.step(sine(expected, tick))
    np.testing.assert_array_equal(controller.last.q, state.q)
    assert "refused: /robot_a/chi" in capfd.readouterr().err


def test_lockstep_brakes_when_the_controller_is_lost_and_goes_on_when_it_returns(bring_up):
    system = bring_up()
    controller = system.ready()
    controller.answers = lambda tick: not 20 <= tick < 45
    system.release()
    system.until(lambda: controller.last.tick == 60)
    statuses = {state.tick: state.status for state in controller.states}
    assert statuses[20] == PlantState.FOLLOWING
    assert {statuses[tick] for tick in range(21, 31)} == {PlantState.HOLDING}
    assert {statuses[tick] for tick in range(31, 46)} == {PlantState.BRAKING}
    assert statuses[50] == PlantState.FOLLOWING
    assert controller.last.missing_ticks == 25


@pytest.mark.realtime
def test_realtime_keeps_the_wall_clock_and_counts_missing_commands(bring_up):
    system = bring_up("realtime", apart=True)
    controller = system.ready()
    controller.answers = lambda tick: tick != 30
    system.release()
    system.until(lambda: controller.last.tick == 60)
    first = controller.states.index(running(controller.states)[0])
    taken = controller.times[-1] - controller.times[first]
    assert taken == pytest.approx(DURATION, abs=0.1)
    assert [state.tick for state in running(controller.states)] == list(range(60))
    assert 1 <= controller.last.missing_ticks <= 20  # the rest is this machine's load


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_it_ends_cleanly_at_a_signal(bring_up, number):
    system = bring_up(apart=True)
    controller = system.ready()
    system.release()
    system.until(lambda: controller.last.tick > 5)
    code, output = system.stop(number)
    assert code == 0, output
    assert "Traceback" not in output


def test_it_ends_with_the_scenario_if_asked(bring_up):
    system = bring_up("realtime", apart=True, start_paused=False, exit_at_end=True)
    output, _ = system.process.communicate(timeout=PATIENCE)
    assert system.process.returncode == 0, output
    assert "finished" in output
