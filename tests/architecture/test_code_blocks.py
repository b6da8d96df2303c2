"""Every code block of every page is run, or held against what it speaks of.

Programs that need a running demo are run by tests/system/test_first_hour.py.
"""

import ast
import contextlib
import importlib
import io
import os
import re
import subprocess
import sys
import types
from functools import cache

import pytest
import yaml

from lexstack.robots import ObstacleConfig, RobotFile
from lexstack.tasks import StackConfig
from lexstack_bringup.hosts import SERVER, load_hosts
from lexstack_bringup.player import PLAYER
from lexstack_bringup.processes import NODES, PLANNERS
from lexstack_config.plant_file import PlantFile
from lexstack_config.reader import build, parse_yaml
from lexstack_config.scenario import ScenarioConfig
from lexstack_experiments.benches import BENCHES
from lexstack_experiments.experiments import EXPERIMENTS
from lexstack_experiments.sweeps.sweep_file import SweepFile
from support.code_blocks import HEREDOC, ROOT, Block, all_blocks, blocks_of, lines_of

BLOCKS = all_blocks()


def of(*languages):
    """Return a parameter for each block in these languages."""
    return [pytest.param(b, id=b.name) for b in BLOCKS if b.language in languages]


def test_every_block_is_of_a_kind_that_is_checked_here():
    assert len(BLOCKS) > 40
    known = {"sh", "python", "yaml", "mermaid", "math", ""}
    assert not [block.name for block in BLOCKS if block.language not in known]


# ---- python


def python_pages():
    """Return the pages with Python, each with its blocks and outputs in order."""
    pages = {}
    for block in BLOCKS:
        if block.language in ("python", ""):
            pages.setdefault(block.page, []).append(block)
    return {page: found for page, found in pages.items() if any(b.language for b in found)}


@pytest.mark.parametrize("page", python_pages())
def test_python_runs_as_printed_and_prints_what_the_page_shows(page, monkeypatch, registries):
    """The blocks of a page run one after the other; a plain block is what the last one printed."""
    monkeypatch.chdir(ROOT)
    module, printed = types.ModuleType(f"page {page}"), ""
    monkeypatch.setitem(sys.modules, module.__name__, module)  # dataclasses look there
    for block in python_pages()[page]:
        if block.language == "python":
            out = io.StringIO()
            with contextlib.redirect_stdout(out):
                exec(compile(block.text, block.name, "exec"), vars(module))
            printed = out.getvalue()
        elif printed:
            shown = [line.rstrip() for line in block.text.splitlines()]
            assert [line.rstrip() for line in printed.splitlines()] == shown, block.name
            printed = ""
    assert not printed, "the page does not show what its last block prints"


@pytest.mark.parametrize("block", of("sh"))
def test_programs_in_commands_compile_and_their_messages_have_the_fields(block):
    for _, program in HEREDOC.findall(block.text):
        tree = ast.parse(program)
        kinds = {}
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom):
                module = importlib.import_module(node.module)
                kinds |= {n.name: getattr(module, n.name) for n in node.names}
        for call in (node for node in ast.walk(tree) if isinstance(node, ast.Call)):
            kind = kinds.get(getattr(call.func, "id", ""))
            if hasattr(kind, "get_fields_and_field_types"):
                fields = kind.get_fields_and_field_types()
                assert {k.arg for k in call.keywords if k.arg} <= set(fields), block.name


# ---- sh


@cache
def help_of(script, *mode):
    """Return what a script says of itself; ``mode`` are options that give it others."""
    done = subprocess.run(
        [ROOT / script, *mode, "--help"], capture_output=True, text=True, check=False, timeout=120
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def check_script(words):
    """Check one call of a script: it is there, it has the options, it knows the names."""
    script, *arguments = words
    name = script.removeprefix("./scripts/")
    assert os.access(ROOT / script, os.X_OK), script
    if name in ("test", "shell", "run"):
        return  # what follows is another command's
    text = help_of(script, *(["--publish"] if "--publish" in arguments else []))
    for option in (word for word in arguments if word.startswith("--")):
        assert re.search(rf"(?<![\w-]){re.escape(option.split('=')[0])}\b", text), option
    known = {"experiment": EXPERIMENTS, "bench": BENCHES}.get(name)
    if known and not arguments[0].startswith("-"):
        assert arguments[0] in known, arguments
    if name == "demo" and arguments and not arguments[0].startswith("-"):
        assert (ROOT / f"config/scenarios/{arguments[0]}.yaml").is_file(), arguments
    if name == "bringup":
        nodes = arguments[arguments.index("--only") + 1].split(",")
        assert set(nodes) <= {*NODES, *PLANNERS, PLAYER, SERVER}
        hosts = arguments[arguments.index("--host-config") + 1]
        assert (ROOT / f"config/hosts/{hosts}.yaml").is_file()


def check_ros2(words):
    """Check one call of the native command: names of topics are known, the message is one."""
    verb = words[1:3]
    options = {("topic", "pub"): 2, ("service", "call"): 2, ("action", "send_goal"): 2}
    plain = [word for word in words[3:] if not word.startswith("--")]
    if tuple(verb) not in options:
        assert verb == ["topic", "echo"], words
        assert endpoint_is_known(plain[0])
        return
    assert endpoint_is_known(plain[0])
    package, section, name = plain[1].split("/")
    kind = getattr(importlib.import_module(f"{package}.{section}"), name)
    value = yaml.safe_load(plain[2]) if len(plain) > 2 else {}
    check_message({"srv": "Request", "action": "Goal"}.get(section), kind, value)


def check_message(part, kind, value):
    """Check that a message, or the named part of a service or action, has the given fields."""
    kind = getattr(kind, part) if part else kind
    fields = kind.get_fields_and_field_types()
    for key, entry in value.items():
        assert key in fields, f"{kind.__name__} has no {key}"
        nested = re.fullmatch(r"(?:sequence<)?(\w+)/(\w+)>?", fields[key])
        if nested:
            inner = getattr(importlib.import_module(f"{nested[1]}.msg"), nested[2])
            for each in entry if isinstance(entry, list) else [entry]:
                check_message(None, inner, each)
        else:
            kind(check_fields=True, **{key: entry})  # a wrong type raises AssertionError


def endpoint_is_known(name):
    """Return whether the page's table has a topic, service or action."""
    text = (ROOT / "docs/ros-by-hand.md").read_text(encoding="utf-8")
    return any(f"`{n}`" in text for n in (name, re.sub(r"/robot_[ab]/", "/NAME/", name)))


@pytest.mark.parametrize("block", of("sh"))
def test_every_command_and_option_in_a_block_exists(block):
    for words in lines_of(block):
        if words[0].startswith("./scripts/"):
            check_script(words)
        elif words[0] == "ros2":
            check_ros2(words)
        elif words[0] == "pytest":
            assert (ROOT / words[1]).exists(), words
        elif words[0] == "docker":
            assert words[1] in ("build", "run"), words
            assert (ROOT / "Dockerfile").is_file()
            inside = words[words.index("lexstack") + 1 :] if words[1] == "run" else []
            if inside:
                check_script(inside)
        elif words[0] == "python3":
            assert words[1:3] == ["-m", "venv"], words  # of a peer that is no part of the set-up
        elif not words[0].endswith("/bin/pip"):
            assert words[0] in ("export", "source", "mkdir"), f"{block.name}: {words}"


# ---- yaml


def check_yaml(text, where):
    """Check a block against the schema of what it is."""
    data = parse_yaml(text, where)
    if "initial_stack" in data:
        build(ScenarioConfig, data, where)
    elif "run" in data:
        build(SweepFile, data, where)
    elif "levels" in data:
        build(StackConfig, data, where)
    elif "joint_states" in next(iter(data.get("robots", {"": {}}).values())):
        build(PlantFile, data, where)
    elif "arm" in data:
        build(RobotFile, data, where)
    elif set(data) == {"obstacles"}:
        for name, values in data["obstacles"].items():
            build(ObstacleConfig, values, f"{where}: {name}")
    else:
        raise AssertionError(f"{where}: nothing here knows what this is: {', '.join(data)}")


@pytest.mark.parametrize("block", of("yaml"))
def test_every_yaml_block_is_what_its_schema_says(block, tmp_path):
    if "discovery:" in block.text:
        name = yaml.safe_load(block.text)["name"]
        path = tmp_path / f"{name}.yaml"
        path.write_text(block.text, encoding="utf-8")
        load_hosts(path, (*NODES, *PLANNERS, PLAYER, SERVER))
    else:
        check_yaml(block.text, block.name)


# ---- pictures


@pytest.mark.parametrize("block", of("mermaid"))
def test_every_diagram_is_of_a_kind_and_names_those_who_take_part(block):
    first, *lines = block.text.splitlines()
    assert first in ("sequenceDiagram", "stateDiagram-v2")
    if first == "sequenceDiagram":
        known = set(re.findall(r"^ +participant (\w+) as ", block.text, flags=re.MULTILINE))
        arrows = [re.match(r" +(\w+)--?>>(\w+):", line) for line in lines]
        assert {name for arrow in arrows if arrow for name in arrow.groups()} <= known


# ---- these checks can fail


@pytest.mark.parametrize(
    "line",
    [
        "./scripts/dance",
        "./scripts/demo --no-such-option",
        "./scripts/demo no-such-scenario",
        "./scripts/experiment no-such-experiment",
        "./scripts/bringup --only nobody --host-config three_hosts_peers",
        "ros2 topic echo /no/such_topic",
        'ros2 service call /robot_a/switch_stack lexstack_interfaces/srv/SwitchStack "{stak: x}"',
        'ros2 topic pub --once /robot_a/request_stack std_msgs/msg/String "{data: 5}"',
        "pytest tests/no_such_test.py",
        "curl example.org",
    ],
)
def test_a_command_that_is_wrong_is_seen(line):
    (block,) = blocks_of(f"```sh\n{line}\n```\n", "page")
    with pytest.raises((AssertionError, AttributeError)):
        test_every_command_and_option_in_a_block_exists(block)


def test_yaml_of_an_unknown_kind_is_seen():
    with pytest.raises(AssertionError, match="nothing here knows"):
        check_yaml("colour: red\n", "page")


def test_a_wrong_field_in_a_program_is_seen():
    text = (
        "./scripts/shell python - <<'END'\nfrom std_msgs.msg import String\nString(dat='x')\nEND\n"
    )
    with pytest.raises(AssertionError):
        test_programs_in_commands_compile_and_their_messages_have_the_fields(
            Block("page", 1, "sh", text)
        )
