"""Bytes that ``messages.cdr`` reads and writes are those of the generated types, always."""

from __future__ import annotations

import math
import time
from functools import cache
from importlib import import_module
from typing import Any

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from nav_msgs.msg import Odometry
from rclpy.serialization import deserialize_message, serialize_message
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from sensor_msgs.msg import JointState
from std_msgs.msg import Empty
from tf2_msgs.msg import TFMessage
from trajectory_msgs.msg import JointTrajectory

from lexstack_bag.storage.definitions import message_definition
from lexstack_interfaces.msg import Chi, PlantState, References, SequenceTask, TransitionStatus
from lexstack_ros.messages.cdr import Buffer, Reader
from lexstack_ros.messages.cdr_layout import HEAD, CdrError, Field, Layout, fields_of

KINDS = (
    PlantState,
    Chi,
    TransitionStatus,
    References,
    SequenceTask,
    TFMessage,
    JointState,
    JointTrajectory,
    Odometry,
    DiagnosticArray,
)
_INTEGERS = {"int8": 8, "int16": 16, "int32": 32, "int64": 64}


def number(kind: str, rng: np.random.Generator) -> Any:
    """Return a random number of a kind, the extremes among them."""
    if kind == "boolean":
        return bool(rng.integers(2))
    if kind == "octet":
        return bytes([rng.integers(256)])
    if kind in ("float", "double"):
        value = rng.choice([0.0, -0.0, math.inf, -math.inf, math.nan, float(rng.normal())])
        return float(np.float32(value)) if kind == "float" else float(value)
    bits = _INTEGERS[kind.removeprefix("u")]
    low, high = (0, 2**bits) if kind[0] == "u" else (-(2 ** (bits - 1)), 2 ** (bits - 1))
    return int.from_bytes(rng.bytes(8), "little") % (high - low) + low


def text(rng: np.random.Generator) -> str:
    """Return a random text, of all lengths of padding."""
    return "".join(rng.choice(list("ab/ä€𝛼 "), rng.integers(0, 9)))


def fill(message: Any, rng: np.random.Generator, *, numbers_only: bool = False) -> Any:
    """Write random values into all fields, or new numbers in place of the numbers."""
    for field in fields_of(type(message)):
        setattr(message, field.name, value(message, field, rng, numbers_only))
    return message


def value(message: Any, field: Field, rng: np.random.Generator, numbers_only: bool) -> Any:
    """Return a random value of a field."""
    old, count = getattr(message, field.name), field.count
    if numbers_only and field.kind == "string":
        return old
    if count is None:
        if not field.kind:
            return fill(old, rng, numbers_only=numbers_only)
        return text(rng) if field.kind == "string" else number(field.kind, rng)
    many = len(old) if numbers_only else int(rng.integers(0, 5)) if count < 0 else count
    if not field.kind:
        inner = list(old) if numbers_only else [nested(message, field) for _ in range(many)]
        return [fill(each, rng, numbers_only=numbers_only) for each in inner]
    return [text(rng) if field.kind == "string" else number(field.kind, rng) for _ in range(many)]


def nested(message: Any, field: Field) -> Any:
    """Return an empty message of a sequence's type."""
    described = type(message).get_fields_and_field_types()[field.name]
    package, name = described.removeprefix("sequence<").split(",")[0].strip(">").split("/")
    return getattr(import_module(f"{package}.msg"), name)()


def same(got: Any, message: Any, where: str = "") -> None:
    """Fail unless values read are those of a generated message."""
    for field in fields_of(type(message)):
        one, other, path = (
            getattr(got, field.name),
            getattr(message, field.name),
            f"{where}.{field.name}",
        )
        if not field.kind:
            pairs = [(one, other)] if field.count is None else list(zip(one, other, strict=True))
            for k, pair in enumerate(pairs):
                same(*pair, f"{path}.{k}")
        elif field.kind == "string":
            assert one == (other if field.count is None else list(other)), path
        elif field.count is None:
            assert type(one) is type(other), path
            np.testing.assert_array_equal(one, other, path)
        elif field.kind == "octet":
            # numpy drops zeros at the end of bytes
            assert [byte.ljust(1, b"\0") for byte in one.tolist()] == list(other), path
        else:
            np.testing.assert_array_equal(one, np.asarray(other, one.dtype), path)


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_what_is_read_is_what_was_written(kind):
    rng, read = np.random.default_rng(1), Reader(kind)
    for _ in range(60):  # one reader: layouts follow one another
        message = fill(kind(), rng)
        for _ in range(2):  # at the second time with the layout of the first
            data = serialize_message(fill(message, rng, numbers_only=True))
            same(read(data), deserialize_message(data, kind))


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_numbers_are_written_as_the_generated_type_writes_them(kind):
    rng = np.random.default_rng(2)
    for _ in range(40):
        message = fill(kind(), rng)
        buffer = Buffer(message)
        fill(message, rng, numbers_only=True)
        put(buffer, message)
        assert len(buffer.data) == len(bare(buffer.data, kind))
        assert bare(buffer.data, kind) == bare(serialize_message(message), kind)


def bare(data: bytes, kind: type, *, little: bool = True) -> bytes:
    """Return a message with zeros for padding, in which generated types leave what was there."""
    name = f"{kind.__module__.split('.')[0]}/msg/{kind.__name__}"
    store, data = store_of(name), data[: HEAD + Layout(fields_of(kind), data).size]
    return bytes(store.serialize_cdr(store.deserialize_cdr(data, name), name, little_endian=little))


@cache
def store_of(name: str) -> Any:
    """Return a type store of rosbags' that knows a type."""
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(message_definition(name), name))
    return store


def put(buffer: Buffer, message: Any, path: str = "") -> None:
    """Write all numbers of a message into a buffer."""
    for field in fields_of(type(message)):
        at, given = path + field.name, getattr(message, field.name)
        if not field.kind:
            for k, each in [(None, given)] if field.count is None else list(enumerate(given)):
                put(buffer, each, f"{at}." if k is None else f"{at}.{k}.")
        elif field.kind != "string":
            if field.count is None:
                buffer.put(at, given)
            else:
                buffer.put_all(at, given)


@pytest.mark.parametrize(
    "kind", [PlantState, Chi, TransitionStatus], ids=lambda kind: kind.__name__
)
def test_the_order_of_bytes_is_the_messages(kind):
    rng, read = np.random.default_rng(3), Reader(kind)
    for _ in range(30):
        data = serialize_message(fill(kind(), rng))
        turned = bare(data, kind, little=False)
        assert turned[:2] == b"\x00\x00"
        for each in (turned, data):
            same(read(each), deserialize_message(data, kind))


def test_a_part_is_read_where_no_more_is_wanted():
    message = fill(Chi(), np.random.default_rng(4))
    message.transitions = [TransitionStatus(to_stack="posture")]
    data = serialize_message(message)
    read = Reader(Chi, wanted=("tick", "chi", "robots"))
    got = read(data)
    assert sorted(vars(got)) == ["chi", "robots", "tick"]
    assert (got.tick, got.robots) == (message.tick, list(message.robots))
    # What comes behind may be missing: the sender is of before a field was added.
    end = data.index(b"posture")
    assert read(data[: end - 60]).tick == message.tick


@pytest.mark.parametrize("kind", [PlantState, Chi], ids=lambda kind: kind.__name__)
def test_no_part_of_a_message_is_taken_for_one(kind):
    rng = np.random.default_rng(5)
    data = serialize_message(fill(kind(), rng))
    known = Reader(kind)
    known(data)
    for length in range(HEAD + Layout(fields_of(kind), data).size):
        for read in (Reader(kind), known):
            with pytest.raises(CdrError):
                read(data[:length])
    for wrong in (b"", b"\x00", b"\x00\x03\x00\x00" + data[4:], b"\xff" * 200):
        with pytest.raises(CdrError):
            known(wrong)
    known(data)


def test_random_bytes_are_refused_or_read():
    rng, read = np.random.default_rng(6), Reader(Chi)
    data = serialize_message(fill(Chi(), rng))
    for _ in range(2000):
        broken = bytearray(data)
        for _ in range(3):
            broken[rng.integers(len(broken))] = rng.integers(256)
        try:
            read(bytes(broken))
        except CdrError:
            continue


@pytest.mark.parametrize("number", [3000, 99_999])
def test_a_long_message_takes_no_long_time(number):
    message = TransitionStatus(to_stack="posture")
    one = serialize_message(Chi(transitions=[message]))
    two = serialize_message(Chi(transitions=[message] * 2))
    many = serialize_message(Chi(transitions=[message] * number))
    assert len(many) > number * (len(two) - len(one)) // 2
    begun, read = time.process_time(), Reader(Chi)
    if number == 3000:
        assert len(read(many).transitions) == number
    else:
        with pytest.raises(CdrError, match="more than 100000 fields"):
            read(many)
    assert time.process_time() - begun < 2.0  # 0.3 s; quadratic in the number: 4 s and an hour


def test_a_buffer_takes_numbers_alone():
    buffer = Buffer(PlantState(q=[1.0, 2.0], sender="one"))
    with pytest.raises(ValueError, match="q: 3 numbers in place of 2"):
        buffer.put_all("q", np.zeros(3))
    with pytest.raises(KeyError):
        buffer.put("sender", "another")
    assert Reader(Empty)(serialize_message(Empty())) is not None
