"""The page's web server: who may read, who may command, and what browsers are told."""

from __future__ import annotations

import http.client
import socket

import pytest
import viser
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from lexstack_ros.view.page.server import HOST, PageServer

OTHER = "localhost"  # another name of this machine
PROTOCOL = f"viser-v{viser.__version__}"


@pytest.fixture(scope="module")
def page():
    server = PageServer("title")
    yield server
    server.close()


def get(page, path="/", **headers):
    """Return status, headers and body; a header given as a list is sent that many times."""
    connection = http.client.HTTPConnection(HOST, page.get_port(), timeout=10)
    connection.putrequest("GET", path, skip_host="Host" in headers)
    for name, values in headers.items():
        for value in values if isinstance(values, list) else [values]:
            connection.putheader(name, value)
    connection.endheaders()
    response = connection.getresponse()
    return response.status, response.headers, response.read()


def open_socket(page, **headers):
    """Open a WebSocket as viser's client does, from a page with this origin."""
    given = {"origin": f"http://{HOST}:{page.get_port()}"} | headers
    port = page.get_port()
    return connect(f"ws://{HOST}:{port}/", subprotocols=[PROTOCOL], max_size=None, **given)


def read_on(own):
    while True:
        own.recv(timeout=10)


def test_the_page_is_served_with_guards(page):
    status, headers, body = get(page)
    assert status == 200
    assert b"<html" in body
    assert headers["X-Frame-Options"] == "DENY"
    assert headers["Cache-Control"] == "no-store"
    assert "frame-ancestors 'none'" in headers["Content-Security-Policy"]
    assert "Access-Control-Allow-Origin" not in headers


def test_it_listens_on_this_machine_alone(page):
    assert page.url == f"http://{HOST}:{page.get_port()}/"
    with pytest.raises(OSError, match="refused"):
        socket.create_connection(("127.0.0.2", page.get_port()), timeout=2)


@pytest.mark.parametrize("name", [HOST, OTHER])
def test_both_names_of_this_machine_are_served(page, name):
    assert get(page, Host=f"{name}:{page.get_port()}")[0] == 200


@pytest.mark.parametrize(
    "host", ["evil.example", "evil.example:{port}", "127.0.0.1", "127.0.0.1:1"]
)
def test_another_host_is_refused(page, host):
    host = host.format(port=page.get_port())
    assert get(page, Host=host)[0] == 403
    with pytest.raises(InvalidStatus, match="403"):
        open_socket(page, additional_headers={"X": "y"}, origin=f"http://{host}")


def test_two_hosts_are_refused(page):
    own = f"{HOST}:{page.get_port()}"
    assert get(page, Host=[own, "evil.example"])[0] == 403


def test_the_own_page_is_heard(page):
    with open_socket(page) as own:
        assert own.recv(timeout=10)


@pytest.mark.parametrize(
    "origin",
    [None, "null", "http://evil.example", f"https://{HOST}:{{port}}", f"http://{HOST}:1",
     f"http://{OTHER}:{{port}}"],
)  # fmt: skip
def test_a_foreign_page_commands_nothing(page, origin):
    origin = None if origin is None else origin.format(port=page.get_port())
    with pytest.raises(InvalidStatus, match="403"):
        open_socket(page, origin=origin)


@pytest.mark.parametrize("upgrade", ["websocket", "WebSocket", "h2c"])
def test_an_upgrade_by_hand_is_a_websocket_or_the_page(page, upgrade):
    status, *_ = get(page, Upgrade=upgrade, Connection="Upgrade")
    assert status == (403 if upgrade == "websocket" else 200)


@pytest.mark.parametrize("path", ["/x", "/../etc/passwd", "/%2e%2e/%2e%2e/_viser.py", "//etc"])
def test_there_is_nothing_else(page, path):
    assert get(page, path)[0] == 404


def test_a_browser_opens_no_tunnel_to_elsewhere(page):
    assert page.request_share_url() is None
    assert page._share_tunnel is None


def test_a_large_message_ends_the_connection(page):
    with open_socket(page) as own:
        own.send(bytes(2 << 20))
        with pytest.raises(ConnectionClosed):
            read_on(own)


def test_there_is_an_end_to_how_many_look():
    server = PageServer("title")
    crowd = [open_socket(server) for _ in range(8)]
    with pytest.raises(InvalidStatus, match="503"):
        open_socket(server)
    crowd.pop().close()
    crowd.append(open_socket(server))
    for one in crowd:
        one.close()
    server.close()


def test_a_viser_that_cannot_be_guarded_is_not_served(monkeypatch):
    from websockets.asyncio import server as websockets_server

    from lexstack_ros.view.page import server

    original = websockets_server.serve

    def put_back():  # as if another version of viser took its server from elsewhere
        websockets_server.serve = original

    monkeypatch.setattr(viser._viser._client_autobuild, "ensure_client_is_built", put_back)
    with pytest.raises(RuntimeError, match="cannot be guarded"):
        server.PageServer("title")


def test_the_end_sends_browsers_away():
    server = PageServer("title")
    with open_socket(server) as own:
        own.recv(timeout=10)
        server.close()
        with pytest.raises(ConnectionClosed):
            read_on(own)
