"""docs/htmpc.md: kinds, keys, defaults and units of sequence tasks are those of the schema."""

import dataclasses
import re
import typing

import pytest
import yaml

from lexstack.mpc import COLUMNS, Kind, SequenceTask, SequenceTaskConfig
from lexstack_interfaces.msg import SequenceTask as Message
from support.scenario import ROOT

PAGE = (ROOT / "docs" / "htmpc.md").read_text(encoding="utf-8").split("### The tasks of a")[1]


def table(head):
    """Return the rows of the table whose first column is ``head``."""
    lines = re.search(rf"^\| {head} \|.*\n\|.*\n((?:\|.*\n)+)", PAGE, flags=re.MULTILINE).group(1)
    return [
        [c.strip().strip("`") for c in line.strip("|").split("|")] for line in lines.splitlines()
    ]


def test_every_kind_stands_in_the_table_with_its_coordinates():
    rows = {row[0]: row[2] for row in table("kind")}
    assert set(rows) == set(COLUMNS) == set(typing.get_args(Kind))
    hint = typing.get_type_hints(SequenceTaskConfig)["kind"]
    assert set(rows) == set(typing.get_args(hint))
    for kind, text in rows.items():
        if COLUMNS[kind] is None:
            assert text == "one position per joint"
            continue
        names = text.replace("and the quaternion", "").replace("the quaternion", "")
        assert len(names.replace(",", " ").split()) == COLUMNS[kind], kind


def test_every_key_stands_in_the_table_with_its_default():
    told = {row[0]: yaml.safe_load(row[1]) for row in table("key")}
    wanted = {
        field.name: "–" if field.default is dataclasses.MISSING else field.default
        for field in dataclasses.fields(SequenceTaskConfig)
    }
    assert told == {**wanted, "joints": list(wanted["joints"])}
    # Positions of joints are no poses: in the message they have a list of their own.
    assert {*told, "positions"} == set(Message.get_fields_and_field_types())


@pytest.mark.parametrize("name", ["tolerance", "tolerance_angle", "dwell", "held"])
def test_the_schema_has_the_defaults_of_the_library(name):
    fields = {field.name: field.default for field in dataclasses.fields(SequenceTask)}
    assert fields[name] == SequenceTaskConfig.__dataclass_fields__[name].default


def test_units_of_the_table_are_those_of_the_schema():
    source = (ROOT / "ros2_ws/src/lexstack/lexstack/mpc/sequence/options.py").read_text("utf-8")
    for name, _, unit, *_ in table("key"):
        if unit and name != "points":
            (comment,) = re.findall(rf"^    {name}: .*# (\S+)", source, flags=re.MULTILINE)
            assert comment.rstrip(",;") == unit, name
