"""The web server of the live page: this machine alone, this page alone.

It listens on 127.0.0.1. A page of another site can reach that address too, so every request must
name us as its host (against DNS rebinding), and an order must come from our own page (Origin) as
JSON, which no foreign form can send.
"""

from __future__ import annotations

import json
import select
from collections.abc import Callable
from concurrent.futures import TimeoutError as NoAnswerError
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from threading import Thread

from lexstack.errors import InputError
from lexstack_ros.view.hub import Hub
from lexstack_ros.view.orders import Order

HOST = "127.0.0.1"
_MOST_BYTES = 4096  # of an order
_MOST_LISTENERS = 8
_STILL_HERE = 2.0  # s without news after which a listener is told that we live
_ANSWER = 10.0  # s that an order may take
_TIMEOUT = 10.0  # s for a request to come in whole
_HEADERS = {
    "Cache-Control": "no-store",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
}


class ViewError(Exception):
    """An order could not be carried out; the text says why."""


class ViewServer:
    """Serves ``/``, ``/events`` and ``/order`` from threads of its own.

    Attributes:
        url: where.
    """

    def __init__(self, page: str, hub: Hub, read: Callable[[bytes], Order]) -> None:
        """Serve from now on.

        Args:
            page: HTML.
            hub: where news come from and orders go to.
            read: makes an order of a request's body; raises InputError.
        """
        self._server = _Server((HOST, 0), _Handler)
        self._server.page, self._server.hub, self._server.read = page.encode(), hub, read
        self.url = f"http://{HOST}:{self._server.server_port}/"
        Thread(target=self._server.serve_forever, name="view-server", daemon=True).start()

    def close(self) -> None:
        """End; listeners are sent away by the hub."""
        self._server.shutdown()
        self._server.server_close()


class _Server(ThreadingHTTPServer):
    """What the handlers share."""

    daemon_threads = True
    block_on_close = False
    page: bytes
    hub: Hub
    read: Callable[[bytes], Order]


class _Handler(BaseHTTPRequestHandler):
    """One request."""

    server: _Server
    timeout = _TIMEOUT
    protocol_version = "HTTP/1.1"
    server_version, sys_version = "lexstack", ""

    def do_GET(self) -> None:
        """Serve the page or the events."""
        if not self._is_ours():
            return
        if self.path == "/":
            self._send(HTTPStatus.OK, self.server.page, "text/html; charset=utf-8")
        elif self.path == "/events":
            self._events()
        else:
            self._say(HTTPStatus.NOT_FOUND, "no such page")

    def do_POST(self) -> None:
        """Take an order."""
        if not self._is_ours() or not self._is_own_page():
            return
        length = self.headers.get("Content-Length", "")
        if not length.isdecimal() or int(length) > _MOST_BYTES:
            self._refuse(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, f"at most {_MOST_BYTES} bytes")
            return
        body = self.rfile.read(int(length))
        if self.path != "/order":
            self._say(HTTPStatus.NOT_FOUND, "no such page")
            return
        try:
            answer = self.server.hub.order(self.server.read(body)).result(_ANSWER)
        except InputError as error:
            self._say(HTTPStatus.BAD_REQUEST, str(error))
        except ViewError as error:
            self._say(HTTPStatus.CONFLICT, str(error))
        except NoAnswerError:
            self._say(HTTPStatus.GATEWAY_TIMEOUT, f"no answer in {_ANSWER:g} s")
        else:
            self._say(HTTPStatus.OK, answer)

    def log_message(self, format: str, *arguments: object) -> None:  # noqa: A002 - its name there
        """Say nothing: refusals are answered, the rest is the browser's."""

    def _is_ours(self) -> bool:
        """Return whether the request means this server; answer it where not."""
        port = self.server.server_port
        if self.headers.get("Host") in (f"{HOST}:{port}", f"localhost:{port}"):
            return True
        self._refuse(HTTPStatus.FORBIDDEN, "wrong host")
        return False

    def _is_own_page(self) -> bool:
        """Return whether an order comes from our page as JSON; answer it where not."""
        if self.headers.get("Origin") != f"http://{self.headers['Host']}":
            self._refuse(HTTPStatus.FORBIDDEN, "orders come from this page alone")
            return False
        kind = self.headers.get("Content-Type", "").partition(";")[0].strip().lower()
        if kind != "application/json":
            self._refuse(HTTPStatus.UNSUPPORTED_MEDIA_TYPE, "expected application/json")
            return False
        return True

    def _events(self) -> None:
        """Send news for as long as the browser listens."""
        hub = self.server.hub
        number = hub.listen(_MOST_LISTENERS)
        if number is None:
            self._refuse(HTTPStatus.SERVICE_UNAVAILABLE, f"{_MOST_LISTENERS} pages are open")
            return
        try:
            self.close_connection = True
            self._head(HTTPStatus.OK, "text/event-stream", None)
            while not self._has_gone() and (news := hub.wait(number, _STILL_HERE)) is not None:
                number, text = news
                self.wfile.write(f"data: {text}\n\n".encode() if text else b": here\n\n")
        except OSError:
            pass  # the browser has gone
        finally:
            hub.leave()

    def _has_gone(self) -> bool:
        """Return whether a listener has hung up: it says nothing else."""
        return bool(select.select([self.connection], [], [], 0)[0])

    def _refuse(self, status: HTTPStatus, text: str) -> None:
        """Answer without having read the body: the connection cannot be used again."""
        self.close_connection = True
        self._say(status, text)

    def _say(self, status: HTTPStatus, text: str) -> None:
        """Answer in JSON."""
        content = json.dumps({"ok": status == HTTPStatus.OK, "message": text}).encode()
        self._send(status, content, "application/json")

    def _send(self, status: HTTPStatus, content: bytes, kind: str) -> None:
        """Answer."""
        self._head(status, kind, len(content))
        self.wfile.write(content)

    def _head(self, status: HTTPStatus, kind: str, length: int | None) -> None:
        """Send status and headers."""
        self.send_response(status)
        self.send_header("Content-Type", kind)
        if length is not None:
            self.send_header("Content-Length", str(length))
        if self.close_connection:
            self.send_header("Connection", "close")
        for name, value in _HEADERS.items():
            self.send_header(name, value)
        self.end_headers()
