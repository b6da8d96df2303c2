"""Tests in real time: they are tried again for their neighbours, and never excused without."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from support.quiet import (
    ATTEMPTS,
    MARK,
    Machine,
    NoisyMachineWarning,
    cores_of_others,
    in_real_time,
    own_time,
)

BURN = "import time\nend = time.process_time() + 0.5\nwhile time.process_time() < end: pass\n"
QUIET, BUSY = 0.0, 1.2  # cores


class Eyes:
    """Sees what it is told to see, and counts the time of each look."""

    def __init__(self, *seen, during=QUIET):
        self.seen = list(seen)
        self.during = during
        self.time = 0.0

    def look(self, since=None):
        if since is not None:
            return self.during
        self.time += 0.4
        return self.seen.pop(0) if len(self.seen) > 1 else self.seen[0]

    def machine(self, patience=60.0):
        return Machine(look=self.look, patience=patience, limit=0.3, clock=lambda: self.time)


class Attempts:
    """Fails so many times, then succeeds."""

    def __init__(self, failures):
        self.failures = failures
        self.count = 0

    def __call__(self, _number):
        self.count += 1
        if self.count <= self.failures:
            raise AssertionError("no ticks")
        return "done"


def test_a_failure_on_a_quiet_machine_counts_at_once():
    attempt = Attempts(1)
    with pytest.raises(AssertionError, match="no ticks"):
        Eyes(QUIET).machine().undisturbed(attempt, "it")
    assert attempt.count == 1


@pytest.mark.parametrize("seen", [(QUIET, BUSY, QUIET), (BUSY, QUIET, BUSY, QUIET)])
def test_a_failure_beside_others_is_told_and_tried_again_when_the_machine_is_quiet(seen):
    attempt = Attempts(1)
    with pytest.warns(NoisyMachineWarning, match="it: attempt 1: others took .* AssertionError"):
        assert Eyes(*seen).machine().undisturbed(attempt, "it") == "done"
    assert attempt.count == 2


def test_a_neighbour_that_came_and_went_meanwhile_is_a_reason_to_try_again_and_no_excuse():
    attempt, eyes = Attempts(1), Eyes(QUIET, during=BUSY)
    with pytest.warns(NoisyMachineWarning, match=r"others took 0\.0 cores before it, 1\.2 mean"):
        assert eyes.machine().undisturbed(attempt, "it") == "done"
    attempt = Attempts(9)
    with pytest.warns(NoisyMachineWarning), pytest.raises(AssertionError, match="no ticks"):
        eyes.machine().undisturbed(attempt, "it")
    assert attempt.count == ATTEMPTS


def test_a_failure_that_comes_again_on_the_quiet_machine_counts():
    attempt = Attempts(5)
    with pytest.warns(NoisyMachineWarning), pytest.raises(AssertionError, match="no ticks"):
        Eyes(QUIET, BUSY, QUIET).machine().undisturbed(attempt, "it")
    assert attempt.count == 2


def test_on_a_machine_that_is_never_quiet_it_neither_fails_nor_passes():
    attempt, eyes = Attempts(9), Eyes(BUSY)
    machine = eyes.machine(patience=60.0)
    with (
        pytest.warns(NoisyMachineWarning),
        pytest.raises(pytest.skip.Exception, match=r"never quiet.*attempt 3: others took 1\.2"),
    ):
        machine.undisturbed(attempt, "it")
    assert attempt.count == ATTEMPTS
    assert 60.0 <= eyes.time < 65.0, "it waits once, not for every attempt"
    assert machine.patience == 0.0


def test_what_passes_beside_others_has_passed():
    attempt = Attempts(0)
    assert Eyes(BUSY).machine(patience=1.0).undisturbed(attempt, "it") == "done"
    assert attempt.count == 1


def test_a_test_that_skips_itself_is_not_tried_again():
    def attempt(_number):
        pytest.skip("no ip")

    with pytest.raises(pytest.skip.Exception, match="no ip"):
        Eyes(BUSY).machine(patience=0.0).undisturbed(attempt, "it")


def test_every_attempt_has_a_folder_of_its_own(tmp_path):
    folders = []

    def test(tmp_path, name):
        folders.append(tmp_path)
        assert name == "a name"
        assert not list(tmp_path.iterdir())
        (tmp_path / "bag").touch()
        assert len(folders) > 1

    again = in_real_time(test, Eyes(QUIET, BUSY, QUIET).machine())
    (tmp_path / "run").mkdir()
    with pytest.warns(NoisyMachineWarning):
        again(tmp_path=tmp_path / "run", name="a name")
    assert len(set(folders)) == 2


def burned(**variables):
    """Return what a busy child did to our time, before and after it was waited for [s]."""
    before = own_time()
    environment = {k: v for k, v in os.environ.items() if k != MARK} | variables
    process = subprocess.Popen(
        [sys.executable, "-c", f"{BURN}print(flush=True)\ninput()"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env=environment,
    )
    process.stdout.readline()
    running = own_time() - before
    process.communicate(b"\n")
    return running, own_time() - before


def test_what_these_tests_start_is_not_taken_for_a_neighbour():
    running, ended = burned(**{MARK: str(os.getpid())})
    assert running >= 0.5
    assert ended >= 0.5


def test_what_these_tests_did_not_start_is_a_neighbour():
    """Here a child without the mark, which counts as ours only once it was waited for."""
    running, ended = burned()
    assert running < 0.4
    assert ended >= 0.5


def test_busy_neighbours_are_seen():
    stranger = {k: v for k, v in os.environ.items() if k != MARK}
    command = [sys.executable, "-c", "while True: pass"]
    neighbours = [subprocess.Popen(command, env=stranger) for _ in range(os.cpu_count() or 1)]
    try:
        time.sleep(0.3)
        assert cores_of_others() > 0.15 * (os.cpu_count() or 1)
    finally:
        for neighbour in neighbours:
            neighbour.kill()
            neighbour.wait()


def test_a_process_that_ends_while_it_is_looked_at_does_no_harm(tmp_path):
    (tmp_path / "123").mkdir()
    assert own_time(tmp_path) <= own_time(Path("/proc")) + 1.0
