"""Another clone for ``bench system --against``: its own Python, environment and files."""

from __future__ import annotations

import sys

import pytest

from lexstack.errors import ConfigurationError
from lexstack_experiments.benches import BENCHES
from lexstack_experiments.benches.clones import Clone
from lexstack_experiments.commands.command import BAD_ARGUMENT, run_command


@pytest.fixture
def folder(tmp_path):
    """Return a folder that looks like a clone of before the packages got their names of today."""
    load = tmp_path / "ros2_ws/src/lexstack_ros/lexstack_ros/system_load.py"
    environment = tmp_path / ".venv/environment.sh"
    package = tmp_path / "lib/lexstack_core/config/resolved.py"
    for path in (load, environment, package):
        path.parent.mkdir(parents=True)
        path.touch()
    environment.write_text(
        f'export PYTHONPATH="{tmp_path}/lib${{PYTHONPATH:+:$PYTHONPATH}}"\n'
        f'export PATH="{tmp_path}/bin:$PATH"\n'
    )
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin/python").symlink_to(sys.executable)
    package.write_text(
        "class load_scenario:\n"
        "    def __init__(self, path, config):\n"
        "        self.text = path.read_text() + config.name\n"
        "    def to_yaml(self):\n"
        "        return self.text\n"
    )
    return tmp_path


def test_it_works_with_its_own_modules_alone(folder, monkeypatch):
    monkeypatch.setenv("PYTHONPATH", "/of/this/clone")
    clone = Clone(folder)
    assert clone.load == "lexstack_ros.system_load"
    program = "import os, sys; print(os.environ['PYTHONPATH']); sys.exit(3)"
    done = clone.python("-c", program, timeout=20.0)
    assert (done.returncode, done.stdout) == (3, f"{folder}/lib\n")
    scenario = folder / "scenario.yaml"
    scenario.write_text("name: asked\n")
    assert clone.resolved(scenario) == "name: asked\nconfig"
    with pytest.raises(ConfigurationError, match="No such file"):
        clone.resolved(folder / "none.yaml")


def test_a_folder_that_is_no_clone_is_refused(folder, tmp_path_factory):
    with pytest.raises(ConfigurationError, match="no clone that was set up"):
        Clone(tmp_path_factory.mktemp("empty"))
    (folder / "ros2_ws/src/lexstack_ros/lexstack_ros/system_load.py").unlink()
    with pytest.raises(ConfigurationError, match="has no bench of the whole system"):
        Clone(folder)


def test_a_bench_that_is_not_compared_says_so(tmp_path, capsys):
    words = ["recorder", "--against", str(tmp_path), "--out", str(tmp_path / "out")]
    assert run_command("bench", BENCHES, words) == BAD_ARGUMENT
    assert "recorder is not compared" in capsys.readouterr().err
