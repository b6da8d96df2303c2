"""Every key of every configuration file, with every kind of wrong value in its place."""

import copy
from functools import cache

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from lexstack.errors import ConfigurationError, LexstackError
from lexstack_config.parts import Parts, build_controller
from lexstack_config.reader import build
from lexstack_config.resolved import ResolvedScenario
from support.fuzz_config import KINDS, check_line, check_short
from support.scenario import CONFIG, resolved

JUNK = (
    *(float("nan"), float("inf"), float("-inf"), 1e308, -1e308, 5e-324, -1.0, 0, -0.0),
    *(2**80, -(2**31), True, False, None, "", "x", "../../x", "a\nb", "a b", "\x00", "\ud800"),
    *("x" * 100_000, [], {}, [[]], [None], [1.0] * 1000, {"": 1}, {1: 2}, {"a": {"b": []}}),
)
junk = st.sampled_from(JUNK) | st.floats() | st.integers() | st.text(max_size=20)


def places(tree, path=()):
    """Yield the path of every value in a tree of dictionaries and lists."""
    items = tree.items() if isinstance(tree, dict) else enumerate(tree)
    for key, value in items:
        yield (*path, key)
        if isinstance(value, dict | list):
            yield from places(value, (*path, key))


def changed(tree, path, value):
    """Return a copy of a tree with another value at a place."""
    result = copy.deepcopy(tree)
    inner = result
    for key in path[:-1]:
        inner = inner[key]
    inner[path[-1]] = value
    return result


@cache
def files():
    """Return kind and content of every configuration file."""
    return [
        (kind, yaml.safe_load(path.read_text(encoding="utf-8")))
        for folder, kind in KINDS.items()
        for path in sorted((CONFIG / folder).glob("*.yaml"))
    ]


@settings(max_examples=1000, deadline=None, derandomize=True)
@given(st.data())
def test_any_value_anywhere_is_taken_or_refused_in_one_line(data):
    kind, tree = data.draw(st.sampled_from(files()))
    path = data.draw(st.sampled_from(list(places(tree))))
    try:
        build(kind, changed(tree, path, data.draw(junk)), "file.yaml")
    except ConfigurationError as error:
        check_line(str(error))


@settings(max_examples=150, deadline=None, derandomize=True)
@given(st.data())
def test_what_the_schema_takes_becomes_a_controller_or_is_refused(data):
    """Values that are formally right but senseless do not crash what is built from them."""
    from lexstack_config.reader import plain

    tree = plain(resolved())
    path = data.draw(st.sampled_from(list(places(tree))))
    try:
        scenario = build(ResolvedScenario, changed(tree, path, data.draw(junk)), "file.yaml")
        build_controller(scenario, Parts.of(scenario))
    except LexstackError as error:
        check_short(str(error))


@pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)
@pytest.mark.parametrize("tree", [{}, [], None, 1, "x", {"unknown": 1}, {1: 1}])
def test_a_wrong_whole_is_refused(kind, tree):
    with pytest.raises(ConfigurationError) as error:
        build(kind, tree, "file.yaml")
    check_line(str(error.value))
