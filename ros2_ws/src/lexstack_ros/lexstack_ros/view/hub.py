"""Between the node's one thread and the web server's: the newest picture, and orders with answers.

The node never waits for a browser: it leaves the newest text here, and takes orders when it looks.
"""

from __future__ import annotations

from concurrent.futures import Future
from queue import Empty, SimpleQueue
from threading import Condition

from lexstack_ros.view.orders import Order


class Hub:
    """Thread-safe; one node, any number of listeners."""

    def __init__(self) -> None:
        """Start without a text."""
        self._changed = Condition()
        self._number = 0
        self._text = ""
        self._listeners = 0
        self._closed = False
        self._orders: SimpleQueue[tuple[Order, Future[str]]] = SimpleQueue()

    # ---- for the node

    @property
    def is_watched(self) -> bool:
        """Whether anybody listens: else nothing needs to be made."""
        return self._listeners > 0

    def publish(self, text: str) -> None:
        """Give all listeners a new text; who was slow never gets the old one."""
        with self._changed:
            self._number += 1
            self._text = text
            self._changed.notify_all()

    def take(self) -> tuple[Order, Future[str]] | None:
        """Return the next order and where its answer goes, or None."""
        try:
            return self._orders.get_nowait()
        except Empty:
            return None

    def close(self) -> None:
        """Send all listeners away."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()

    # ---- for the server

    def order(self, order: Order) -> Future[str]:
        """Hand an order on; the answer is text, or a ViewError."""
        answer: Future[str] = Future()
        self._orders.put((order, answer))
        return answer

    def listen(self, most: int) -> int | None:
        """Count one more listener; None where there are ``most`` already.

        Returns:
            the number of the present text: what stood here before anybody listened is old.
        """
        with self._changed:
            if self._listeners >= most:
                return None
            self._listeners += 1
            return self._number

    def leave(self) -> None:
        """Count one listener less."""
        with self._changed:
            self._listeners -= 1

    def wait(self, seen: int, timeout: float) -> tuple[int, str] | None:
        """Return the number and text after number ``seen``.

        Returns:
            the same number and an empty text when nothing new came within ``timeout`` s; None
            when all is over.
        """
        with self._changed:
            self._changed.wait_for(lambda: self._closed or self._number > seen, timeout)
            if self._closed:
                return None
            return (self._number, self._text) if self._number > seen else (seen, "")
