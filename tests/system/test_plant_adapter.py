"""The adapter of ros2_control and its stand-in, with all processes."""

from __future__ import annotations

import re
import signal
from dataclasses import replace

import numpy as np
import pytest
import yaml
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TwistStamped
from sensor_msgs.msg import JointState
from std_srvs.srv import SetBool

from lexstack.errors import LexstackError
from lexstack_bringup.processes import ADAPTER, MODULES, arguments_of
from lexstack_bringup.real_plant import RealPlant
from lexstack_config.plant_file import load_plant
from lexstack_interfaces.msg import PlantState
from lexstack_interfaces.srv import SwitchStack
from lexstack_ros.node.readiness import READY
from lexstack_testing.stand_in.run import STAND_IN, with_stand_in
from lexstack_testing.user import User
from support.ideal_hardware import PLANT
from support.scenario import changed, resolved, team

pytestmark = [pytest.mark.system, pytest.mark.timeout(240)]

QUICK = "reorder,velocities=0,quantum=1e-4,jitter=0.002"
SPEED = "speed=0.3,reorder,velocities=0,quantum=1e-4,jitter=0.002"


def real(tmp_path):
    """Return the robots, in simulated time: a busy machine makes them slow, not late."""
    content = yaml.safe_load(PLANT.read_text(encoding="utf-8"))
    content |= {"name": "slow", "use_sim_time": True, "safety": {"stop": "/stop"}}
    for robot in content["robots"].values():
        robot["arm"]["ahead"] = 5
    path = tmp_path / "slow.yaml"
    path.write_text(yaml.safe_dump(content), encoding="utf-8")
    return RealPlant(path, load_plant(path), enable=True)


def in_wall_time(tmp_path):
    """Return the robots, in the time of the wall."""
    content = yaml.safe_load(PLANT.read_text(encoding="utf-8"))
    path = tmp_path / "quick.yaml"
    path.write_text(yaml.safe_dump(content | {"name": "quick"}), encoding="utf-8")
    return RealPlant(path, load_plant(path), enable=True)


def folder(tmp_path):
    out = tmp_path / "run"
    out.mkdir()
    return out


def test_a_switch_runs_through_the_adapter_and_no_drive_stops(tmp_path):
    (event, *_) = resolved().scenario.events
    events = (replace(event, at=0.5),)
    scenario = changed(duration=4.0, events=events, base_target={"robot_a": (0.0, -0.2, 0.0)})
    with with_stand_in(scenario, folder(tmp_path), real(tmp_path), SPEED) as run:
        user = User(run)
        run.play()
        assert "reach_base" in run.player.adopted
        last = user.states[-1]
        assert last.status == PlantState.PAUSED
        assert last.tick >= 400
        assert last.q[1] == pytest.approx(-0.2, abs=0.02)
        assert not any(last.command)
        assert {state.status for state in user.states} <= {
            *(PlantState.FOLLOWING, PlantState.HOLDING, PlantState.BRAKING, PlantState.PAUSED)
        }
        log = (run.out / "logs" / f"{STAND_IN}.log").read_text(encoding="utf-8")
        assert "reflex" not in log
        adapter = (run.out / "logs" / f"{ADAPTER}.log").read_text(encoding="utf-8")
        assert "stopping: the scenario has ended" in adapter


def test_a_killed_solver_changes_nothing_and_a_killed_controller_brakes(tmp_path):
    """After 0.1 s without commands it brakes, after 1 s more it is disabled, with the reason."""
    scenario = changed(duration=100.0, events=(), base_target={"robot_a": (0.0, -2.0, 0.0)})
    with with_stand_in(scenario, folder(tmp_path), real(tmp_path), SPEED) as run:
        user = User(run)
        for name in ("robot_a", "robot_b"):
            assert user.call(SetBool, f"/{name}/enable", data=True).success
        user.until(lambda: user.states and user.states[-1].tick > 30)
        assert user.call(SwitchStack, "/robot_a/switch_stack", stack="reach_base").accepted
        user.until(lambda: abs(user.states[-1].command[1]) > 0.2, "the base to move")

        run.send("stack_solver", signal.SIGKILL)
        begun = user.states[-1].tick
        user.until(lambda: user.states[-1].tick > begun + 30, "30 ticks more")
        since = [state for state in user.states if state.tick > begun]
        assert {state.status for state in since} <= {PlantState.FOLLOWING, PlantState.HOLDING}

        run.send("hqp_controller", signal.SIGKILL)
        user.until(lambda: user.states[-1].status == PlantState.PAUSED, "the robots to rest")
        states = [state for state in user.states if state.tick > begun]
        last = max(k for k, s in enumerate(states) if s.status == PlantState.FOLLOWING)
        seen = [state.status for state in states[last + 1 :]]
        assert seen[0] == PlantState.HOLDING
        assert PlantState.BRAKING in seen
        commands = np.array([state.command for state in states[last:]])
        limit = 0.01 * team().limits.acceleration
        assert (np.abs(np.diff(commands, axis=0)) <= limit * (1 + 1e-9)).all()
        assert not commands[-1].any()
        log = run.out / "logs" / f"{ADAPTER}.log"
        user.until(lambda: "disabled: no commands for 1.1 s" in log.read_text(encoding="utf-8"))

        given = {"scenario": str(run.path), "peers": ADAPTER}
        name = "hqp_controller"
        child = run.supervisor.start(name, MODULES[name], arguments_of(name, given))
        user.until(lambda: child.printed(READY), "the new controller")
        for name in ("robot_a", "robot_b"):
            answer = user.call(SetBool, f"/{name}/enable", data=True)
            assert answer.success, answer.message
        user.until(lambda: user.states[-1].status == PlantState.FOLLOWING, "its commands")
        assert user.states[-1].resets == 1


def test_a_switch_runs_in_the_time_of_the_wall(tmp_path):
    """A busy machine may end it, but only by what the processes count as their own lateness."""
    (event, *_) = resolved().scenario.events
    events = (replace(event, at=0.5),)
    scenario = changed(duration=4.0, events=events, base_target={"robot_a": (0.0, -0.2, 0.0)})
    with with_stand_in(scenario, folder(tmp_path), in_wall_time(tmp_path), QUICK) as run:
        user = User(run)
        stopped = ""
        try:
            run.play()
        except LexstackError as error:
            stopped = str(error)
        last, logs = user.states[-1], run.out / "logs"
    stand_in = (logs / f"{STAND_IN}.log").read_text(encoding="utf-8")
    adapter = (logs / f"{ADAPTER}.log").read_text(encoding="utf-8")
    counted = re.search(r"at (\d+) of (\d+) looks, at most (\d+) ms", stand_in)
    assert counted is not None
    assert int(counted[2]) > 0
    if stopped:
        # A trajectory goes on by itself for 0.15 s; whoever was away for longer was late.
        assert max(100 * (last.late_ticks + last.missing_ticks > 10), int(counted[3])) >= 100
        return
    assert "reflex" not in stand_in
    assert "stopping: the scenario has ended" in adapter
    assert "reach_base" in run.player.adopted
    assert last.q[1] == pytest.approx(-0.2, abs=0.02)
    assert not any(last.command)


def test_an_emergency_stop_a_new_start_and_the_end_of_the_adapter(tmp_path):
    scenario = changed(duration=100.0, events=(), base_target={"robot_a": (0.0, -1.0, 0.0)})
    with with_stand_in(scenario, folder(tmp_path), real(tmp_path), SPEED) as run:
        user = User(run)
        diagnostics = user.hear(DiagnosticArray, "/diagnostics", [])
        twists = user.hear(TwistStamped, "/robot_a/cmd_vel", [])
        joints = user.hear(JointState, "/robot_a/joint_states", [])
        for name in ("robot_a", "robot_b"):
            assert user.call(SetBool, f"/{name}/enable", data=True).success
        user.until(lambda: user.states and user.states[-1].tick > 30)
        assert user.call(SwitchStack, "/robot_a/switch_stack", stack="reach_base").accepted
        user.until(lambda: abs(user.states[-1].command[1]) > 0.2, "the base to move")

        assert user.call(SetBool, "/robot_a/stand_in/stop", data=True).success
        user.until(lambda: user.states[-1].status == PlantState.PAUSED, "the robots to rest")
        before = user.states[-1].tick
        user.until(
            lambda: any(
                "emergency stop" in status.message
                for array in diagnostics
                for status in array.status
                if status.name == ADAPTER
            ),
            "the reason",
        )
        refused = user.call(SetBool, "/robot_a/enable", data=True)
        assert not refused.success
        assert "the emergency stop is pressed" in refused.message

        assert user.call(SetBool, "/robot_a/stand_in/stop", data=False).success
        user.spin(1.0)
        begun = len(user.states)
        for name in ("robot_a", "robot_b"):
            answer = user.call(SetBool, f"/{name}/enable", data=True)
            assert answer.success, answer.message
        user.until(
            lambda: any(s.status != PlantState.PAUSED for s in user.states[begun:]), "a new start"
        )
        user.until(lambda: user.states[-1].tick > 30)
        again = [s for s in user.states[begun:] if s.status == PlantState.FOLLOWING]
        assert again[0].tick < before
        assert again[0].resets == 1
        # The stack is the first one again, and the base stays where it was stopped.
        assert max(np.abs(np.array(s.command)).max() for s in again) < 0.02

        assert user.call(SwitchStack, "/robot_a/switch_stack", stack="reach_base").accepted
        user.until(lambda: abs(user.states[-1].command[1]) > 0.2, "the base to move again")
        child = run.child(ADAPTER)
        child.process.send_signal(signal.SIGTERM)
        assert child.process.wait(10.0) == 0
        run.supervisor.children.remove(child)
        user.spin(1.0)
        last = twists[-1].twist
        assert (last.linear.x, last.linear.y, last.angular.z) == (0.0, 0.0, 0.0)
        moving = [twist.twist.linear.y for twist in twists[-200:] if twist.twist.linear.y]
        steps = np.abs(np.diff([*moving, 0.0]))
        assert steps.max() <= 6.0 * 0.01 * 1.01  # m/s in a tick: the base's acceleration limit
        positions = np.array([m.position for m in joints[-5:]])
        assert positions.shape[0] == 5
