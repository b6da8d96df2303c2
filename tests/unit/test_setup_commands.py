"""The set-up's command: arguments, and the search for a Python."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"
FITTING = '#!/bin/sh\ncase "$*" in\n*--probe*) echo "$0" ;;\n*) echo "ran $0 $*" ;;\nesac\n'
BROKEN = "#!/bin/sh\nexit 127\n"


@pytest.fixture
def clone(tmp_path):
    """Return a clone that has never been set up, with an empty folder of programs."""
    shutil.copytree(SCRIPTS, tmp_path / "scripts")
    (tmp_path / "bin").mkdir()
    return tmp_path


def setup(clone, *arguments, **variables):
    """Run the clone's set-up."""
    environ = {"PATH": f"{clone}/bin:/usr/bin:/bin", **variables}
    command = [clone / "scripts/setup", *arguments]
    return subprocess.run(command, env=environ, capture_output=True, text=True, check=False)


def add_program(clone, name, text):
    """Put a program on the path."""
    program = clone / "bin" / name
    program.write_text(text)
    program.chmod(0o755)
    return str(program)


def test_help_needs_nothing(clone):
    done = setup(clone, "--help", PYTHON="/bin/false")
    assert done.returncode == 0
    assert "usage: ./scripts/setup" in done.stdout


def test_unknown_argument_is_named_and_exits_2(clone):
    done = setup(clone, "--nonsense")
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert "--nonsense" in done.stderr


def test_packages_alone_are_asked_for_with_their_flag(clone):
    """An image makes them in a layer of their own, before the sources are there."""
    fitting = add_program(clone, "python3", FITTING)
    done = setup(clone, "--packages")
    assert done.stdout.startswith(f"ran {fitting} ")
    assert done.stdout.endswith("--current --packages\n")


def test_a_python_that_exists_but_fails_is_passed_over(clone):
    add_program(clone, "python3", BROKEN)
    fitting = add_program(clone, "python3.12", FITTING)
    done = setup(clone, "--quiet")
    assert done.returncode == 0
    assert done.stdout.startswith(f"ran {fitting} ")
    assert done.stdout.endswith("--current --quiet\n")


def test_given_python_goes_before_all_others(clone):
    add_program(clone, "python3", FITTING)
    given = add_program(clone, "given", FITTING)
    assert setup(clone, PYTHON=given).stdout.startswith(f"ran {given} ")


def test_given_python_that_does_not_fit_is_an_error(clone):
    done = setup(clone, PYTHON="/bin/false")
    assert done.returncode == 1
    assert done.stderr.count("\n") == 1
    assert "/bin/false" in done.stderr


def test_another_sourced_ros_ends_before_anything_is_made(clone):
    (clone / "requirements.lock").touch()
    done = setup(clone, PYTHON=sys.executable, ROS_DISTRO="humble")
    assert done.returncode == 1
    assert done.stderr.startswith("lexstack: ROS 2 humble is sourced")
    assert done.stderr.count("\n") == 1
    assert not (clone / "build").exists()
