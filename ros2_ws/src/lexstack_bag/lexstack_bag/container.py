"""Bags as files: finds them and streams their records, a chunk in memory at a time."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from mcap.exceptions import EndOfFile, McapError
from mcap.records import Channel, McapRecord, Message, Metadata, Schema
from mcap.stream_reader import StreamReader
from zstandard import ZstdError

from lexstack_bag.errors import BagError


@dataclass(frozen=True, slots=True)
class RawMessage:
    """One message as it lies in a bag."""

    topic: str
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
    """

    def __init__(self, files: list[Path]) -> None:
        """Take the files of a bag; nothing is read yet."""
        self.files = files
        self.metadata: dict[str, dict[str, str]] = {}
        self.complete = True

    def messages(self) -> Iterator[RawMessage]:
        """Yield every message; raises BagError for what is not a bag or is damaged."""
        for path in self.files:
            schemas: dict[int, Schema] = {}
            channels: dict[int, Channel] = {}
            for record in self._records(path):
                if isinstance(record, Message):
                    channel = channels[record.channel_id]
                    yield RawMessage(
                        channel.topic,
                        schemas[channel.schema_id],
                        record.data,
                        record.log_time,
                        record.publish_time,
                        record.sequence,
                    )
                elif isinstance(record, Schema):
                    schemas[record.id] = record
                elif isinstance(record, Channel):
                    channels[record.id] = record
                elif isinstance(record, Metadata):
                    self.metadata[record.name] = record.metadata

    def _records(self, path: Path) -> Iterator[McapRecord]:
        """Yield one file's records; a file that was cut off just ends."""
        seen = 0
        try:
            with path.open("rb") as stream:
                for record in StreamReader(stream, validate_crcs=True).records:
                    seen += 1
                    yield record
        except OSError as error:
            raise BagError(f"{path}: cannot be read: {error.strerror}") from error
        except (EndOfFile, struct.error) as error:
            if not seen:
                raise BagError(f"{path}: not an MCAP file, or empty") from error
            self.complete = False
        except (McapError, ValueError, KeyError, ZstdError) as error:
            raise BagError(f"{path}: not a readable MCAP file: {error}") from error
