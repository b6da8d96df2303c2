"""YAML of the plain kind; every file that is not readable is named in one line."""

import os
import time

import pytest

from lexstack.errors import ConfigurationError
from lexstack_config.reader import read_yaml
from lexstack_config.yaml_text import parse_plain, read_text

BOMB = "a: &a [x, x]\nb: &b [*a, *a]\nc: &c [*b, *b]\n"


def test_plain_yaml_is_read():
    text = "a: 1\nb: [1.5, .inf, x]\nc: {d: true, e: null}\nf: 2001-01-01\n"
    assert parse_plain(text, "f") == {
        "a": 1,
        "b": [1.5, float("inf"), "x"],
        "c": {"d": True, "e": None},
        "f": "2001-01-01",
    }


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("a: 1\nb: 2\na: 3\n", "the key 'a' stands here for the second time"),
        ("a: {b: 1, b: 2}", "the key 'b' stands here for the second time"),
        (BOMB, "aliases are not supported"),
        ("a: &a [*a]", "aliases are not supported"),
        ("a: !!python/object/apply:os.system [ls]", "could not determine a constructor"),
        ("a: !!timestamp x", "could not determine a constructor"),
        ("a:\n\tb: 1", "cannot start any token"),
        ("a: " + "[" * 5000, "nested too deeply"),
        ("a: " + "9" * 5000, "Exceeds the limit"),
        ("{[1]: 2}", "unhashable key"),
        ("", "expected a mapping of keys, got NoneType"),
        ("- 1", "expected a mapping of keys, got list"),
        ("a: 1\n---\nb: 2", "single document"),
        ("a: 'b", "unexpected end of stream"),
    ],
)
def test_what_is_not_plain_is_refused_in_one_line(text, what):
    with pytest.raises(ConfigurationError) as error:
        parse_plain(text, "file.yaml")
    assert str(error.value).startswith("file.yaml: ")
    assert what in str(error.value)
    assert str(error.value).isprintable()


def test_a_bomb_takes_no_time():
    text = "a0: &a0 [x, x]\n" + "".join(
        f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 10)}]\n" for i in range(1, 30)
    )
    begun = time.monotonic()
    with pytest.raises(ConfigurationError):
        parse_plain(text, "file.yaml")
    assert time.monotonic() - begun < 2.0


@pytest.mark.parametrize(
    ("make", "what"),
    [
        (lambda path: None, "No such file"),
        (lambda path: path.mkdir(), "no regular file"),
        (os.mkfifo, "no regular file"),
        (lambda path: path.symlink_to("/dev/zero"), "no regular file"),
        (lambda path: path.symlink_to(path), "cannot be read"),
        (lambda path: path.write_bytes(b"a: \xff\xfe"), "can't decode byte"),
        (lambda path: path.write_bytes("a: 1".encode("utf-16")), "can't decode byte"),
        (lambda path: path.write_bytes(b"a: 1\n" * 1_000_000), "more than 4000000 bytes"),
    ],
    ids=["none", "folder", "pipe", "endless", "loop", "bytes", "utf-16", "huge"],
)
def test_what_is_no_text_file_is_refused_in_one_line(tmp_path, make, what):
    path = tmp_path / "file.yaml"
    make(path)
    with pytest.raises(ConfigurationError) as error:
        read_yaml(path)
    assert what in str(error.value)
    assert str(error.value).isprintable()


def test_a_name_that_is_none_is_refused(tmp_path):
    with pytest.raises(ConfigurationError, match="cannot be read"):
        read_text(tmp_path / "a\0b")
    with pytest.raises(ConfigurationError, match="cannot be read"):
        read_text(tmp_path / ("x" * 5000))
