"""A host that is cut off from the others for five seconds: three hosts in network namespaces."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import yaml

from lexstack.errors import LexstackError
from lexstack_bringup.hosts import VARIABLES
from lexstack_experiments.experiment import Options
from lexstack_testing.virtual_lan import Lan, why_not

CUTS = {"cut robot_b blending": "robot_b", "cut robot_a blending": "robot_a"}
CUT = 5.0  # s
_HOSTS = "three_hosts_peers"
_DURATION = 14.0  # s
_EVENTS = [
    {"switch": "reach_base", "at": 1.0, "duration": 6.0},
    {"switch": "posture", "at": 11.0, "duration": 1.0},
]
_CONNECTED = "all nodes are connected"
_PATIENCE = 90.0  # s of wall time


def why_no_cut() -> str:
    """Return why no network can be cut here, or ''."""
    return why_not()


def cut_events(options: Options, name: str) -> dict[str, Any]:
    """Run on three hosts, cut one of them off, and return when that was."""
    out = options.out / name.replace(" ", "_")
    out.mkdir()
    hosts = yaml.safe_load((options.config / "hosts" / f"{_HOSTS}.yaml").read_text("utf-8"))
    source = options.config / "scenarios" / "faults.yaml"
    scenario = yaml.safe_load(source.read_text("utf-8"))
    scenario |= {"duration": _DURATION, "events": _EVENTS}
    scenario.pop("sequences")
    path = out / "short.yaml"
    path.write_text(yaml.safe_dump(scenario), encoding="utf-8")
    lan = Lan({host: entry["address"] for host, entry in hosts["hosts"].items()})
    processes: dict[str, subprocess.Popen[bytes]] = {}
    try:
        for host, entry in hosts["hosts"].items():
            processes[host] = _start(lan, host, entry["nodes"], path, out)
        _wait_connected(processes, out)
        event = _cut(lan, CUTS[name], processes["simulation"])
    finally:
        for process in processes.values():
            if process.poll() is None:
                process.send_signal(signal.SIGINT)
        for process in processes.values():
            process.wait(_PATIENCE)
        lan.close()
    bag = str(out / "simulation" / "bag")
    return {"case": name, "bag": bag, "later": bag, "answers": 0, "rejoined": False, **event}


def _start(
    lan: Lan, host: str, nodes: list[str], scenario: Path, out: Path
) -> subprocess.Popen[bytes]:
    """Start one host's share."""
    environment = {k: v for k, v in os.environ.items() if k not in VARIABLES}
    words = ["--only", ",".join(nodes), "--host-config", _HOSTS, "--out", str(out / host)]
    command = [sys.executable, "-m", "lexstack_bringup.commands.bringup", *words, str(scenario)]
    return lan.start(host, command, out / f"{host}.txt", environment)


def _wait_connected(processes: dict[str, subprocess.Popen[bytes]], out: Path) -> None:
    """Wait for all hosts."""
    end = time.monotonic() + _PATIENCE
    while not all(_CONNECTED in (out / f"{h}.txt").read_text("utf-8") for h in processes):
        if time.monotonic() > end or any(p.poll() is not None for p in processes.values()):
            raise LexstackError(f"the hosts did not connect; see {out}")
        time.sleep(0.05)


def _cut(lan: Lan, host: str, simulation: subprocess.Popen[bytes]) -> dict[str, int]:
    """Cut a host off while the controller blends, and wait for the scenario's end."""
    time.sleep(2.5)
    begun = time.time_ns()
    lan.cut(host)
    time.sleep(CUT)
    lan.heal(host)
    healed = time.time_ns()
    if simulation.wait(_PATIENCE):
        raise LexstackError("the scenario did not end")
    return {"begun": begun, "healed": healed, "ended": time.time_ns()}
