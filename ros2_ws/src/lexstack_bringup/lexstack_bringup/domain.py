"""A ROS_DOMAIN_ID for one run, so that two runs on one machine do not meet."""

from __future__ import annotations

import fcntl
import os
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from lexstack.errors import LexstackError
from lexstack_bringup.shared_memory import remove_abandoned

_IDS = range(1, 101)  # Linux has no trouble with the ports of these


class NoDomainError(LexstackError):
    """No ROS_DOMAIN_ID is free, or the given one is wrong."""


@contextmanager
def own_domain(numbers: Sequence[int] = _IDS) -> Iterator[int]:
    """Yield the environment's ROS_DOMAIN_ID, or one that no other run has while this one lasts.

    ``numbers`` are tried in their order. At the end, when all processes of the run have ended,
    shared memory that killed ones left goes.
    """
    with _domain(numbers) as domain:
        try:
            yield domain
        finally:
            remove_abandoned()


@contextmanager
def _domain(numbers: Sequence[int]) -> Iterator[int]:
    """Yield the environment's ROS_DOMAIN_ID, or one that no other run has."""
    given = os.environ.get("ROS_DOMAIN_ID")
    if given is not None:
        if not given.isdecimal() or int(given) > 232:
            raise NoDomainError(f"ROS_DOMAIN_ID: must be a number from 0 to 232, got {given!r}")
        yield int(given)
        return
    folder = Path(tempfile.gettempdir())
    reason = ""
    for number in numbers:
        try:
            # The lock ends with the process, however it ends.
            handle = _locked(folder / f"lexstack-domain-{number}.lock")
        except OSError as error:
            reason = f" ({error.filename or folder}: {error.strerror})"
            continue  # another run has it, or another account's file says nothing about it
        try:
            yield number
        finally:
            os.close(handle)
        return
    raise NoDomainError(
        f"no ROS_DOMAIN_ID from {min(numbers)} to {max(numbers)} is free{reason}; set one yourself"
    )


def _locked(path: Path) -> int:
    """Return a handle that holds the lock of a file; raises OSError where that cannot be had.

    The file is another account's where that one's run made it. Reading is enough for its lock, so
    runs of several accounts do not meet either; to open it for writing, or with O_CREAT in a folder
    that all share, is not allowed.
    """
    plain = os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC
    try:
        handle = os.open(path, plain)
    except FileNotFoundError:
        handle = os.open(path, plain | os.O_CREAT, 0o644)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        os.close(handle)
        raise
    return handle
