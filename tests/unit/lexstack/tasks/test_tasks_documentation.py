"""docs/tasks.md: its tables name what there is, and its example is a task that works."""

import dataclasses
import re
import sys
import typing
from types import ModuleType

import numpy as np
import pytest
import yaml

from lexstack.errors import ConfigurationError
from lexstack.references import References
from lexstack.robots import ObstacleConfig, Obstacles
from lexstack.tasks import TASKS, StackConfig, build_stack
from lexstack_config.reader import build, parse_yaml
from support.scenario import ROOT, random_q, state_at, team

PAGE = (ROOT / "docs" / "tasks.md").read_text(encoding="utf-8")
STEP = 1e-6


def blocks(language):
    """Return the page's code blocks in a language."""
    return re.findall(rf"^```{language}\n(.*?)^```$", PAGE, flags=re.MULTILINE | re.DOTALL)


def table(heading):
    """Return the rows of the first table below a heading, cells without back quotes."""
    below = PAGE.split(f"\n{heading}\n", 1)[1]
    lines = re.search(r"((?:^\|.*\n)+)", below, flags=re.MULTILINE).group(1).splitlines()[2:]
    return [[cell.strip().strip("`") for cell in line.strip("|").split("|")] for line in lines]


def parameters_of(kind):
    """Return the dataclass of a task's parameters."""
    module = sys.modules[TASKS[kind].__self__.__module__]
    (found,) = (
        value
        for name, value in vars(module).items()
        if name.endswith("Parameters") and value.__module__ == module.__name__
    )
    return found


@pytest.fixture
def height(monkeypatch, registries):
    """Return the page's example, which registers itself, for one test."""
    module = ModuleType("example")
    monkeypatch.setitem(sys.modules, "example", module)  # dataclasses look there for their types
    (code,) = (block for block in blocks("python") if "class Height" in block)
    exec(compile(code, "docs/tasks.md", "exec"), vars(module))
    return module.Height


def test_the_table_names_all_tasks():
    assert sorted(row[0] for row in table("## All tasks")) == sorted(TASKS)


@pytest.mark.parametrize("kind", sorted(TASKS))
def test_the_table_names_all_parameters_with_their_defaults(kind):
    told, current = {}, ""
    for name, parameter, default, *_ in table("### Parameters"):
        current = name or current
        if current == kind:
            told[parameter] = yaml.safe_load(default)
    fields = dataclasses.fields(parameters_of(kind))
    wanted = {}
    for field in fields:
        missing = field.default is dataclasses.MISSING
        default = "–" if missing else field.default
        wanted[field.name] = "none" if default is None else default
    wanted = {k: list(v) if isinstance(v, tuple) else v for k, v in wanted.items()}
    assert told == wanted


def test_the_stacks_on_the_page_are_stacks(height):
    texts = [text for text in blocks("yaml") if "levels:" in text]
    assert len(texts) == 2
    for text in texts:
        build_stack(build(StackConfig, parse_yaml(text, "page"), "page"), team())


def test_the_obstacles_on_the_page_are_obstacles():
    (text,) = (text for text in blocks("yaml") if text.startswith("obstacles:"))
    hints = typing.get_type_hints(ObstacleConfig)
    configs = {
        name: build(ObstacleConfig, values, name)
        for name, values in yaml.safe_load(text)["obstacles"].items()
    }
    assert {key for c in yaml.safe_load(text)["obstacles"].values() for key in c} == set(hints)
    assert Obstacles(configs).moving


@pytest.mark.parametrize("seed", range(5))
def test_the_example_drives_a_tool_to_its_height(height, seed):
    """Its matrix is the derivative of its error, as for every registered task."""
    rng = np.random.default_rng(seed)
    q, chi = random_q(rng), rng.normal(size=20)
    task = TASKS["height"](team(), 1, {"gain": 2.0}, "here")
    here = References(team().tools(random_q(rng)), (np.zeros(3), np.zeros(3)))
    ahead, now, behind = (
        task.linearise(team().kinematics(state_at(q + h * chi)), here) for h in (STEP, 0.0, -STEP)
    )
    assert isinstance(task, height)
    assert now.name == task.name == "robot_b/height"
    assert task.robots == (1,)
    assert not now.matrix[:, :10].any()
    change = (ahead.lower - behind.lower) / (2.0 * STEP)
    np.testing.assert_allclose(change, -2.0 * now.matrix @ chi, atol=1e-6)


def test_the_example_refuses_what_is_wrong(height):
    with pytest.raises(ConfigurationError, match="here: gain: must be finite and > 0"):
        TASKS["height"](team(), 0, {"gain": -1.0}, "here")
    with pytest.raises(ConfigurationError, match="here: unknown key 'wrong'"):
        TASKS["height"](team(), 0, {"wrong": 1.0}, "here")


def test_what_the_page_says_of_the_spheres_is_so():
    assert f"has {len(team().robots[0].spheres.radii)}." in PAGE
