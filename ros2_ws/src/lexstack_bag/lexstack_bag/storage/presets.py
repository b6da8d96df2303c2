"""How a bag is stored: rosbag2's storage presets for MCAP, and when a file is split."""

from __future__ import annotations

from dataclasses import dataclass

from lexstack_bag.errors import BagError

SMALLEST_SPLIT = 1024  # bytes, rosbag2's least
_KB, _MB = 1024, 1024 * 1024


@dataclass(frozen=True, slots=True)
class Preset:
    """How messages become chunks of a file.

    Attributes:
        chunk_bytes: a chunk is complete with so much content; 0: no chunks, messages one by one.
        level: of zstd; None: not compressed.
        chunk_crc: whether each chunk carries a checksum.
        summary_crc: whether the summary at the end carries one.
        hold: a chunk is complete at the latest so long after its first message [s of wall time]:
            what a killed recorder takes with it.
    """

    chunk_bytes: int
    level: int | None
    chunk_crc: bool = False
    summary_crc: bool = True
    hold: float = 1.0


DEFAULT_PRESET = "default"

# Chunks and checksums of the four names of rosbag2 are as rosbag2_storage_mcap sets them, levels
# as libmcap names them: "Fastest" is -5, "Slowest" 19. `hold` is ours: rosbag2 does not limit it.
PRESETS: dict[str, Preset] = {
    DEFAULT_PRESET: Preset(256 * _KB, level=1, chunk_crc=True),
    "none": Preset(768 * _KB, level=None),
    "fastwrite": Preset(0, level=None, summary_crc=False),
    "zstd_fast": Preset(768 * _KB, level=-5),
    "zstd_small": Preset(4 * _MB, level=19, chunk_crc=True, hold=10.0),
}


@dataclass(frozen=True, slots=True)
class Storage:
    """What a user chooses about a bag's files.

    Attributes:
        preset: a key of PRESETS.
        max_bag_size: bytes on the disk after which the next file begins; 0: no such limit.
        max_bag_duration: seconds of log time after which the next file begins; 0: no such limit.
    """

    preset: str = DEFAULT_PRESET
    max_bag_size: int = 0
    max_bag_duration: float = 0.0

    def __post_init__(self) -> None:
        """Raise BagError for a value that makes no sense."""
        if self.preset not in PRESETS:
            raise BagError(f"unknown storage preset {self.preset!r}; known: {', '.join(PRESETS)}")
        if self.max_bag_size and self.max_bag_size < SMALLEST_SPLIT:
            raise BagError(
                f"max_bag_size: must be 0 (no split) or at least {SMALLEST_SPLIT} bytes, "
                f"got {self.max_bag_size}"
            )
        if not 0.0 <= self.max_bag_duration < float("inf"):
            raise BagError(
                "max_bag_duration: must be 0 (no split) or a time in seconds, "
                f"got {self.max_bag_duration}"
            )

    def is_full(self, size: int, duration: float) -> bool:
        """Return whether the next message goes to a new file, by rosbag2's rule.

        Args:
            size: of the present file on the disk [bytes].
            duration: from its first message to the next one [s of log time].
        """
        return bool(self.max_bag_size and size >= self.max_bag_size) or bool(
            self.max_bag_duration and duration > self.max_bag_duration
        )
