"""The page's web server: this machine alone, this page alone.

viser listens on 127.0.0.1. A page of another site can reach that address too, so every request
must name us as its host (against DNS rebinding), and a WebSocket, which carries all commands, must
be opened by our own page (Origin). viser 1.1 has no option for that; it serves through websockets,
whose ``process_request`` sees every request first, and there stands the guard.
"""

from __future__ import annotations

import contextlib
import io
from collections.abc import Callable, Iterator
from http import HTTPStatus
from typing import Any

import viser
from websockets.asyncio import server as websockets_server
from websockets.asyncio.server import ServerConnection
from websockets.datastructures import Headers
from websockets.http11 import Request, Response

HOST = "127.0.0.1"
_MOST_PAGES = 8
_MOST_BYTES = 1 << 20  # of a message from a browser: no button needs more
_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval' blob:; "
    "style-src 'unsafe-inline'; img-src 'self' data: blob:; font-src data:; "
    "connect-src 'self' ws://{host} data: blob:; worker-src blob:; "
    "frame-ancestors 'none'; base-uri 'none'; form-action 'none'"
)
_HEADERS = {
    "Cache-Control": "no-store",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
}
Answer = Callable[[ServerConnection, Request], Response | None]


class PageServer(viser.ViserServer):
    """viser's server behind the guard.

    Attributes:
        url: where.
    """

    def __init__(self, label: str) -> None:
        """Serve from now on, on any free port; ``label`` is the title of the panel.

        Raises:
            RuntimeError: viser has been served without the guard, as another version may.
        """
        with _guarding() as guards, contextlib.redirect_stdout(io.StringIO()):
            super().__init__(host=HOST, port=0, label=label, verbose=False)
        if len(guards) != 1:
            self.stop()
            raise RuntimeError("this version of viser cannot be guarded")
        self.url = f"http://{HOST}:{self.get_port()}/"

    def request_share_url(self, verbose: bool = True) -> str | None:
        """Refuse: a browser may ask viser for a tunnel through a server of its authors."""
        return None

    def close(self) -> None:
        """Send the browsers away, and end."""
        with contextlib.redirect_stdout(io.StringIO()):
            self.stop()


@contextlib.contextmanager
def _guarding() -> Iterator[list[Answer]]:
    """Let every websockets server that is made meanwhile ask the guard first; yields the guards."""
    original = websockets_server.serve
    guards: list[Answer] = []

    def serve(*arguments: Any, process_request: Answer, **options: Any) -> Any:
        guards.append(guarded(process_request))
        options["max_size"] = _MOST_BYTES
        return original(*arguments, process_request=guards[-1], **options)

    websockets_server.serve = serve  # type: ignore[assignment,misc]
    try:
        yield guards
    finally:
        websockets_server.serve = original  # type: ignore[misc]


def guarded(answer: Answer) -> Answer:
    """Return what answers a request as ``answer`` does, if it may be answered."""

    def answered(connection: ServerConnection, request: Request) -> Response | None:
        hosts = request.headers.get_all("Host")
        port = connection.local_address[1]
        if hosts not in ([f"{HOST}:{port}"], [f"localhost:{port}"]):
            return _refusal("wrong host")
        response = answer(connection, request)
        if response is not None:
            for name, value in _HEADERS.items():
                response.headers[name] = value
            response.headers["Content-Security-Policy"] = _POLICY.format(host=hosts[0])
            return response
        # None: the connection becomes a WebSocket.
        if request.headers.get_all("Origin") != [f"http://{hosts[0]}"]:
            return _refusal("commands come from this page alone")
        if len(connection.server.connections) >= _MOST_PAGES:
            return _refusal(f"{_MOST_PAGES} pages are open", HTTPStatus.SERVICE_UNAVAILABLE)
        return None

    return answered


def _refusal(reason: str, status: HTTPStatus = HTTPStatus.FORBIDDEN) -> Response:
    """Return an answer that ends the connection."""
    body = reason.encode()
    headers = Headers(_HEADERS | {"Content-Length": str(len(body)), "Connection": "close"})
    return Response(status.value, status.phrase, headers, body)
