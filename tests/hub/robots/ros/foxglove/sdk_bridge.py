"""A bridge made of Foxglove's own server."""
# ruff: noqa: ARG002 - the server gives them to its listener

from __future__ import annotations

import foxglove
from foxglove import Channel, Context, MessageSchema, Parameter, Schema, Service, ServiceSchema
from foxglove.websocket import Capability, ServerListener

STRING = Schema(name="std_msgs/msg/String", encoding="ros2msg", data=b"string data\n")
TWIST = Schema(
    name="geometry_msgs/Twist",
    encoding="ros2msg",
    data=b"Vector3 linear\nVector3 angular\n" + b"=" * 80 + b"\nMSG: geometry_msgs/Vector3\n"
    b"float64 x\nfloat64 y\nfloat64 z\n",
)
ALL = (
    Capability.ClientPublish,
    Capability.Services,
    Capability.Parameters,
    Capability.ConnectionGraph,
)


class SdkBridge(ServerListener):
    """Its server, and what clients did."""

    def __init__(self, capabilities=ALL, port=0, encodings=("cdr", "json"), **options):
        self.subscribed, self.advertised, self.received = [], [], []
        self.parameters = {"/base.cmd_vel_timeout": 0.5, "/base.whole": 2.0, "/base.name": "diff"}
        self.context = Context()
        self.server = foxglove.start_server(
            name="robot",
            host="127.0.0.1",
            port=port,
            context=self.context,
            capabilities=list(capabilities),
            supported_encodings=list(encodings),
            server_listener=self,
            **options,
        )
        self.port = self.server.port

    def channel(self, topic, schema=STRING, encoding="cdr"):
        return Channel(topic, schema=schema, message_encoding=encoding, context=self.context)

    def add_service(self, name, handler):
        kind = MessageSchema(encoding="cdr", schema=STRING)
        schema = ServiceSchema("std_srvs/srv/Trigger", request=kind, response=kind)
        self.server.add_services([Service(name, schema=schema, handler=handler)])

    def on_subscribe(self, client, channel):
        self.subscribed.append(channel.topic)

    def on_unsubscribe(self, client, channel):
        self.subscribed.remove(channel.topic)

    def on_client_advertise(self, client, channel):
        self.advertised.append((channel.topic, channel.encoding, channel.schema_name))

    def on_client_unadvertise(self, client, client_channel_id):
        self.advertised.pop()

    def on_message_data(self, client, client_channel_id, data):
        self.received.append(data)

    def on_get_parameters(self, client, param_names, request_id=None):
        return [
            Parameter(name, value=value)
            for name, value in self.parameters.items()
            if not param_names or name in param_names
        ]
