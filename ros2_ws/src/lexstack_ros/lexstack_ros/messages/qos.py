"""The quality of service of every topic: reliable, and deep enough to lose nothing."""

from __future__ import annotations

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy


def _reliable(depth: int, durability: DurabilityPolicy = DurabilityPolicy.VOLATILE) -> QoSProfile:
    """Return a profile that keeps the last messages."""
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=depth,
        reliability=ReliabilityPolicy.RELIABLE,
        durability=durability,
    )


# Depth 1 loses a third at 1 kHz, depth 10 nothing; more covers a stall of half a second.
STREAM = _reliable(50)

# Requests may come in bursts while a tick is computed: a request that is lost is never answered.
SERVICE = _reliable(1000)

# For what a process that comes later must know: descriptions, requests to a source.
LATCHED = _reliable(64, DurabilityPolicy.TRANSIENT_LOCAL)

# For what replaces all that was said before: a process that comes later hears the newest alone,
# and cannot act on an old value for a moment.
LATEST = _reliable(1, DurabilityPolicy.TRANSIENT_LOCAL)

# As tf2 has them.
TRANSFORMS = _reliable(100)
STATIC_TRANSFORMS = _reliable(100, DurabilityPolicy.TRANSIENT_LOCAL)
