"""A bag whose scenario lists modules of its user: read without them, or with them on demand."""

import dataclasses
import importlib
import json
import sys

import pytest

from lexstack.tasks import JointLimitConfig, LevelConfig, TaskConfig
from lexstack_bag.commands import analyze
from lexstack_bag.figures.limits import limits_of_stacks
from lexstack_bag.run.reader import read_run

pytestmark = pytest.mark.usefixtures("registries")


@pytest.fixture
def bag(write, resolved, tmp_path):
    """Return a run folder whose second stack has a task that an extension brings, and limits."""
    level = LevelConfig((TaskConfig("my_posture"),))
    slow = {"robot_a": {"panda_joint1": JointLimitConfig(velocity=0.5)}}
    mine = dataclasses.replace(resolved.stacks["reach_base"], levels=(level,), limits=slow)
    scenario = dataclasses.replace(resolved.scenario, extensions=("my_module",))
    changed = dataclasses.replace(
        resolved, scenario=scenario, stacks=resolved.stacks | {"reach_base": mine}
    )
    write(tmp_path / "run/bag", facts={"scenario": changed.to_yaml()})
    return tmp_path / "run"


@pytest.fixture
def module(tmp_path, monkeypatch):
    """Write what the bag's scenario lists where Python finds it."""
    monkeypatch.syspath_prepend(tmp_path)
    text = "import lexstack as l\n\ndef make(*all):\n    return l.TASKS['posture'](*all)\n\n"
    (tmp_path / "my_module.py").write_text(text + "l.register_task('my_posture', make)\n")
    importlib.invalidate_caches()
    yield
    sys.modules.pop("my_module", None)


def levels(bag):
    """Return how many levels the figures have of each phase."""
    metrics = json.loads((bag / "metrics.json").read_text(encoding="utf-8"))
    return [len(phase["levels"]) for phase in metrics["phases"]]


def test_a_bag_is_analysed_without_the_modules_that_it_names(bag, module, capsys):
    assert analyze.main([str(bag)]) == 0
    assert "left out: levels of reach_base, for want of my_posture" in capsys.readouterr().out
    assert levels(bag) == [2, 0]
    assert "my_module" not in sys.modules, "a bag may come from anybody"


def test_the_modules_are_imported_on_demand(bag, module, capsys):
    assert analyze.main([str(bag), "--extensions"]) == 0
    assert "left out" not in capsys.readouterr().out
    assert levels(bag) == [2, 1]


def test_a_module_that_is_not_there_is_one_line(bag, capsys):
    assert analyze.main([str(bag), "--extensions"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("analyze: scenario transition-sequence: extensions[0]: cannot import ")


def test_limits_of_a_stack_need_none_of_its_tasks(bag):
    run = read_run(bag)
    limits = limits_of_stacks(run, run.team())
    assert limits["reach_base"].velocity[3] == 0.5
