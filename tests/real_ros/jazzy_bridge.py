"""A bridge for Foxglove as a real node of ROS 2 Jazzy: rclpy here, foxglove-sdk there.

Run by the Python of `.venv-ros2`. The bridge of Foxglove is no package of Python; this one does
what it does: raw messages of all topics, definitions of their types, velocities of clients,
parameters, the graph. Packages that are named as arguments are missing here, as on a robot without
them. Writes one line of JSON once it has seen the robot: its port.
"""

from __future__ import annotations

import importlib
import json
import queue
import re
import signal
import sys
import time
from collections.abc import Callable
from typing import Any

import foxglove
import rclpy
from foxglove import Channel, ConnectionGraph, Context, Parameter, Schema
from foxglove.websocket import Capability, ServerListener
from rcl_interfaces.msg import ParameterType
from rcl_interfaces.srv import GetParameters, ListParameters
from rclpy.node import Node
from rclpy.qos import QoSDurabilityPolicy as Durability
from rclpy.qos import QoSProfile
from rclpy.qos import QoSReliabilityPolicy as Reliability

LACKS = frozenset(sys.argv[1:])
WORDS = {"double": "float64", "float": "float32", "boolean": "bool", "octet": "byte"}
_PARTS = re.compile(
    r"(?:sequence<(?P<inner>[^,>]+)(?:, *\d+)?>|(?P<plain>[^\[]+?))(?P<fixed>\[\d+\])?"
)


def type_of(name: str) -> Any:
    """The class of a type such as "nav_msgs/msg/Odometry"; None: its package is missing."""
    package, kind, last = name.split("/") if name.count("/") == 2 else (*name.split("/"), "")
    if not last:
        kind, last = "msg", kind
    if package in LACKS:
        return None
    try:
        return getattr(importlib.import_module(f"{package}.{kind}"), last)
    except (ImportError, AttributeError):
        return None


def definition(name: str, seen: dict[str, str]) -> str:
    """The fields of a type, from its class; the types within it are added to `seen`."""
    lines = []
    for field, spelt in type_of(name).get_fields_and_field_types().items():
        parts = _PARTS.fullmatch(spelt)
        inner = parts["inner"] or parts["plain"]
        base = re.sub(r"<\d+>", "", inner)
        array = parts["fixed"] or ("[]" if parts["inner"] else "")
        lines.append(f"{WORDS.get(base, base)}{array} {field}")
        if "/" in base and base not in seen:
            seen[base] = ""
            seen[base] = definition(base, seen)
    return "".join(f"{line}\n" for line in lines)


def whole_definition(name: str) -> str:
    """With all types within it; empty: a package is missing."""
    seen: dict[str, str] = {}
    try:
        first = definition(name, seen)
    except AttributeError:
        return ""
    return first + "".join(f"{'=' * 80}\nMSG: {each}\n{text}" for each, text in seen.items())


class Bridge(Node, ServerListener):
    """Threads of the server ask; the one thread of the node works, since rclpy bears no more."""

    def __init__(self) -> None:
        Node.__init__(self, "foxglove_bridge")
        self.own_context = Context()
        self.channels: dict[str, Channel] = {}
        self.names: dict[int, tuple[str, str]] = {}
        self.subscribed: dict[int, Any] = {}
        self.published: dict[tuple[int, int], Any] = {}
        self.found: dict[str, float | bool] = {}
        self.asked: set[str] = set()
        self.waiting = 0
        self.work: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self.wake = self.create_guard_condition(self.do_work)
        self.ready = False
        self.server = foxglove.start_server(
            name="foxglove_bridge", host="127.0.0.1", port=0, server_listener=self,
            capabilities=[
                Capability.ClientPublish, Capability.ConnectionGraph, Capability.Parameters
            ],
            supported_encodings=["cdr"], context=self.own_context,
        )  # fmt: skip
        self.create_timer(0.2, self.look)

    def later(self, work: Callable[[], None]) -> None:
        self.work.put(work)
        self.wake.trigger()

    def do_work(self) -> None:
        while not self.work.empty():
            self.work.get()()

    def look(self) -> None:
        """Offer new topics, say which nodes use them, and ask new nodes for parameters."""
        graph = ConnectionGraph()
        for name, types in self.get_topic_names_and_types():
            graph.set_published_topic(name, nodes(self.get_publishers_info_by_topic(name)))
            graph.set_subscribed_topic(name, nodes(self.get_subscriptions_info_by_topic(name)))
            if name not in self.channels:
                text = whole_definition(types[0])
                schema = Schema(name=types[0], encoding="ros2msg", data=text.encode())
                made = Channel(
                    name, schema=schema, message_encoding="cdr", context=self.own_context
                )
                self.channels[name], self.names[made.id()] = made, (name, types[0])
        self.server.publish_connection_graph(graph)
        for name, namespace in self.get_node_names_and_namespaces():
            whole = f"{namespace.rstrip('/')}/{name}"
            if name != self.get_name() and whole not in self.asked:
                self.asked.add(whole)
                self.ask_names(whole)
        if not self.ready and {"/cmd_vel", "/odom", "/battery_state"} <= self.channels.keys():
            self.ready = True
            sys.stdout.write(json.dumps({"port": self.server.port}) + "\n")
            sys.stdout.flush()

    def ask_names(self, node: str) -> None:
        client = self.create_client(ListParameters, f"{node}/list_parameters")
        self.waiting += 1
        client.call_async(ListParameters.Request()).add_done_callback(
            lambda future: self.ask_values(node, future.result().result.names)
        )

    def ask_values(self, node: str, names: list[str]) -> None:
        def came(future: Any) -> None:
            self.waiting -= 1
            for name, value in zip(names, future.result().values, strict=True):
                if value.type == ParameterType.PARAMETER_DOUBLE:
                    self.found[f"{node}.{name}"] = value.double_value
                if value.type == ParameterType.PARAMETER_BOOL:
                    self.found[f"{node}.{name}"] = value.bool_value

        client = self.create_client(GetParameters, f"{node}/get_parameters")
        client.call_async(GetParameters.Request(names=names)).add_done_callback(came)

    def on_subscribe(self, _client: Any, channel: Any) -> None:
        self.later(lambda: self.subscribe(channel.id))

    def subscribe(self, channel: int) -> None:
        name, kind = self.names[channel]
        if channel in self.subscribed or type_of(kind) is None:
            return
        ends = [each.qos_profile for each in self.get_publishers_info_by_topic(name)]
        reliable = all(each.reliability == Reliability.RELIABLE for each in ends)
        kept = bool(ends) and all(each.durability == Durability.TRANSIENT_LOCAL for each in ends)
        qos = QoSProfile(
            depth=10,
            reliability=Reliability.RELIABLE if reliable else Reliability.BEST_EFFORT,
            durability=Durability.TRANSIENT_LOCAL if kept else Durability.VOLATILE,
        )
        out = self.channels[name]

        def pass_on(data: bytes) -> None:
            out.log(data, log_time=time.time_ns())

        self.subscribed[channel] = self.create_subscription(
            type_of(kind), name, pass_on, qos, raw=True
        )

    def on_unsubscribe(self, _client: Any, channel: Any) -> None:
        self.later(lambda: self.unsubscribe(channel.id))

    def unsubscribe(self, channel: int) -> None:
        subscription = self.subscribed.pop(channel, None)
        if subscription is not None:
            self.destroy_subscription(subscription)

    def on_client_advertise(self, client: Any, channel: Any) -> None:
        kind, topic, key = type_of(channel.schema_name), channel.topic, (client.id, channel.id)
        if kind is None:
            text = f"Failed to create publisher for topic {topic} ({channel.schema_name})"
            self.server.publish_status(text, foxglove.StatusLevel.Error)
            return
        self.later(lambda: self.published.update({key: self.create_publisher(kind, topic, 10)}))

    def on_client_unadvertise(self, client: Any, client_channel_id: int) -> None:
        key = client.id, client_channel_id
        self.later(lambda: self.unadvertise(key))

    def unadvertise(self, key: tuple[int, int]) -> None:
        publisher = self.published.pop(key, None)
        if publisher is not None:
            self.destroy_publisher(publisher)

    def on_message_data(self, client: Any, client_channel_id: int, data: bytes) -> None:
        key = client.id, client_channel_id
        self.later(lambda: self.publish(key, data))

    def publish(self, key: tuple[int, int], data: bytes) -> None:
        publisher = self.published.get(key)
        if publisher is not None:
            publisher.publish(data)

    def on_get_parameters(
        self, _client: Any, param_names: list[str], _request_id: str | None = None
    ) -> list[Parameter]:
        end = time.monotonic() + 3.0
        while self.waiting and time.monotonic() < end:
            time.sleep(0.01)
        return [
            Parameter(name, value=value)
            for name, value in tuple(self.found.items())
            if not param_names or name in param_names
        ]


def nodes(ends: Any) -> list[str]:
    """The names of the nodes that have these ends of a topic."""
    return [f"{each.node_namespace.rstrip('/')}/{each.node_name}" for each in ends]


def main() -> None:
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))
    rclpy.init()
    rclpy.spin(Bridge())


main()
