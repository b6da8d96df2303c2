"""The demo as a command: two at a time, and Ctrl-C again and again."""

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import yaml

from lexstack_bringup.processes import NODES
from support.logs import until_printed
from support.runs import read
from support.scenario import ROOT, SCENARIO

pytestmark = pytest.mark.system


def demo(out, *arguments, domain=None):
    environment = {k: v for k, v in os.environ.items() if k != "ROS_DOMAIN_ID"}
    if domain is not None:
        environment["ROS_DOMAIN_ID"] = str(domain)
    return subprocess.Popen(
        [
            *(sys.executable, "-m", "lexstack_bringup.commands.demo"),
            *map(str, arguments),
            *("--out", str(out)),
        ],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=ROOT,
        env=environment,
    )


def shortened(folder, duration):
    """Return the default scenario's file without events, of another duration."""
    data = yaml.safe_load(SCENARIO.read_text(encoding="utf-8"))
    path = folder / "short.yaml"
    path.write_text(yaml.safe_dump(data | {"duration": duration, "events": []}), encoding="utf-8")
    return path


def nodes_of(folder):
    """Return the process ids of the nodes of a run, by the run's folder in their command lines."""
    found = []
    for path in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            words = path.read_bytes().split(b"\0")
        except OSError:
            continue
        named = any(str(folder).encode() in word for word in words)
        if named and any(module.encode() in words for module in NODES.values()):
            found.append(int(path.parent.name))
    return found


def test_two_demos_at_the_same_time_do_not_meet(tmp_path):
    scenario = shortened(tmp_path, 2.0)
    both = [demo(tmp_path / name, scenario) for name in ("one", "other")]
    outputs = [process.communicate(timeout=110) for process in both]
    assert [process.returncode for process in both] == [0, 0], outputs
    domains = {re.search(r"ROS_DOMAIN_ID=(\d+)", out).group(1) for out, _ in outputs}
    assert len(domains) == 2
    senders = []
    for name in ("one", "other"):
        bag = read(tmp_path / name / "bag", "/plant/state", "/robot_a/chi")
        assert [m.tick for m in bag["/robot_a/chi"]] == list(range(200))
        senders.append({m.sender for m in bag["/plant/state"] + bag["/robot_a/chi"]})
    assert all(len(names_) == 2 for names_ in senders), "one plant and one controller each"
    assert not senders[0] & senders[1]


def test_ctrl_c_again_and_again_still_ends_in_order(tmp_path):
    process = demo(tmp_path / "run", shortened(tmp_path, 60.0), "--mode", "realtime")
    end = time.monotonic() + 60.0
    until_printed(tmp_path / "run" / "logs" / "hqp_controller.log", "ready", process)
    assert len(nodes_of(tmp_path / "run")) == len(NODES)
    while process.poll() is None:
        process.send_signal(signal.SIGINT)
        assert time.monotonic() < end
        time.sleep(0.02)
    _, errors = process.communicate(timeout=30)
    assert process.returncode == 130, errors
    assert "Traceback" not in errors
    assert not nodes_of(tmp_path / "run")
    for path in (tmp_path / "run" / "logs").glob("*.log"):
        assert "Traceback" not in path.read_text(encoding="utf-8"), path.name
