"""Several hosts: each starts its share of the nodes, they find each other, and survive a cut."""

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import yaml

from lexstack_bringup.hosts import VARIABLES
from lexstack_interfaces.msg import PlantState
from lexstack_testing.virtual_lan import Lan, why_not
from support.logs import until_printed
from support.runs import acceleration_ratio, read
from support.scenario import CONFIG, ROOT, SCENARIO, team

WHY_NOT = why_not()
pytestmark = [
    pytest.mark.system,
    pytest.mark.skipif(bool(WHY_NOT), reason=WHY_NOT or "never"),
]
LIMIT = team().limits.acceleration
HOSTS = ("simulation", "robot_a", "robot_b")
PATIENCE = 60.0  # s


class Deployment:
    """A run on three hosts, each by its own ``bringup``."""

    def __init__(self, folder, discovery, mode, duration, events, variables=None):
        self.folder = folder
        self.hosts = yaml.safe_load(
            (CONFIG / "hosts" / f"three_hosts_{discovery}.yaml").read_text(encoding="utf-8")
        )
        scenario = yaml.safe_load(SCENARIO.read_text(encoding="utf-8"))
        scenario |= {"duration": duration, "events": events, "mode": mode}
        self.scenario = folder / "short.yaml"
        self.scenario.write_text(yaml.safe_dump(scenario), encoding="utf-8")
        places = self.hosts["hosts"]
        self.lan = Lan({name: places[name]["address"] for name in HOSTS})
        self.processes = {}
        try:
            for name in HOSTS:
                self.start(name, ",".join(places[name]["nodes"]), (variables or {}).get(name, {}))
        except BaseException:
            self.close()
            raise

    def start(self, name, only, variables):
        environment = {k: v for k, v in os.environ.items() if k not in VARIABLES}
        arguments = [
            *("--only", only, "--host-config", self.hosts["name"]),
            *("--out", str(self.folder / name), str(self.scenario)),
        ]
        command = [sys.executable, "-m", "lexstack_bringup.commands.bringup", *arguments]
        self.processes[name] = self.lan.start(
            name, command, self.folder / f"{name}.txt", environment | variables
        )

    def told(self, name):
        return (self.folder / f"{name}.txt").read_text(encoding="utf-8")

    def log(self, name, node):
        return (self.folder / name / "logs" / f"{node}.log").read_text(encoding="utf-8")

    def connected(self):
        for name in HOSTS:
            log, process = self.folder / f"{name}.txt", self.processes[name]
            until_printed(log, "all nodes are connected", process, PATIENCE)

    def played(self):
        """Wait for the end of the scenario, end the other hosts, and return the bag."""
        assert self.processes["simulation"].wait(PATIENCE) == 0, self.told("simulation")
        for name in HOSTS[1:]:
            assert self.processes[name].poll() is None, self.told(name)
            self.processes[name].send_signal(signal.SIGINT)
        for name in HOSTS[1:]:
            assert self.processes[name].wait(20) == 0, self.told(name)
        return self.folder / "simulation" / "bag"

    def close(self):
        for process in self.processes.values():
            if process.poll() is None:
                process.terminate()
        for process in self.processes.values():
            try:
                process.wait(20)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        self.lan.close()


@pytest.fixture
def deploy(tmp_path):
    made = []

    def make(*arguments, **options):
        for deployment in made:  # of an attempt before
            deployment.close()
        folder = tmp_path / f"run_{len(made)}"
        folder.mkdir()
        made.append(Deployment(folder, *arguments, **options))
        return made[-1]

    yield make
    for deployment in made[-1:]:
        deployment.close()


def switch(stack, at, duration):
    return {"switch": stack, "at": at, "duration": duration}


@pytest.mark.parametrize("discovery", ["multicast", "peers", "server"])
def test_three_hosts_run_the_scenario(deploy, discovery):
    run = deploy(discovery, "lockstep", 3.0, [switch("reach_base", 0.5, 1.5)])
    run.connected()
    bag = run.played()
    commands = read(bag, "/robot_a/chi")["/robot_a/chi"]
    assert [m.tick for m in commands] == list(range(300)), "none lost, none twice"
    assert sum(m.empty_bounds for m in commands) == 0
    assert acceleration_ratio(bag, LIMIT, 0.01) <= 1.0001
    statuses = read(bag, "/robot_a/transition")["/robot_a/transition"]
    assert statuses[-1].to_stack == "reach_base"
    assert {m.source for m in statuses if m.phase == 3} == {"robot_b"}, (
        "the solver's host took part"
    )
    assert not any(m.reason for m in statuses)
    assert ", 0 lost" in run.log("simulation", "recorder")


@pytest.fixture(scope="module")
def clock(tmp_path_factory):
    """Return a library that moves a process's wall clock."""
    path = tmp_path_factory.mktemp("clock") / "clock_offset.so"
    source = ROOT / "tests" / "support" / "clock_offset.c"
    compiler = os.environ.get("CC", "cc")
    subprocess.run([compiler, "-shared", "-fPIC", "-O2", "-o", path, source], check=True)
    return path


def test_clocks_that_differ_by_50_ms_change_nothing_and_are_told(deploy, clock):
    moved = {
        name: {"LD_PRELOAD": str(clock), "CLOCK_OFFSET_MS": offset}
        for name, offset in (("robot_a", "50"), ("robot_b", "-50"))
    }
    run = deploy("peers", "lockstep", 6.0, [switch("reach_base", 1.0, 1.5)], variables=moved)
    run.connected()
    bag = run.played()
    statuses = read(bag, "/robot_a/transition")["/robot_a/transition"]
    assert statuses[-1].to_stack == "reach_base"
    assert statuses[-1].phase == 0
    assert "robot_b" in {m.source for m in statuses if m.phase == 3}
    assert acceleration_ratio(bag, LIMIT, 0.01) <= 1.0001
    told = {"hqp_controller": [], "stack_solver": []}
    for message in read(bag, "/diagnostics")["/diagnostics"]:
        for status in message.status:
            if status.name in told:
                told[status.name] += re.findall(r"clock is (\d+) ms (\w+)", status.message)
    ahead, behind = told["hqp_controller"], told["stack_solver"]
    assert {word for _, word in ahead} == {"ahead"}
    assert {word for _, word in behind} == {"behind"}
    assert min(int(ms) for ms, _ in ahead) == pytest.approx(50, abs=5)
    assert max(int(ms) for ms, _ in behind) == pytest.approx(50, abs=5)


@pytest.mark.realtime
@pytest.mark.parametrize("host", ["robot_b", "robot_a"])
def test_a_host_that_is_cut_off_for_5_s_does_no_harm_and_comes_back(deploy, host):
    events = [switch("reach_base", 1.0, 5.0), switch("posture", 10.0, 1.0)]
    run = deploy("peers", "realtime", 13.0, events)
    run.connected()
    time.sleep(2.5)
    run.lan.cut(host)
    time.sleep(5.0)
    run.lan.heal(host)
    bag = run.played()
    read_ = read(bag, "/robot_a/transition", "/plant/state", "/robot_a/chi")
    statuses, states = read_["/robot_a/transition"], read_["/plant/state"]
    moving = [s for s in states if s.status != PlantState.PAUSED]
    assert [s.tick for s in moving] == list(range(1300))
    steps = np.abs(np.diff([s.command for s in moving], axis=0)) / (0.01 * LIMIT)
    assert steps.max() <= 1.0001
    assert sum(m.empty_bounds for m in read_["/robot_a/chi"]) == 0
    lost = [s for s in moving if s.status == PlantState.BRAKING]
    if host == "robot_b":
        reasons = {m.reason for m in statuses if "the solver" in m.reason}
        assert any("lost" in reason for reason in reasons), reasons
        assert len(lost) < 20, "the controller goes on alone"
    else:
        assert 300 < len(lost) < 700, "the plant brakes as long as the controller is away"
    assert statuses[-1].to_stack == "posture"
    assert statuses[-1].phase == 0
    last = max(m.id for m in statuses)
    assert "robot_b" in {m.source for m in statuses if m.id == last and m.phase == 3}, "healed"
    assert Path(run.folder / "simulation" / "scenario.yaml").exists()
