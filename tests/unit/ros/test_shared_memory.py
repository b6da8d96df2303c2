"""What killed processes leave in shared memory is found and removed, and nothing else is."""

import fcntl
import os
import signal
import subprocess
import sys

import pytest

from lexstack_bringup import shared_memory
from lexstack_bringup.shared_memory import FOLDER, abandoned, remove_abandoned
from support.leftovers import our_processes, what_is_left

SEGMENT, PORT = "fastrtps_0123456789abcdef", "fastrtps_port7413"
# A node of its own, for itself alone, that tells when it has its segment and port.
NODE = (
    "import rclpy, time; rclpy.init(); node = rclpy.create_node('left_behind');"
    "print('up', flush=True); time.sleep(60)"
)


@pytest.fixture
def folder(tmp_path):
    """Return a folder like /dev/shm, with files of others."""
    for name in ("lttng-ust-wait-6", "sem.other", "fastrtps_short", "fastrtps_portal"):
        (tmp_path / name).touch()
    return tmp_path


def make(folder, name, *more):
    for each in (name, *(name + suffix for suffix in more)):
        (folder / each).touch()


def hold(path, how=fcntl.LOCK_EX):
    handle = os.open(path, os.O_RDONLY)
    fcntl.flock(handle, how)
    return handle


def test_what_nobody_holds_goes_with_all_that_belongs_to_it(folder):
    before = sorted(folder.iterdir())
    make(folder, SEGMENT, "_el")
    make(folder, PORT, "_el", "_sl")
    make(folder, f"sem.{PORT}_mutex")
    make(folder, "fastrtps_port99")  # its lock went before it
    make(folder, "sem.fastrtps_port100_mutex")  # only its mutex is left
    make(folder, "fastrtps_00000000000000ff_el")  # its segment went before its lock
    os.utime(folder / "fastrtps_00000000000000ff_el", (1.0, 1.0))
    segments = [folder / "fastrtps_00000000000000ff", folder / SEGMENT]
    ports = [folder / name for name in ("fastrtps_port100", PORT, "fastrtps_port99")]
    assert abandoned(folder) == segments + ports
    assert remove_abandoned(folder) == segments + ports
    assert sorted(folder.iterdir()) == before
    assert abandoned(folder) == []


@pytest.mark.parametrize("how", [fcntl.LOCK_EX, fcntl.LOCK_SH])
def test_while_a_segment_is_held_it_stays_and_all_ports_do(folder, how):
    dead = "fastrtps_ffffffffffffffff"
    make(folder, SEGMENT, "_el")
    make(folder, dead, "_el")
    make(folder, PORT)
    handle = hold(folder / f"{SEGMENT}_el", how)
    assert abandoned(folder) == [folder / dead]
    assert remove_abandoned(folder) == [folder / dead]
    assert (folder / SEGMENT).exists()
    assert (folder / PORT).exists()
    os.close(handle)
    assert remove_abandoned(folder) == [folder / SEGMENT, folder / PORT]


def test_what_is_about_to_be_locked_stays(folder):
    """A segment is made after its lock."""
    make(folder, f"{SEGMENT}_el")
    make(folder, PORT)
    assert remove_abandoned(folder) == []
    os.utime(folder / f"{SEGMENT}_el", (1.0, 1.0))
    assert remove_abandoned(folder) == [folder / SEGMENT, folder / PORT]


def test_a_process_that_begins_meanwhile_keeps_its_ports(folder, monkeypatch):
    """Each port is looked at by itself: the first goes, then somebody comes."""
    for port in (7400, 7401, 7402):
        make(folder, f"fastrtps_port{port}")
    seen = []
    monkeypatch.setattr(shared_memory, "_in_use", lambda _folder: seen.append(1) or len(seen) > 1)
    assert remove_abandoned(folder) == [folder / "fastrtps_port7400"]


def test_where_there_is_no_shared_memory_there_is_nothing_to_do(tmp_path):
    assert remove_abandoned(tmp_path / "none") == []


def test_of_a_living_process_nothing_goes_and_of_a_killed_one_all():
    def segments():
        return {path.name for path in FOLDER.glob("fastrtps_*") if path.name.count("_") == 1}

    before = segments()
    process = subprocess.Popen(
        [sys.executable, "-c", NODE],
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, "ROS_DOMAIN_ID": "215"},
    )
    try:
        assert process.stdout.readline() == "up\n"
        mine = {name for name in segments() - before if "port" not in name}
        assert mine
        remove_abandoned()
        assert mine <= segments()
    finally:
        process.send_signal(signal.SIGKILL)
        process.communicate()
    remove_abandoned()
    assert not mine & segments()


# ---- the check of the tests themselves


def test_a_process_of_ours_that_is_left_is_told(tmp_path, monkeypatch):
    monkeypatch.setattr("support.leftovers._PATIENCE", 0.3)
    make(tmp_path, SEGMENT, "_el")
    before = our_processes()
    command = [sys.executable, "-c", "import time; time.sleep(60)", "lexstack_ros.solver.pretended"]
    process = subprocess.Popen(command)
    try:
        (process_line, memory_line) = what_is_left(before, tmp_path)
        assert process_line.startswith(f"process {process.pid}: ")
        assert process_line.endswith("lexstack_ros.solver.pretended ")
        assert memory_line == f"shared memory: {tmp_path / SEGMENT}"
    finally:
        process.kill()
        process.wait()
    remove_abandoned(tmp_path)
    assert what_is_left(before, tmp_path) == []
