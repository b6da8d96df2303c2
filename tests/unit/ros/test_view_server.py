"""The live page's server: its own page may look and ask, nobody else."""

from __future__ import annotations

import http.client
import json
import socket
from functools import partial
from threading import Thread

import pytest

from lexstack_ros.view.hub import Hub
from lexstack_ros.view.orders import Switch, read_order
from lexstack_ros.view.server import HOST, ViewError, ViewServer

ORDER = {"do": "switch", "stack": "track", "duration": 1.0}


class Node:
    """Stands for the node: answers orders until it is closed."""

    def __init__(self):
        self.hub, self.taken, self.open = Hub(), [], True
        read = partial(read_order, robots=("robot_a",), stacks=("track", "posture"))
        self.server = ViewServer("<p>page</p>", self.hub, read)
        self.port = int(self.server.url.rsplit(":", 1)[1].strip("/"))
        self.thread = Thread(target=self.work)
        self.thread.start()

    def work(self):
        import time

        while self.open:
            while (entry := self.hub.take()) is not None:
                order, answer = entry
                self.taken.append(order)
                if order == Switch("posture", 1.0):
                    answer.set_exception(ViewError("refused: no such way"))
                else:
                    answer.set_result("accepted")
            time.sleep(0.005)

    def close(self):
        self.open = False
        self.thread.join()
        self.hub.close()
        self.server.close()

    def ask(self, method="POST", path="/order", body=None, **headers):
        """Return status and body of a request; a header given as None is left out."""
        connection = http.client.HTTPConnection(HOST, self.port, timeout=10)
        defaults = {"Origin": f"http://{HOST}:{self.port}", "Content-Type": "application/json"}
        given = {k.replace("_", "-"): v for k, v in headers.items()}
        sent = {k: v for k, v in (defaults | given).items() if v is not None}
        text = json.dumps(ORDER if body is None else body) if not isinstance(body, bytes) else body
        connection.request(method, path, text if method == "POST" else None, sent)
        response = connection.getresponse()
        return response.status, response.read().decode()


@pytest.fixture
def node():
    node = Node()
    yield node
    node.close()


def test_the_page_is_served_with_guards(node):
    connection = http.client.HTTPConnection(HOST, node.port, timeout=10)
    connection.request("GET", "/")
    response = connection.getresponse()
    assert (response.status, response.read()) == (200, b"<p>page</p>")
    assert response.headers["X-Frame-Options"] == "DENY"
    assert response.headers["Cache-Control"] == "no-store"
    assert "Access-Control-Allow-Origin" not in response.headers


def test_it_listens_on_this_machine_alone(node):
    assert HOST == "127.0.0.1"
    assert node.server.url.startswith(f"http://{HOST}:")
    with pytest.raises(OSError, match="refused"):
        socket.create_connection(("127.0.0.2", node.port), timeout=2)


def test_an_order_of_the_own_page_is_carried_out(node):
    assert node.ask() == (200, '{"ok": true, "message": "accepted"}')
    assert node.taken == [Switch("track", 1.0)]


def test_a_refusal_comes_back_with_its_reason(node):
    status, text = node.ask(body={"do": "switch", "stack": "posture", "duration": 1.0})
    assert (status, json.loads(text)["message"]) == (409, "refused: no such way")


@pytest.mark.parametrize(
    ("headers", "status"),
    [
        ({"Origin": None}, 403),
        ({"Origin": "http://evil.example"}, 403),
        ({"Origin": "null"}, 403),
        ({"Origin": f"http://{HOST}:1"}, 403),
        ({"Host": "evil.example"}, 403),
        ({"Host": "evil.example", "Origin": "http://evil.example"}, 403),
        ({"Content_Type": None}, 415),
        ({"Content_Type": "text/plain"}, 415),
        ({"Content_Type": "application/x-www-form-urlencoded"}, 415),
        ({"Content_Length": "5000"}, 413),
        ({"Content_Length": "-1"}, 413),
        ({"Content_Length": "x"}, 413),
    ],
)
def test_an_order_from_elsewhere_is_refused(node, headers, status):
    assert node.ask(**headers)[0] == status
    assert node.taken == []


def test_nobody_else_reads_page_or_events(node):
    for path in ("/", "/events"):
        assert node.ask("GET", path, Host="evil.example")[0] == 403


@pytest.mark.parametrize(("method", "path"), [("GET", "/x"), ("GET", "/../etc"), ("POST", "/")])
def test_there_is_nothing_else(node, method, path):
    assert node.ask(method, path)[0] == 404


def test_what_is_no_order_is_answered(node):
    status, text = node.ask(body=b"{")
    assert status == 400
    assert "not JSON" in json.loads(text)["message"]
    assert node.ask(body={"do": "switch", "stack": "x", "duration": 1})[0] == 400
    assert node.taken == []


def listen(node):
    connection = http.client.HTTPConnection(HOST, node.port, timeout=10)
    connection.request("GET", "/events")
    return connection.getresponse()


def until(condition):
    import time

    end = time.monotonic() + 10
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.01)


def test_news_come_as_events_and_a_slow_listener_gets_the_newest(node):
    events = listen(node)
    assert events.headers["Content-Type"] == "text/event-stream"
    until(lambda: node.hub.is_watched)
    node.hub.publish('{"tick": 1}')
    assert events.readline() == b'data: {"tick": 1}\n'
    assert events.readline() == b"\n"
    number, text = node.hub.wait(0, 0.0)
    assert (number, text) == (1, '{"tick": 1}')
    for tick in range(2, 9):
        node.hub.publish(f'{{"tick": {tick}}}')
    assert node.hub.wait(1, 0.0) == (8, '{"tick": 8}')


def test_a_listener_that_goes_is_noticed(node):
    events = listen(node)
    until(lambda: node.hub.is_watched)
    events.close()

    def gone():
        node.hub.publish("{}")
        return not node.hub.is_watched

    until(gone)


def test_there_is_an_end_to_how_many_listen(node):
    crowd = [listen(node) for _ in range(8)]
    assert all(one.status == 200 for one in crowd)
    assert listen(node).status == 503


def test_the_end_sends_listeners_away():
    node = Node()
    events = listen(node)
    until(lambda: node.hub.is_watched)
    node.close()
    assert events.read() in (b"", b": here\n\n")
