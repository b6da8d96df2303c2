"""Bags as files: finds them and streams their records, a chunk in memory at a time."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from heapq import heappop, heappush
from io import BytesIO
from pathlib import Path

from mcap.data_stream import ReadDataStream
from mcap.exceptions import EndOfFile, McapError
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.records import Channel, Chunk, McapRecord, Message, Metadata, Schema
from mcap.stream_reader import StreamReader, get_chunk_data_stream
from zstandard import ZstdError

from lexstack_bag.errors import BagError
from lexstack_bag.topics import plain_name

_RECORD = struct.Struct("<BQ")  # opcode, length of what follows
_MESSAGE = struct.Struct("<HIQQ")  # channel, sequence, log time, publish time

Progress = Callable[[float], None]
"""Told how much is done, from 0 to 1."""


@dataclass(frozen=True, slots=True)
class RawMessage:
    """One message as it lies in a bag."""

    topic: str  # see plain_name
    schema: Schema
    data: bytes
    log_time: int  # ns since 1970: when it was received
    publish_time: int  # ns since 1970: when it was sent
    sequence: int  # the publisher's number of it, from 1; 0: unknown


def find_files(path: Path) -> list[Path]:
    """Return the .mcap files of a run folder, a bag folder or a file, in recording order.

    Raises:
        BagError: there is nothing, or nothing like a bag.
    """
    if path.is_file():
        return [path]
    if not path.is_dir():
        raise BagError(f"{path}: no such file or folder")
    for folder in (path, path / "bag"):
        files = sorted(folder.glob("*.mcap"), key=lambda file: (len(file.name), file.name))
        if files:
            return files
    raise BagError(f"{path}: holds no bag (no .mcap file in it or in bag/)")


class Container:
    """The records of one bag, in the order in which they were written.

    Attributes:
        metadata: content of the Metadata records seen so far, by name; the last of a name counts.
        complete: False once a file turned out to end before its end, as after a kill.
        topics: type and metadata of each topic seen so far, by name.
        namespace: of the run, like /cell1: names are told without it, and topics outside of it
            are left out; empty: none.
    """

    def __init__(self, files: list[Path], namespace: str = "") -> None:
        """Take the files of a bag; nothing is read yet."""
        self.files = files
        self.namespace = namespace
        self.metadata: dict[str, dict[str, str]] = {}
        self.complete = True
        self.topics: dict[str, tuple[str, dict[str, str]]] = {}

    def first_metadata(self, name: str) -> dict[str, str]:
        """Return the content of the first Metadata record of a name; empty: there is none.

        Raises:
            BagError: not a bag, or damaged.
        """
        for path in self.files:
            for record, _ in self._records(path):
                if isinstance(record, Metadata) and record.name == name:
                    return dict(record.metadata)
        return {}

    def topics_of_all_files(self) -> set[str]:
        """Return the names of all topics, those outside of the namespace too.

        They stand in the index at the end of each file; of a file without one all is read.
        """
        found: set[str] = set()
        for path in self.files:
            try:
                with path.open("rb") as stream:
                    summary = make_reader(stream).get_summary()
            except (OSError, McapError, struct.error, ValueError):
                summary = None
            if summary is None or not summary.channels:
                whole = Container([path])
                for _ in whole.messages():
                    pass
                found.update(whole.topics)
            else:
                found.update(channel.topic for channel in summary.channels.values())
        return found

    def messages(self, progress: Progress = lambda _part: None) -> Iterator[RawMessage]:
        """Yield every message; raises BagError for what is not a bag or is damaged."""
        try:
            sizes = [path.stat().st_size for path in self.files]
        except OSError as error:
            raise BagError(f"{error.filename}: cannot be read: {error.strerror}") from error
        before, whole = 0, max(sum(sizes), 1)
        for path, size in zip(self.files, sizes, strict=True):
            names = _Names(self.topics, self.namespace)
            for record, offset in self._records(path):
                if isinstance(record, Chunk):
                    yield from _contents(record, names, path)
                elif isinstance(record, Message):
                    message = names.message(record)
                    if message.topic:
                        yield message
                else:
                    self._keep(record, names)
                progress((before + offset) / whole)
            before += size
        progress(1.0)

    def _keep(self, record: McapRecord, names: _Names) -> None:
        """Take note of what messages need, and of what the bag says about itself."""
        if isinstance(record, Schema | Channel):
            names.learn(record)
        elif isinstance(record, Metadata):
            self.metadata[record.name] = record.metadata

    def _records(self, path: Path) -> Iterator[tuple[McapRecord, int]]:
        """Yield one file's records, chunks whole, and where each ends; a cut-off file just ends."""
        seen = 0
        try:
            with path.open("rb") as stream:
                for record in StreamReader(stream, emit_chunks=True).records:
                    seen += 1
                    yield record, stream.tell()
        except OSError as error:
            raise BagError(f"{path}: cannot be read: {error.strerror}") from error
        except (EndOfFile, struct.error) as error:
            if not seen:
                raise BagError(f"{path}: not an MCAP file, or empty") from error
            self.complete = False
        except (McapError, ValueError, KeyError) as error:
            raise BagError(f"{path}: not a readable MCAP file: {error}") from error


def by_log_time(messages: Iterable[RawMessage], window: float = 2.0) -> Iterator[RawMessage]:
    """Yield messages in the order of their log times.

    A recorder takes what waits on one topic, then on the next: in the file messages of different
    topics may have changed places, by far less than ``window`` [s].
    """
    waiting: list[tuple[int, int, RawMessage]] = []
    for number, message in enumerate(messages):
        heappush(waiting, (message.log_time, number, message))
        while message.log_time - waiting[0][0] > 1e9 * window:
            yield heappop(waiting)[2]
    while waiting:
        yield heappop(waiting)[2]


@dataclass(slots=True)
class _Names:
    """The definitions of one file so far, by the ids that its messages bear."""

    topics: dict[str, tuple[str, dict[str, str]]]  # type and metadata, of all files
    namespace: str
    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)

    def learn(self, record: Schema | Channel) -> None:
        """Take a definition."""
        if isinstance(record, Schema):
            self.schemas[record.id] = record
        else:
            self.channels[record.id] = record
            topic = plain_name(record.topic, self.namespace)
            if topic:
                self.topics[topic] = self.schemas[record.schema_id].name, record.metadata

    def of(self, channel: int) -> tuple[str, Schema]:
        """Return a channel's topic, '' outside of the namespace, and its schema."""
        found = self.channels[channel]
        return plain_name(found.topic, self.namespace), self.schemas[found.schema_id]

    def message(self, record: Message) -> RawMessage:
        """Return a message that stands outside of chunks."""
        topic, schema = self.of(record.channel_id)
        times = record.log_time, record.publish_time
        return RawMessage(topic, schema, record.data, *times, record.sequence)


def _contents(chunk: Chunk, names: _Names, path: Path) -> Iterator[RawMessage]:
    """Yield a chunk's messages; raises BagError where it is damaged.

    Several times faster than the package's reader, which makes a stream of every chunk.
    """
    try:
        data = _unpacked(chunk)
        place, end, known = 0, len(data), {}
        while place < end:
            opcode, length = _RECORD.unpack_from(data, place)
            place += _RECORD.size
            if opcode == Opcode.MESSAGE:
                channel, sequence, received, sent = _MESSAGE.unpack_from(data, place)
                if channel not in known:
                    known[channel] = names.of(channel)
                if known[channel][0]:
                    content = data[place + _MESSAGE.size : place + length]
                    yield RawMessage(*known[channel], content, received, sent, sequence)
            elif opcode == Opcode.SCHEMA:
                names.learn(Schema.read(_stream(data[place : place + length])))
            elif opcode == Opcode.CHANNEL:
                names.learn(Channel.read(_stream(data[place : place + length])))
            place += length
    except (McapError, ValueError, KeyError, struct.error, ZstdError, EndOfFile) as error:
        raise BagError(f"{path}: not a readable MCAP file: {error}") from error


def _unpacked(chunk: Chunk) -> bytes:
    """Return a chunk's content, its checksum verified if it has one."""
    stream, length = get_chunk_data_stream(chunk)
    data = stream.read(length)
    if chunk.uncompressed_crc and zlib.crc32(data) != chunk.uncompressed_crc:
        raise ValueError("the checksum of a chunk is wrong")
    return data


def _stream(data: bytes) -> ReadDataStream:
    """Return bytes as the package's records read them."""
    return ReadDataStream(BytesIO(data))
