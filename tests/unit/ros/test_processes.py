"""Supervisor and domain: children are watched, ended, and two runs do not meet."""

import os
import signal
import subprocess
import sys
import time
from types import SimpleNamespace

import pytest

from lexstack_bringup import domain
from lexstack_bringup.domain import NoDomainError, own_domain
from lexstack_bringup.supervisor import ChildDiedError, NotReadyError, Supervisor
from support.leftovers import is_alive

# A shell that starts the tests in the background lets them ignore SIGINT, and so their children.
READY = (
    "import signal, time; signal.signal(signal.SIGINT, signal.SIG_DFL);"
    "print('ready', flush=True); time.sleep(60)"
)
STUBBORN = (
    "import signal, time; [signal.signal(s, signal.SIG_IGN) for s in (2, 15)];"
    "print('ready', flush=True); time.sleep(60)"
)


@pytest.fixture
def supervisor(tmp_path, monkeypatch):
    """Return a supervisor whose modules are snippets written to files."""
    monkeypatch.setenv("PYTHONPATH", f"{tmp_path}{os.pathsep}{os.environ.get('PYTHONPATH', '')}")
    result = Supervisor(tmp_path / "logs")

    def start(name, code):
        (tmp_path / f"child_{name}.py").write_text(code, encoding="utf-8")
        return result.start(name, f"child_{name}")

    result.start_code = start
    yield result
    result.end(timeout=0.2)


def gone(pid):
    """Return whether a process has ended, waiting for it a little."""
    end = time.monotonic() + 5.0
    while is_alive(pid):
        if time.monotonic() > end:
            return False
        time.sleep(0.05)
    return True


def test_a_process_that_nobody_has_waited_for_is_gone():
    """As all orphans in a container whose first process reaps nobody."""
    process = subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE)
    assert is_alive(process.pid)
    process.send_signal(signal.SIGKILL)
    assert gone(process.pid)
    os.kill(process.pid, 0)  # a zombie takes signals: that does not tell
    process.wait()
    process.stdin.close()
    assert not is_alive(process.pid)


def test_children_become_ready_and_end(supervisor):
    child = supervisor.start_code("good", READY)
    supervisor.wait_printed(["good"], "ready", 20.0)
    supervisor.check()
    assert supervisor.end() == []
    assert child.process.returncode == -signal.SIGINT


def test_a_child_that_ends_is_named_with_its_last_lines(supervisor):
    supervisor.start_code("bad", "print('before the end'); raise SystemExit(3)")
    with pytest.raises(ChildDiedError) as error:
        supervisor.wait_printed(["bad"], "ready", 20.0)
    assert "bad ended with exit code 3" in str(error.value)
    assert "bad| before the end" in str(error.value)


def test_a_child_that_is_killed_is_named_with_the_signal(supervisor):
    child = supervisor.start_code("victim", READY)
    supervisor.wait_printed(["victim"], "ready", 20.0)
    child.process.kill()
    child.process.wait()
    with pytest.raises(ChildDiedError, match="victim was killed by SIGKILL"):
        supervisor.check()
    supervisor.check(expected=["victim"])


def test_a_child_that_is_not_ready_in_time_is_named(supervisor):
    supervisor.start_code("slow", "import time; time.sleep(60)")
    with pytest.raises(NotReadyError, match=r"slow: not ready after 0\.5 s"):
        supervisor.wait_printed(["slow"], "ready", 0.5)


def test_a_stubborn_and_a_stopped_child_are_ended_all_the_same(supervisor):
    stubborn = supervisor.start_code("stubborn", STUBBORN)
    stopped = supervisor.start_code("stopped", READY)
    supervisor.wait_printed(["stubborn", "stopped"], "ready", 20.0)
    stopped.process.send_signal(signal.SIGSTOP)
    assert supervisor.end(timeout=0.5) == ["stubborn"]
    assert gone(stubborn.process.pid)
    assert gone(stopped.process.pid)


def test_children_do_not_outlive_a_supervisor_that_is_killed(tmp_path):
    child = tmp_path / "child_orphan.py"
    child.write_text(
        "from lexstack_ros.node.parent import end_with_supervisor\nend_with_supervisor()\n" + READY,
        encoding="utf-8",
    )
    parent = (
        "import time\nfrom pathlib import Path\n"
        "from lexstack_bringup.supervisor import Supervisor\n"
        f"s = Supervisor(Path({str(tmp_path / 'logs')!r}))\n"
        "c = s.start('orphan', 'child_orphan')\ns.wait_printed(['orphan'], 'ready', 20.0)\n"
        "print(c.process.pid, flush=True)\ntime.sleep(60)\n"
    )
    environment = {
        **os.environ,
        "PYTHONPATH": f"{tmp_path}{os.pathsep}{os.environ.get('PYTHONPATH', '')}",
    }
    process = subprocess.Popen(
        [sys.executable, "-c", parent], stdout=subprocess.PIPE, text=True, env=environment
    )
    pid = int(process.stdout.readline())
    process.kill()
    process.wait()
    assert gone(pid)


def test_two_runs_have_two_domains(monkeypatch):
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)
    with own_domain() as one, own_domain() as other:
        assert one != other
    with own_domain() as again:
        assert again == one


def refusing(refused, *, creating):
    """Return an ``os.open`` that refuses a file, always or where it may create it."""

    def opened(path, flags, *rest):
        if path.name == refused and (not creating or flags & os.O_CREAT):
            raise PermissionError(13, "Permission denied", str(path))
        return os.open(path, flags, *rest)

    return opened


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Return the folder of lock files, with that of the first domain in it."""
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)
    monkeypatch.setattr(domain.tempfile, "gettempdir", lambda: str(tmp_path))
    (tmp_path / "lexstack-domain-1.lock").touch()
    return tmp_path


def test_a_lock_file_of_another_account_that_may_be_read_locks_that_domain(folder, monkeypatch):
    """O_CREAT on it is refused in a folder that all share, and writing anyway."""
    refuse = refusing("lexstack-domain-1.lock", creating=True)
    monkeypatch.setattr(domain, "os", SimpleNamespace(**{**vars(os), "open": refuse}))
    with own_domain() as one, own_domain() as other:
        assert (one, other) == (1, 2)


def test_a_lock_file_of_another_account_that_may_not_be_read_is_passed_over(folder, monkeypatch):
    refuse = refusing("lexstack-domain-1.lock", creating=False)
    monkeypatch.setattr(domain, "os", SimpleNamespace(**{**vars(os), "open": refuse}))
    with own_domain() as number:
        assert number == 2


def test_a_folder_in_which_nothing_can_be_locked_is_named_in_one_line(folder, monkeypatch):
    def refuse(path, *_):
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr(domain, "os", SimpleNamespace(**{**vars(os), "open": refuse}))
    with pytest.raises(NoDomainError, match=r"is free .*lock: Permission denied") as error:
        own_domain().__enter__()
    assert "\n" not in str(error.value)


def test_a_pipe_with_the_name_of_a_lock_holds_nobody_up(folder):
    (folder / "lexstack-domain-1.lock").unlink()
    os.mkfifo(folder / "lexstack-domain-1.lock")
    with own_domain() as number:
        assert number in (1, 2)


def test_a_given_domain_is_taken(monkeypatch):
    monkeypatch.setenv("ROS_DOMAIN_ID", "42")
    with own_domain() as number:
        assert number == 42


@pytest.mark.parametrize("value", ["", "x", "-1", "233"])
def test_a_wrong_domain_is_refused(monkeypatch, value):
    monkeypatch.setenv("ROS_DOMAIN_ID", value)
    with pytest.raises(NoDomainError, match="ROS_DOMAIN_ID"), own_domain():
        pass
