"""A bridge that says what a test writes; the test gives it its turns, so nothing waits."""

from __future__ import annotations

import contextlib
import json
import socket
import struct

from websockets.frames import Frame, Opcode
from websockets.server import ServerProtocol

GREETING = {
    "op": "serverInfo",
    "name": "scripted",
    "capabilities": ["clientPublish"],
    "supportedEncodings": ["cdr"],
    "sessionId": "1",
}


class ScriptedBridge:
    """Listens at a port of its own for one client after another.

    Attributes:
        subprotocols: Those that it knows.
        texts: What the client said.
        binaries: What it sent.
        connections: How often it came.
        pings: How many came.
        answers: Whether the bridge reads at all.
    """

    def __init__(self, greeting=GREETING, subprotocols=("foxglove.websocket.v1",)):
        self.greeting, self.subprotocols = greeting, subprotocols
        self.texts, self.binaries = [], []
        self.connections = self.pings = 0
        self.answers = True
        self._listener = socket.create_server(("127.0.0.1", 0))
        self._listener.settimeout(0.0)
        self._client = None
        self._waiting = bytearray()
        self.url = f"ws://127.0.0.1:{self._listener.getsockname()[1]}"

    def turn(self):
        """Accept, read, send; never waits."""
        with contextlib.suppress(BlockingIOError):
            client, _ = self._listener.accept()
            self.hang_up()
            client.settimeout(0.0)
            self._client, self.connections = client, self.connections + 1
            self._protocol = ServerProtocol(subprotocols=self.subprotocols, max_size=None)
        if self._client is None or not self.answers:
            return
        try:
            while data := self._client.recv(1 << 16):
                self._protocol.receive_data(data)
                for event in self._protocol.events_received():
                    self._take(event)
        except BlockingIOError:
            pass
        except OSError:
            self.hang_up()
        self._flush()

    def _take(self, event):
        if not isinstance(event, Frame):
            response = self._protocol.accept(event)
            self._protocol.send_response(response)
            if response.status_code == 101 and self.greeting is not None:
                self.say(self.greeting)
        elif event.opcode is Opcode.PING:
            self.pings += 1
        elif event.opcode is Opcode.TEXT:
            self.texts.append(json.loads(event.data))
        elif event.opcode is Opcode.BINARY:
            self.binaries.append(bytes(event.data))

    def say(self, value):
        """Send a text: an object, or bytes that are no JSON."""
        text = value if isinstance(value, bytes) else json.dumps(value).encode()
        self._protocol.send_text(text)
        self._flush()

    def send(self, data, parts=1):
        """Send a binary message, perhaps in several frames."""
        size = -(-len(data) // parts)
        self._protocol.send_binary(data[:size], fin=parts == 1)
        for part in range(1, parts):
            last = part == parts - 1
            self._protocol.send_continuation(data[part * size : (part + 1) * size], fin=last)
        self._flush()

    def send_raw(self, data):
        """Send bytes that may be no WebSocket."""
        self._waiting += data
        self._flush()

    def data(self, subscription, payload, time_ns=1):
        """A message of a topic."""
        return struct.pack("<BIQ", 1, subscription, time_ns) + payload

    def subscriptions(self):
        """The numbers of the client's subscriptions by channel."""
        return {
            each["channelId"]: each["id"]
            for text in self.texts
            if text["op"] == "subscribe"
            for each in text["subscriptions"]
        }

    def _flush(self):
        self._waiting += b"".join(self._protocol.data_to_send())
        with contextlib.suppress(BlockingIOError):
            while self._waiting and self._client is not None:
                del self._waiting[: self._client.send(self._waiting)]

    def hang_up(self):
        """End the connection."""
        if self._client is not None:
            self._client.close()
        self._client = None
        self._waiting.clear()

    def close(self):
        """End all."""
        self.hang_up()
        self._listener.close()


def channel(number, topic, **more):
    """A channel as a bridge describes it."""
    kind = {"encoding": "cdr", "schemaName": "std_msgs/msg/String", "schema": "string data\n"}
    return {"id": number, "topic": topic, **kind, **more}
