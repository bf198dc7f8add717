"""A program with panels, as Foxglove is one, and the door that it connects to."""

from __future__ import annotations

import json
import struct
import time
from collections import defaultdict
from contextlib import ExitStack
from typing import Any

from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from websockets.sync.client import connect

from hub.doors.panels.wishes import CMD_VEL
from tests.support.running_command import RunningCommand
from tests.support.waiting import until

SUBPROTOCOL = "foxglove.sdk.v1"
_WAIT_S = 20.0


class DoorProcess(RunningCommand):
    """`rune-hub serve foxglove`.

    Attributes:
        address: Where programs connect.
    """

    def __init__(self, hub: str, *options: str) -> None:
        super().__init__("serve", "foxglove", "--hub", hub, "--port", "0", *options)
        self.address: str = self.ready["address"]


class Panels:
    """A connected program.

    Attributes:
        topics: What the door offers, by name.
        payloads: Of the messages, by topic.
        stamps: Its times [ns].
        said: The texts that the door shows.
        parameters: The newest ones.
    """

    def __init__(self, address: str) -> None:
        self._opened = ExitStack()
        socket = connect(address, subprotocols=[SUBPROTOCOL], max_size=None, close_timeout=0.5)
        self._socket = self._opened.enter_context(socket)
        self.topics: dict[str, dict[str, Any]] = {}
        self.payloads: dict[str, list[bytes]] = defaultdict(list)
        self.stamps: dict[str, list[int]] = defaultdict(list)
        self.said: list[str] = []
        self.parameters: dict[str, Any] = {}
        self.info: dict[str, Any] = json.loads(self._socket.recv(_WAIT_S))
        self._names: dict[int, str] = {}
        self.wait(lambda: "/odom" in self.topics)

    def show(self, *topics: str) -> None:
        """Open panels on topics."""
        self._send("subscribe", subscriptions=[
            {"id": self.topics[each]["id"], "channelId": self.topics[each]["id"]}
            for each in topics
        ])  # fmt: skip

    def hide(self, *topics: str) -> None:
        """Close the panels on topics."""
        self._send("unsubscribe", subscriptionIds=[self.topics[each]["id"] for each in topics])

    def teleop(self, encoding: str = "json", kind: str = "geometry_msgs/Twist") -> None:
        """Open a panel that drives."""
        channel = {"id": 1, "topic": CMD_VEL, "encoding": encoding, "schemaName": kind}
        self._send("advertise", channels=[channel])

    def twist(self, ahead: float) -> None:
        """Send a velocity, as the panel Teleop does while a button is down."""
        values = {"linear": {"x": ahead, "y": 0, "z": 0}, "angular": {"x": 0, "y": 0, "z": 0}}
        self.send(json.dumps(values).encode())

    def send(self, payload: bytes, channel: int = 1) -> None:
        """Send bytes on a channel."""
        self._socket.send(b"\x01" + struct.pack("<I", channel) + payload)

    def send_raw(self, frame: bytes | str) -> None:
        """Send any frame."""
        self._socket.send(frame)

    def ask_parameters(self) -> None:
        self._send("getParameters", parameterNames=[], id="all")

    def set_parameter(self, name: str, value: object) -> None:
        self._send("setParameters", parameters=[{"name": name, "value": value}], id="one")

    def pump(self, seconds: float = 0.01) -> None:
        """Receive for a while."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0.0:
            try:
                self._take(self._socket.recv(left))
            except TimeoutError:
                return

    def wait(self, condition: Any, timeout: float = _WAIT_S, why: str = "") -> None:
        until(condition, timeout, lambda: f"{why} {self.said}", meanwhile=self.pump)

    def newest(self, topic: str) -> Any:
        """The newest message of a topic as rosbags, an implementation of others, reads it."""
        self.wait(lambda: self.payloads[topic], why=f"{topic} does not come;")
        facts = self.topics[topic]
        types = get_typestore(Stores.EMPTY)
        types.register(get_types_from_msg(facts["schema"], facts["schemaName"]))
        return types.deserialize_cdr(self.payloads[topic][-1], facts["schemaName"])

    def close(self) -> None:
        self._opened.close()

    def _send(self, op: str, **values: object) -> None:
        self._socket.send(json.dumps({"op": op, **values}))

    def _take(self, frame: bytes | str) -> None:
        if isinstance(frame, bytes):
            _, subscription, stamp = struct.unpack_from("<BIQ", frame)
            name = self._names[subscription]
            self.payloads[name].append(frame[13:])
            self.stamps[name].append(stamp)
            return
        said = json.loads(frame)
        if said["op"] == "advertise":
            for channel in said["channels"]:
                self.topics[channel["topic"]] = channel
                self._names[channel["id"]] = channel["topic"]
        elif said["op"] == "status":
            self.said.append(said["message"])
        elif said["op"] == "parameterValues":
            self.parameters |= {each["name"]: each["value"] for each in said["parameters"]}
