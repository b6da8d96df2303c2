"""The JSON Schemas of configuration files: as the dataclasses say, and as the loader judges."""

import copy
import dataclasses
import json
import re
import sys

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from jsonschema import Draft7Validator

import schemas
from lexstack.errors import ConfigurationError
from lexstack.options import OLD_NAMES
from lexstack.tasks import StackConfig, build_stack
from lexstack_config.field_notes import notes_of
from lexstack_config.reader import build
from support.scenario import CONFIG, ROOT, team

FILES = [
    (folder, path) for folder in schemas.KINDS for path in sorted((CONFIG / folder).glob("*.yaml"))
]
IDS = [f"{folder}/{path.stem}" for folder, path in FILES]
INF = float("inf")


def schema(folder):
    """Return the committed schema of a folder's files."""
    return json.loads(schemas.schema_of(folder).read_text(encoding="utf-8"))


VALIDATORS = {folder: Draft7Validator(schema(folder)) for folder in schemas.KINDS}


def content(name):
    """Return what is in a file of the configuration."""
    return yaml.safe_load((CONFIG / f"{name}.yaml").read_text(encoding="utf-8"))


def load(folder, data):
    """Return what the loader makes of a file's content; raises ConfigurationError."""
    made = build(schemas.KINDS[folder], data, "file.yaml")
    return build_stack(made, team(), "file.yaml") if isinstance(made, StackConfig) else made


def changed(data, path, value):
    """Return a copy with another value at a path of keys; ``...`` takes the key away."""
    result = copy.deepcopy(data)
    place = result
    for key in path[:-1]:
        place = place[key]
    if value is ...:
        del place[path[-1]]
    else:
        place[path[-1]] = value
    return result


@pytest.mark.parametrize("folder", schemas.KINDS)
def test_the_committed_schema_is_what_the_dataclasses_give(folder):
    assert schemas.schema_of(folder).read_text(encoding="utf-8") == schemas.made(folder)
    Draft7Validator.check_schema(schema(folder))


def test_every_folder_of_files_has_a_schema():
    folders = {str(path.parent.relative_to(CONFIG)) for path in CONFIG.rglob("*.yaml")}
    assert folders == set(schemas.KINDS)


@pytest.mark.parametrize(("folder", "path"), FILES, ids=IDS)
def test_every_file_fits_its_schema_and_names_it(folder, path):
    text = path.read_text(encoding="utf-8")
    VALIDATORS[folder].validate(yaml.safe_load(text))
    named = re.match(r"# yaml-language-server: \$schema=(\S+)\n", text).group(1)
    assert (path.parent / named).resolve() == schemas.schema_of(folder)


@pytest.mark.parametrize("folder", schemas.KINDS)
def test_every_key_is_described(folder):
    whole = schema(folder)
    for part in (whole, *whole["definitions"].values()):
        assert part["description"]
        without = [key for key, value in part["properties"].items() if "description" not in value]
        assert not without, part["description"]


def test_units_come_from_the_comments_of_the_fields():
    stacks = schema("stacks")["definitions"]
    assert stacks["JointLimitConfig"]["properties"]["velocity"]["description"].startswith("rad/s")
    margin = schema("htmpc")["definitions"]["CollisionConfig"]["properties"]["margin"]
    assert margin == {"description": "m, delta_safe", "type": "number", "minimum": 0.0}


@dataclasses.dataclass
class Noted:
    """A class with comments in all places."""

    bare: int
    # of one line
    beside: int  # m
    # of two lines,
    # in rad
    below: int
    split: dict[  # by name
        str, int
    ]  # N
    none: int

    def method(self):  # not a field's
        """Do nothing."""


def test_a_field_s_comment_is_beside_or_above_it():
    wanted = {"beside": "of one line m", "below": "of two lines, in rad", "split": "by name N"}
    assert notes_of(Noted) == wanted


WRONG = {
    "an unknown key": ("stacks/track", ("speed",), 1.0),
    "a key that is missing": ("scenarios/reach", ("rate",), ...),
    "a text for a number": ("scenarios/reach", ("rate",), "fast"),
    "a number in quotes": ("hosts/three_hosts_peers", ("domain",), "42"),
    "a boolean for a number": ("robots/panda_summit", ("base", "chassis_mass"), True),
    "a fraction for an integer": ("htmpc/lexstack", ("horizon",), 10.5),
    "a number for a name": ("stacks/track", ("name",), 3),
    "a list for a mapping": ("scenarios/reach", ("robots",), ["robot_a"]),
    "a mapping for a list": ("stacks/track", ("levels",), {"tasks": []}),
    "null where it means nothing": ("scenarios/reach", ("duration",), None),
    "too few entries": ("robots/panda_summit", ("base", "velocity"), [1.0, 1.0]),
    "too many entries": ("robots/panda_summit", ("tool", "xyz"), [0.0] * 4),
    "no entries": ("stacks/track", ("levels",), []),
    "no robots": ("scenarios/reach", ("robots",), {}),
    "no nodes": ("hosts/three_hosts_peers", ("hosts", "robot_a", "nodes"), []),
    "zero": ("htmpc/lexstack", ("step",), 0),
    "less than zero": ("htmpc/lexstack", ("early_stop_ratio",), -0.1),
    "an end that is open": ("htmpc/lexstack", ("line_search", "beta"), 1.0),
    "less than the range": ("htmpc/lexstack", ("horizon",), 1),
    "more than the range": ("hosts/three_hosts_peers", ("domain",), 233),
    "faster than the plant": ("scenarios/reach", ("rate",), 1000.5),
    "infinite beyond a limit": ("scenarios/reach", ("duration",), INF),
    "zero in a list": ("robots/ur10_ridgeback", ("arm", "velocity", 2), 0.0),
    "a gain of zero": ("htmpc/baselines/htidkc-tuned", ("ee_gain",), 0.0),
    "an unknown choice": ("scenarios/transition-sequence", ("transition", "profile"), "jump"),
    "a name that is none": ("scenarios/reach", ("name",), "a b"),
    "a name beside a topic": ("scenarios/reach", ("robots", "robot-c"), {"model": "x", "base": []}),
    "an unknown task": ("stacks/track", ("levels", 0, "tasks", 0, "type"), "dance"),
    "a parameter of another task": (
        "stacks/track",
        ("levels", 0, "tasks", 0, "parameters", "margin"),
        0.1,
    ),
    "a parameter out of range": (
        "stacks/track",
        ("levels", 0, "tasks", 0, "parameters"),
        {"gain": 0},
    ),
    "no point to look at": (
        "stacks/carry",
        ("levels", 0, "tasks", 0),
        {"type": "look_at", "robot": "robot_a", "parameters": {"gain": 1.0}},
    ),
    "no parameters where one is needed": (
        "stacks/carry",
        ("levels", 0, "tasks", 0),
        {"type": "look_at", "robot": "robot_a"},
    ),
    "a pose of another frame that is none": (
        "stacks/carry",
        ("levels", 0, "tasks", 0, "parameters", "pose"),
        {"xyz": [0.0, 0.0]},
    ),
    "both names of a key": ("htmpc/lexstack", ("enough",), 0.03),
    "neither name of a key": ("htmpc/lexstack", ("early_stop_ratio",), ...),
}


@pytest.mark.parametrize(("name", "path", "value"), WRONG.values(), ids=WRONG)
def test_what_is_wrong_is_refused_by_schema_and_loader(name, path, value):
    folder, data = name.rpartition("/")[0], content(name)
    load(folder, data)
    wrong = changed(data, path, value)
    assert not VALIDATORS[folder].is_valid(wrong)
    with pytest.raises(ConfigurationError) as error:
        load(folder, wrong)
    line = str(error.value)
    assert line.startswith("file.yaml: ")
    assert line.isprintable()


def test_old_names_fit_too():
    data = content("htmpc/lexstack")
    for old, new in OLD_NAMES["HtmpcConfig"].items():
        data[old] = data.pop(new)
    VALIDATORS["htmpc"].validate(data)
    for name in ("stacks/track", "stacks/avoid"):
        text = (CONFIG / f"{name}.yaml").read_text(encoding="utf-8")
        for old, new in OLD_NAMES["TaskConfig.type"].items():
            text = text.replace(f"type: {new}\n", f"type: {old}\n")
        VALIDATORS["stacks"].validate(yaml.safe_load(text))
        assert "type: minimum_velocity" in text
        # The parameters of an old name are checked as well.
        wrong = text.replace(
            "type: minimum_velocity\n", "type: minimum_velocity\n        parameters: {x: 1}\n"
        )
        assert not VALIDATORS["stacks"].is_valid(yaml.safe_load(wrong))


def places(tree, path=()):
    """Yield the path of every value in a tree of dictionaries and lists."""
    for key, value in tree.items() if isinstance(tree, dict) else enumerate(tree):
        yield (*path, key)
        if isinstance(value, dict | list):
            yield from places(value, (*path, key))


JUNK = (INF, -INF, 1e308, -1.0, 0, -0.0, 0.5, 2**80, True, None, "", "x", "a\nb", "a b", ...)
JUNK = (*JUNK, "x" * 100, [], {}, [[]], [None], [1.0] * 1000, {"": 1}, {1: 2}, {"a": {"b": []}})


@settings(max_examples=1500, deadline=None, derandomize=True)
@given(st.data())
def test_the_loader_refuses_whatever_a_schema_refuses(data):
    """An editor marks nothing that would run."""
    folder, path = data.draw(st.sampled_from(FILES))
    tree = content(path.relative_to(CONFIG).with_suffix(""))
    wrong = changed(
        tree, data.draw(st.sampled_from(list(places(tree)))), data.draw(st.sampled_from(JUNK))
    )
    if not VALIDATORS[folder].is_valid(wrong):
        with pytest.raises(ConfigurationError):
            load(folder, wrong)


def test_the_command_writes_what_differs_and_says_so(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(schemas, "CONFIG", tmp_path / "config")
    (tmp_path / "config").mkdir()
    monkeypatch.setattr(sys, "argv", ["schemas", "--check"])
    assert schemas.main() == 1
    assert "config/schema/stacks.json: differs\n" in capsys.readouterr().out
    monkeypatch.setattr(sys, "argv", ["schemas"])
    assert schemas.main() == 0
    assert schemas.main() == 0
    assert capsys.readouterr().out.count("written") == len(schemas.KINDS)
    ours = ROOT / "config" / "schema" / "hosts.json"
    assert schemas.schema_of("hosts").read_bytes() == ours.read_bytes()
