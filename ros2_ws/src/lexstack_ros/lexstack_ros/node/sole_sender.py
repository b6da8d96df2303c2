"""Who sent a message: a name in it, and one sender of a kind is believed at a time.

ROS tells a subscriber nothing of the publisher, so states and solutions carry their sender. The
name is no proof: it keeps accidents out (a second controller, a bag that is played into a live
run), not attackers. Against those, see docs/deployment.md.
"""

from __future__ import annotations

import os
import secrets
import socket
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rclpy.node import Node

from lexstack.errors import InputError, LexstackError

_LONGEST = 200  # characters


class AlreadyCommandedError(LexstackError):
    """Another process commands the robots; the text names it."""


def sender_name(node: Node) -> str:
    """Return the name of this process for its messages: node@host/process/token."""
    return f"{node.get_name()}@{socket.gethostname()}/{os.getpid()}/{secrets.token_hex(4)}"


class SoleSender:
    """Believes the first sender, and another one only after the first has been silent.

    Attributes:
        name: who is believed; empty: nobody yet.
    """

    def __init__(
        self,
        where: str,
        silence: float = float("inf"),
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Make one for the topic ``where``; after ``silence`` [s of ``clock``] the place is free.

        ``clock`` is monotonic.
        """
        self.name = ""
        self._where = where
        self._silence = silence
        self._clock = clock
        self._heard = 0.0

    def check(self, sender: str) -> None:
        """Raise InputError unless ``sender`` is, or may become, the one that is believed."""
        if not 0 < len(sender) <= _LONGEST or not sender.isprintable():
            raise InputError(
                f"{self._where}: sender: expected 1 to {_LONGEST} printable characters, "
                f"got {len(sender)}"
            )
        if self.name and sender != self.name and self._clock() - self._heard < self._silence:
            raise InputError(
                f"{self._where}: sender: {sender} is not {self.name}, which was there first"
            )

    def follow(self, sender: str) -> None:
        """Believe ``sender`` from now on; its silence begins now."""
        self.name = sender
        self._heard = self._clock()

    @contextmanager
    def believing(self, sender: str) -> Iterator[None]:
        """Follow ``sender`` within, and on unless the block refuses its message; raises InputError.

        Who is believed within stands in what the block sends.
        """
        self.check(sender)
        before = self.name, self._heard
        self.follow(sender)
        try:
            yield
        except InputError:
            self.name, self._heard = before
            raise

    def release(self) -> None:
        """Let the next sender be the one."""
        self.name = ""
