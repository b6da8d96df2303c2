"""A client of Foxglove's server: what the application is to it, as far as tests need."""

from __future__ import annotations

import json
import struct

from websockets.sync.client import connect


class Client:
    """What the application is to the server: subscribes, and keeps what comes."""

    def __init__(self, url):
        self.socket = connect(url, subprotocols=["foxglove.sdk.v1"], max_size=None)
        self.channels, self.heard, self.times, self.assets, self.info = {}, [], [], {}, {}

    def subscribe(self, topic, number=1):
        channel = self.channels[topic]["id"]
        asked = [{"id": number, "channelId": channel}]
        self.socket.send(json.dumps({"op": "subscribe", "subscriptions": asked}))

    def fetch(self, uri, number):
        self.socket.send(json.dumps({"op": "fetchAsset", "uri": uri, "requestId": number}))

    def take(self):
        """Take what has come."""
        while True:
            try:
                message = self.socket.recv(timeout=0.01)
            except TimeoutError:
                return
            if isinstance(message, str):
                content = json.loads(message)
                if content["op"] == "advertise":
                    self.channels |= {c["topic"]: c for c in content["channels"]}
                elif content["op"] == "serverInfo":
                    self.info = content
            elif message[0] == 1:
                number, stamp = struct.unpack_from("<IQ", message, 1)
                self.heard.append((number, stamp, message[13:]))
            elif message[0] == 2:
                self.times.append(struct.unpack_from("<Q", message, 1)[0])
            elif message[0] == 4:
                number, status, length = struct.unpack_from("<IBI", message, 1)
                self.assets[number] = (status, message[10 + length :])

    def close(self):
        self.socket.close()
