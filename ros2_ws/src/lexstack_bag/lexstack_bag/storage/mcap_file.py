"""Writes one MCAP file, message by message, fast enough for a recorder.

The ``mcap`` package has the records; its writer knows no level of compression and spends more
on a message than the rest of a recorder. The format: https://mcap.dev/spec.
"""

from __future__ import annotations

import struct
import time
import zlib
from array import array
from collections.abc import Iterable, Mapping
from pathlib import Path

import zstandard
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)

from lexstack_bag.storage.presets import Preset

_MAGIC = b"\x89MCAP0\r\n"
_MESSAGE = struct.Struct("<BQHIQQ")  # opcode, length, channel, sequence, log and publish time
_MESSAGE_FIELDS = 22  # bytes of a message's record besides opcode, length and data
_INDEX = struct.Struct("<BQHI")  # opcode, length, channel, bytes of the entries
_FOOTER_HEAD = struct.Struct("<BQQQ")


class McapFile:
    """One file that is being written; nothing of it is held back longer than the preset says.

    Attributes:
        size: bytes handed to the file so far; the open chunk is not among them.
    """

    def __init__(self, path: Path, preset: Preset) -> None:
        """Create the file; raises OSError."""
        self.size = 0
        self._preset = preset
        self._zstd = None if preset.level is None else zstandard.ZstdCompressor(preset.level)
        self._file = path.open("xb")
        self._chunk = _Chunk()
        self._schemas: list[Schema] = []
        self._channels: list[Channel] = []
        self._chunks = bytearray()  # their index: as objects an hour would take 25 MB
        self._chunk_count = 0
        self._metadata: list[MetadataIndex] = []
        self._counts: list[int] = [0]  # by channel id
        self._span = (0, 0)  # ns, first and last log time
        self._put(_MAGIC + _encoded(Header("ros2", "lexstack_bag")))

    @property
    def closed(self) -> bool:
        """Whether the file is complete."""
        return self._file.closed

    def add_schema(self, name: str, text: str) -> int:
        """Return the id of a new message definition in the format ``ros2msg``."""
        schema = Schema(len(self._schemas) + 1, text.encode(), "ros2msg", name)
        self._schemas.append(schema)
        self._define(schema)
        return schema.id

    def add_channel(self, topic: str, schema: int, metadata: Mapping[str, str]) -> int:
        """Return the id of a new channel, whose messages are in CDR."""
        channel = Channel(len(self._channels) + 1, topic, "cdr", dict(metadata), schema)
        self._channels.append(channel)
        self._counts.append(0)
        self._define(channel)
        return channel.id

    def add_metadata(self, name: str, content: Mapping[str, str]) -> None:
        """Append a Metadata record, at once and outside of chunks."""
        data = _encoded(Metadata(name, dict(content)))
        self._metadata.append(MetadataIndex(self.size, len(data), name))
        self._put(data)

    def add_message(
        self, channel: int, sequence: int, log_time: int, publish_time: int, data: bytes
    ) -> None:
        """Append a message; times in ns since 1970, the sequence number has 32 bits."""
        head = _MESSAGE.pack(
            Opcode.MESSAGE, _MESSAGE_FIELDS + len(data), channel, sequence, log_time, publish_time
        )
        if not any(self._span):
            self._span = (log_time, log_time)
        elif not self._span[0] <= log_time <= self._span[1]:
            self._span = (min(self._span[0], log_time), max(self._span[1], log_time))
        self._counts[channel] += 1
        if not self._preset.chunk_bytes:
            self._file.write(head)
            self._file.write(data)
            self.size += len(head) + len(data)
            return
        self._chunk.add(channel, log_time, head, data)
        if self._chunk.size >= self._preset.chunk_bytes:
            self._end_chunk()

    def flush(self) -> None:
        """Hand over to the operating system all that is older than the preset's ``hold``."""
        if self._chunk.entries and self._chunk.age() >= self._preset.hold:
            self._end_chunk()
        self._file.flush()

    def close(self) -> None:
        """Complete the file: the open chunk, the summary with the index, the footer."""
        self._end_chunk()
        self._put(_encoded(DataEnd(0)))
        self._put_summary()
        self._file.close()

    def _define(self, record: Schema | Channel) -> None:
        """Write a definition where the messages that need it go, before them."""
        if self._preset.chunk_bytes:
            self._chunk.define(_encoded(record))
        else:
            self._put(_encoded(record))

    def _end_chunk(self) -> None:
        """Write the open chunk and its index, unless it has no message."""
        chunk = self._chunk
        if not chunk.entries:
            return
        content = b"".join(chunk.parts)
        packed = content if self._zstd is None else self._zstd.compress(content)
        name = "" if self._zstd is None else "zstd"
        crc = zlib.crc32(content) if self._preset.chunk_crc else 0
        first, last = chunk.span
        start = self.size
        record = _encoded(Chunk(name, packed, last, first, crc, len(content)))
        self._put(record)
        offsets, index = {}, b""
        for channel, entries in chunk.entries.items():
            offsets[channel] = self.size + len(index)
            data = entries.tobytes()
            length = 6 + len(data)
            index += _INDEX.pack(Opcode.MESSAGE_INDEX, length, channel, len(data)) + data
        entry = ChunkIndex(
            chunk_length=len(record),
            chunk_start_offset=start,
            compression=name,
            compressed_size=len(packed),
            message_end_time=last,
            message_index_length=len(index),
            message_index_offsets=offsets,
            message_start_time=first,
            uncompressed_size=len(content),
        )
        self._chunks += _encoded(entry)
        self._chunk_count += 1
        self._put(index)
        self._chunk = _Chunk()

    def _put_summary(self) -> None:
        """Write the summary section and the footer."""
        start, data, offsets = self.size, b"", b""
        groups = (
            (Opcode.SCHEMA, _all_encoded(self._schemas)),
            (Opcode.CHANNEL, _all_encoded(self._channels)),
            (Opcode.STATISTICS, _encoded(self._statistics())),
            (Opcode.CHUNK_INDEX, bytes(self._chunks)),
            (Opcode.METADATA_INDEX, _all_encoded(self._metadata)),
        )
        for opcode, group in groups:
            if group:
                offsets += _encoded(SummaryOffset(opcode, start + len(data), len(group)))
            data += group
        offset_start = start + len(data)
        data += offsets
        crc = 0
        if self._preset.summary_crc:
            head = _FOOTER_HEAD.pack(Opcode.FOOTER, 20, start, offset_start)
            crc = zlib.crc32(head, zlib.crc32(data))
        self._put(data + _encoded(Footer(start, offset_start, crc)) + _MAGIC)

    def _statistics(self) -> Statistics:
        """Return what the file holds, in numbers."""
        return Statistics(
            attachment_count=0,
            channel_count=len(self._channels),
            channel_message_counts=dict(enumerate(self._counts[1:], start=1)),
            chunk_count=self._chunk_count,
            message_count=sum(self._counts),
            message_end_time=self._span[1],
            message_start_time=self._span[0],
            metadata_count=len(self._metadata),
            schema_count=len(self._schemas),
        )

    def _put(self, data: bytes) -> None:
        """Append bytes to the file."""
        self._file.write(data)
        self.size += len(data)


class _Chunk:
    """The records that wait to be written together.

    Attributes:
        parts: their bytes.
        size: sum of their lengths.
        entries: log time and offset of each message, alternating, by channel.
        span: first and last log time [ns].
    """

    def __init__(self) -> None:
        """Start empty."""
        self.parts: list[bytes] = []
        self.size = 0
        self.entries: dict[int, array[int]] = {}
        self.span = (0, 0)
        self._begun = 0.0

    def define(self, data: bytes) -> None:
        """Append a schema or channel."""
        self.parts.append(data)
        self.size += len(data)

    def add(self, channel: int, log_time: int, head: bytes, data: bytes) -> None:
        """Append a message."""
        if not self.entries:
            self.span = (log_time, log_time)
            self._begun = time.monotonic()
        elif not self.span[0] <= log_time <= self.span[1]:
            self.span = (min(self.span[0], log_time), max(self.span[1], log_time))
        entries = self.entries.get(channel)
        if entries is None:
            entries = self.entries[channel] = array("Q")
        entries.append(log_time)
        entries.append(self.size)
        self.parts.append(head)
        self.parts.append(data)
        self.size += len(head) + len(data)

    def age(self) -> float:
        """Return the wall time since the first message [s]."""
        return time.monotonic() - self._begun


def _encoded(record: McapRecord) -> bytes:
    """Return a record's bytes."""
    builder = RecordBuilder()
    record.write(builder)
    return bytes(builder.end())


def _all_encoded(records: Iterable[McapRecord]) -> bytes:
    """Return the bytes of records, one after another."""
    return b"".join(map(_encoded, records))
