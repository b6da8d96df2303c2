"""All processes together: the sequence, its bits, faults, and the end."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from lexstack_config.resolved import load_scenario
from lexstack_interfaces.msg import TransitionStatus
from lexstack_testing.played_run import apart, together
from support.logs import until_printed
from support.runs import acceleration_ratio, chi_by_tick, read, short_scenario, transitions
from support.scenario import ROOT, SCENARIO, changed, team

pytestmark = pytest.mark.system
LIMIT = team().limits.acceleration


def demo(*arguments, **options):
    """Run the demo command and return what it did."""
    environment = {k: v for k, v in os.environ.items() if k != "ROS_DOMAIN_ID"}
    return subprocess.run(
        [sys.executable, "-m", "lexstack_bringup.commands.demo", *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=110,
        check=False,
        cwd=ROOT,
        env=environment,
        **options,
    )


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Run the default demo once, as a user does."""
    out = tmp_path_factory.mktemp("whole") / "run"
    return out, demo("--out", out)


def test_the_demo_reaches_what_it_promises(whole):
    out, done = whole
    assert done.returncode == 0, done.stderr
    metrics = json.loads((out / "metrics.json").read_text(encoding="utf-8"))
    assert [phase["stack"] for phase in metrics["phases"]] == [
        "track",
        "reach_base",
        "posture_mid_range",
        "track",
    ]
    assert all(phase["transition_s"] is not None for phase in metrics["phases"][1:])
    assert metrics["ticks"] == 2600
    assert metrics["peak_acceleration_ratio"] <= 1.0001
    for key in ("empty_bounds", "solver_failures", "missing_ticks", "recorder_lost"):
        assert metrics[key] == 0, (key, (out / "logs/recorder.log").read_text(encoding="utf-8"))
    reached, final = metrics["phases"][1], metrics["phases"][3]
    assert max(reached["ee_error_mm"].values()) <= 2.0
    assert max(reached["base_error_mm"].values()) <= 5.0
    assert max(final["ee_error_mm"].values()) <= 1.0
    assert "NOT reached" not in done.stdout


def test_the_demo_leaves_a_complete_run_folder(whole):
    out, _ = whole
    names = {path.relative_to(out).as_posix() for path in out.rglob("*")}
    assert {"bag/metadata.yaml", "metrics.json", "report.html", "scenario.yaml"} <= names
    assert {f"logs/{n}.log" for n in ("sim_bridge", "hqp_controller", "stack_solver")} <= names


def test_the_same_seed_gives_the_same_bits(whole, tmp_path):
    """The one in processes, the other in one."""
    out, _ = whole
    again = tmp_path / "again"
    again.mkdir()
    with together(load_scenario(SCENARIO), again) as run:
        run.play()
        assert run.end() == []
    for topic in ("/robot_a/chi", "/robot_b/chi"):
        one, other = chi_by_tick(out / "bag", topic), chi_by_tick(again / "bag", topic)
        assert len(one) > 300
        assert one.keys() == other.keys()
        assert all(one[tick] == other[tick] for tick in one), topic


@pytest.mark.realtime
def test_realtime_completes_and_counts_late_ticks(tmp_path):
    """The bridge stands still for 0.3 s in the middle: one tick more is late, at least."""
    stopped = []

    def watch():
        run.supervisor.check()
        if run.player.tick >= 200 and not stopped:
            bridge = run.process("sim_bridge")
            stopped.append(run.player.tick)
            bridge.send_signal(signal.SIGSTOP)
            time.sleep(0.3)
            bridge.send_signal(signal.SIGCONT)

    with apart(short_scenario(mode="realtime"), tmp_path) as run:
        begun = time.monotonic()
        run.play(watch)
        assert time.monotonic() - begun >= 3.9, "paced by the clock"
        assert run.end() == []
    states = read(tmp_path / "bag", "/plant/state")["/plant/state"]
    assert states[-1].tick == 400
    late = {state.tick: state.late_ticks for state in states}
    assert sorted(late.values()) == list(late.values()), "they never get less"
    assert late[stopped[0] + 50] >= late[stopped[0] - 1] + 1
    assert late[400] < 100, "and a tick that is in time is not late"
    assert acceleration_ratio(tmp_path / "bag", LIMIT, 0.01) <= 1.0001
    phases = [m.phase for m in transitions(tmp_path / "bag")]
    assert TransitionStatus.ADOPTING in phases


def blending(run, alpha):
    """Return whether the controller is on its way to the new stack."""
    status = run.player.transition
    return (
        status is not None and status.phase == TransitionStatus.BLENDING and status.alpha >= alpha
    )


@pytest.mark.parametrize("mode", ["lockstep", pytest.param("realtime", marks=pytest.mark.realtime)])
def test_kill_9_of_robot_b_while_it_blends(tmp_path, mode):
    with apart(short_scenario(mode=mode), tmp_path) as run:
        victim = run.process("stack_solver")

        def watch():
            run.supervisor.check(expected=["stack_solver"])
            if blending(run, 0.1):
                victim.kill()

        run.play(watch)
        assert victim.wait(5) == -signal.SIGKILL
        run.end()
    bag = tmp_path / "bag"
    assert acceleration_ratio(bag, LIMIT, 0.01) <= 1.0001
    commands = read(bag, "/robot_a/chi")["/robot_a/chi"]
    assert sum(m.empty_bounds for m in commands) == 0
    assert commands[-1].tick == 399, "the motion goes on"
    statuses = transitions(bag)
    assert "the solver lost at tick" in statuses[-1].reason
    assert "local" in {m.source for m in statuses}
    assert statuses[-1].to_stack == "reach_base"
    assert statuses[-1].phase == TransitionStatus.IDLE


def test_death_of_robot_a_is_told_with_its_last_lines_and_the_plant_brakes(tmp_path):
    timeouts = changed().scenario.timeouts
    scenario = short_scenario(timeouts=type(timeouts)(command_wall=0.3))
    with apart(scenario, tmp_path) as run:
        victim = run.process("hqp_controller")

        def watch():
            if blending(run, 0.5):
                victim.kill()

        run.play(watch)  # the plant goes on alone, at its own pace
        with pytest.raises(Exception, match="hqp_controller was killed by SIGKILL"):
            run.supervisor.check()
        run.end()
    states = read(tmp_path / "bag", "/plant/state")["/plant/state"]
    assert states[-1].missing_ticks > 100
    assert max(abs(value) for value in states[-1].command) == 0.0, "at rest"
    import numpy as np

    moving = [s for s in states if s.status != 3]
    commands = np.array([s.command for s in moving])
    steps = np.abs(np.diff(commands, axis=0)) / (0.01 * LIMIT)
    assert np.abs(commands).max() > 0.1
    assert steps.max() <= 1.0001


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=["SIGINT", "SIGTERM"])
def test_every_process_ends_cleanly_on_a_signal(tmp_path, number):
    with apart(short_scenario(), tmp_path) as run:
        run.play(lambda: None)
        for child in run.supervisor.children:
            child.process.send_signal(number)
            child.process.send_signal(number)
        codes = {c.name: c.process.wait(15) for c in run.supervisor.children}
    assert set(codes.values()) == {0}, codes
    assert len(read(tmp_path / "bag", "/robot_a/chi")["/robot_a/chi"]) == 400


def test_ctrl_c_leaves_no_process_and_a_bag(tmp_path):
    out = tmp_path / "run"
    environment = {k: v for k, v in os.environ.items() if k != "ROS_DOMAIN_ID"}
    process = subprocess.Popen(
        [
            sys.executable,
            "-m",
            "lexstack_bringup.commands.demo",
            "--mode",
            "realtime",
            "--out",
            str(out),
        ],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=ROOT,
        env=environment,
    )
    until_printed(out / "logs" / "hqp_controller.log", "starts at tick", process)
    children = children_of(process.pid)
    assert len(children) == 4
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=40)
    assert process.returncode == 130
    assert "interrupted" in errors
    assert not [pid for pid in children if Path(f"/proc/{pid}").exists()]
    assert read(out / "bag", "/plant/state")["/plant/state"]


def children_of(pid):
    """Return the process ids of a process's children."""
    return [int(p) for p in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]


def test_a_child_that_dies_ends_the_demo_with_its_name(tmp_path):
    scenario = tmp_path / "broken.yaml"
    text = (ROOT / "config/scenarios/transition-sequence.yaml").read_text(encoding="utf-8")
    scenario.write_text(text.replace("rate: 100.0", "rate: 333.0"), encoding="utf-8")
    done = demo(scenario, "--out", tmp_path / "run")
    assert done.returncode == 1
    assert "sim_bridge ended with exit code 2" in done.stderr
    assert "multiple of" in done.stderr, "with the last lines of its log"
