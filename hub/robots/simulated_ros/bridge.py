"""The bridge for Foxglove before the simulated robot: the server of foxglove-sdk, on loopback.

This file needs the extra "tools".
The server has threads of its own. They only note what clients do; `serve_once` acts on it.
"""

from __future__ import annotations

import logging
import math
import time
from collections import deque
from collections.abc import Callable, Sequence
from typing import Any, Final

import foxglove
from foxglove.websocket import (
    Capability,
    ChannelView,
    Client,
    ClientChannel,
    ServerListener,
    WebSocketServer,
)

from hub.errors import EndpointError, RosMessageError
from hub.gcm.geometry import Twist, Vector3
from hub.robots.simulated_ros.flavour import RosFlavour
from hub.robots.simulated_ros.goal_server import GoalServer
from hub.robots.simulated_ros.motion_trace import MotionTrace
from hub.robots.simulated_ros.pictures import can_compress
from hub.robots.simulated_ros.robot import (
    COMMANDS,
    IMAGE,
    TOPICS,
    SimulatedRosRobot,
    SimulatedTopic,
)
from hub.ros.decoding import RosDecoder
from hub.ros.messages import planar
from hub.ros.schema import full_name
from hub.values import dataclass

STEP: Final = 0.01
"""Length of a step of the robot [s]."""
_BEHIND: Final = 0.5
"""Time that is skipped after a pause of the process [s]."""
_GRAPH_AFTER_S: Final = 0.3
"""Time from a client's last change to the graph that shows it [s]: the server must not get
a graph while it calls its listener, since each would wait for the other."""
_NAME: Final = "foxglove_bridge"
_NODE: Final = "/foxglove_bridge"
_CONTROLLER: Final = "/diff_drive_controller"
_NAVIGATOR: Final = "/bt_navigator"
_STOP: Final = "/e_stop"
_LOOPBACK: Final = "127.0.0.1"
_MOST_RATE: Final = 1000.0


@dataclass(frozen=True, slots=True, kw_only=True)
class BridgeSettings:
    """What a simulated robot with ROS is like, besides its body.

    Attributes:
        flavour: Its ROS.
        stamped: Whether its commands are geometry_msgs/TwistStamped; else geometry_msgs/Twist.
        clock_ahead: What its clock is ahead of this machine's [s].
        other_publishers: Names of nodes that publish commands too.
        navigates: Whether it has navigation of its own, and the bridge shows it.
    """

    flavour: RosFlavour
    stamped: bool = True
    clock_ahead: float = 0.0
    other_publishers: tuple[str, ...] = ()
    navigates: bool = True

    @property
    def commands(self) -> str:
        """The type of its commands, as ROS 2 writes it."""
        return "geometry_msgs/msg/TwistStamped" if self.stamped else "geometry_msgs/msg/Twist"


class SimulatedBridge:
    """A robot behind a bridge; used by one thread.

    Attributes:
        port: TCP port on loopback.
    """

    def __init__(
        self,
        robot: SimulatedRosRobot,
        settings: BridgeSettings,
        port: int,
        trace: MotionTrace | None = None,
    ) -> None:
        """Listen.

        Args:
            robot: The robot.
            settings: The rest of it.
            port: TCP port; 0: a free one.
            trace: Where commands and motions are written.

        Raises:
            EndpointError: The port is not free.
        """
        self._robot, self._settings, self._trace = robot, settings, trace
        self._decoder = RosDecoder.of(_Described(settings))
        self._happened: deque[Callable[[], None]] = deque()
        self._publishers: dict[tuple[int, int], tuple[str, str, str]] = {}
        self._rate = 1.0 / TOPICS[0].period
        self._time = time.monotonic()
        self._due = dict.fromkeys((each.name for each in TOPICS), self._time)
        self._context = foxglove.Context()  # its channels end with it
        self._channels = self._opened()
        self._goals: GoalServer | None = None
        self._goal = ""
        if settings.navigates:
            self._goals = GoalServer(robot, settings.flavour, self._context, self._clock)
        self._server = self._listen(port)
        self.port: int = self._server.port
        self._graph_at = math.inf
        self._publish_graph()

    def serve_once(self) -> None:
        """Do what is due, then wait for the end of the step."""
        now = time.monotonic()
        self._time = max(self._time, now - _BEHIND)
        while self._happened:
            self._happened.popleft()()
        if now >= self._graph_at:
            self._graph_at = math.inf
            self._publish_graph()
        while self._time + STEP <= now:
            self._time += STEP
            self._navigate()
            self._robot.advance(STEP, self._clock())
        if self._trace is not None:
            self._trace.motion(now, self._robot.motion)
        self._publish(now)
        if self._goals is not None:
            self._goals.publish(now)
        time.sleep(max(0.0, self._time + STEP - time.monotonic()))

    def close(self) -> None:
        """End all connections."""
        self._server.stop()
        if self._trace is not None:
            self._trace.close()

    # What clients do, on threads of the server.

    def note(self, act: Callable[[], None]) -> None:
        """Have `serve_once` do this."""
        self._happened.append(act)

    def subscribed(self, topic: str) -> None:
        """Send a latched message again, for who has subscribed."""
        if self._goals is not None:
            self._goals.subscribed(topic)
        if any(each.name == topic and not each.period for each in TOPICS):
            self._due[topic] = 0.0

    def advertised(self, client: int, channel: ClientChannel) -> None:
        """A client becomes a publisher."""
        found = channel.topic, channel.encoding, channel.schema_name
        self._publishers[client, channel.id] = found
        self._graph_at = time.monotonic() + _GRAPH_AFTER_S

    def unadvertised(self, client: int, channel: int) -> None:
        """A client is no publisher any more."""
        self._publishers.pop((client, channel), None)
        self._graph_at = time.monotonic() + _GRAPH_AFTER_S

    def received(self, client: int, channel: int, payload: bytes, at: float) -> None:
        """Take a message of a client.

        Args:
            client: Its number.
            channel: Of its publisher.
            payload: The message.
            at: When it came [s, monotonic].
        """
        topic, encoding, kind = self._publishers.get((client, channel), ("", "", ""))
        own = self._settings
        if self._goals is not None and topic in self._goals.taken:
            self._goals.received(topic, payload)
        # Nodes of ROS get nothing from a publisher of another type.
        if (topic, encoding, full_name(kind)) != (COMMANDS, own.flavour.encoding, own.commands):
            return
        try:
            value = self._decoder.decode(payload)
            given = planar(value.get("twist") if own.stamped else value)
            ahead, left, _, turn = (each if math.isfinite(each) else 0.0 for each in given)
        except RosMessageError:
            return
        now = self._clock() - (time.monotonic() - at)
        stamp = 0.0
        if own.stamped:
            time_of = value.get("header.stamp")
            stamp = int(time_of.get("sec")) + int(time_of.get("nanosec")) * 1e-9
        twist = Twist(linear=Vector3(x=ahead, y=left), angular=Vector3(z=turn))
        counts = self._robot.controller.take(twist, stamp, now)
        if self._trace is not None:
            self._trace.command(at, twist, stamp, counts=counts)
        if COMMANDS in self._channels:
            self._channels[COMMANDS].log(payload, log_time=self._clock_ns())

    def _listen(self, port: int) -> WebSocketServer:
        """Start the server at a TCP port; 0: a free one."""
        # A client that leaves without a farewell is no fault of the robot's.
        foxglove.set_log_level(logging.CRITICAL)
        try:
            return foxglove.start_server(
                name=_NAME,
                host=_LOOPBACK,
                port=port,
                capabilities=[
                    Capability.ClientPublish,
                    Capability.ConnectionGraph,
                    Capability.Parameters,
                    Capability.Services,
                ],
                server_listener=_Listener(self),
                supported_encodings=list(self._settings.flavour.encodings),
                services=[self._service(), *(self._goals.services if self._goals else ())],
                context=self._context,
            )
        except (OSError, RuntimeError, ValueError) as error:
            busy = "another program listens there" if "in use" in str(error) else str(error)
            text = f"port {port} of {_LOOPBACK} cannot be used: {busy}; name another with --port"
            raise EndpointError(text) from error

    def _navigate(self) -> None:
        """Let the robot's own navigation drive, as a node that publishes velocities."""
        if self._goals is None:
            return
        velocity = self._goals.velocity(self._time)
        if velocity is not None:
            self._robot.controller.take(velocity, 0.0, self._clock())
        if self._goals.goal != self._goal and self._trace is not None:
            self._trace.goal(self._time, self._goals.goal)
        self._goal = self._goals.goal

    def _halt(self, at: float) -> None:
        self._robot.controller.halt()
        if self._trace is not None:
            self._trace.call(at, _STOP)

    def parameters(self) -> dict[str, Any]:
        """Its parameters by name."""
        flavour = self._settings.flavour
        return {
            flavour.timeout: float(self._robot.controller.timeout),
            flavour.rate: float(self._rate),
            flavour.simulated_time: False,
        }

    def set_parameter(self, name: str, value: object) -> None:
        """Change a parameter; a value that makes no sense changes nothing."""
        if not isinstance(value, int | float) or not 0.0 <= value <= _MOST_RATE:
            return
        if name == self._settings.flavour.timeout:
            self._robot.controller.timeout = float(value)
        elif name == self._settings.flavour.rate:
            self._rate = float(value)

    # Its own parts.

    def _clock(self) -> float:
        """The time by the robot's clock [s since the epoch]."""
        return time.time() + self._settings.clock_ahead

    def _clock_ns(self) -> int:
        return int(self._clock() * 1e9)

    def _opened(self) -> dict[str, foxglove.Channel]:
        flavour = self._settings.flavour
        kinds = {each.name: each.type for each in TOPICS} | {COMMANDS: self._settings.commands}
        if flavour.encoding == "ros1" and not self._settings.other_publishers:
            del kinds[COMMANDS]  # that bridge has channels for published topics only
        if not can_compress():
            del kinds[f"{IMAGE}/compressed"]
        return {
            name: foxglove.Channel(
                name,
                schema=foxglove.Schema(
                    name=flavour.type_name(kind),
                    encoding=flavour.schema_encoding,
                    data=flavour.definition(kind),
                ),
                message_encoding=flavour.encoding,
                context=self._context,
            )
            for name, kind in kinds.items()
        }

    def _service(self) -> foxglove.Service:
        flavour = self._settings.flavour

        def schema(name: str, text: str) -> foxglove.MessageSchema:
            found = foxglove.Schema(name=name, encoding=flavour.schema_encoding, data=text.encode())
            return foxglove.MessageSchema(encoding=flavour.encoding, schema=found)

        def stop(_request: foxglove.ServiceRequest) -> bytes:
            at = time.monotonic()
            self.note(lambda: self._halt(at))
            return flavour.trigger_answer("the base stands until a neutral command comes")

        request, answer = (schema(*each) for each in flavour.trigger)
        kind = flavour.type_name("std_srvs/srv/Trigger")
        named = foxglove.ServiceSchema(name=kind, request=request, response=answer)
        return foxglove.Service(_STOP, schema=named, handler=stop)

    def _publish(self, now: float) -> None:
        for each in TOPICS:
            channel = self._channels.get(each.name)
            if channel is None or now < self._due[each.name]:
                continue
            self._due[each.name] = self._next(each, now)
            if not channel.has_sinks() or (each is TOPICS[0] and not self._rate):
                continue
            payload = self._settings.flavour.encoder(each.type).encode(
                self._robot.message(each.name)
            )
            channel.log(payload, log_time=self._clock_ns())

    def _next(self, topic: SimulatedTopic, now: float) -> float:
        """When a topic is due again [s, monotonic]."""
        if not topic.period:
            return math.inf
        period = 1.0 / (self._rate or 1.0) if topic is TOPICS[0] else topic.period
        after = self._due[topic.name] + period
        return after if after > now - _BEHIND else now

    def _publish_graph(self) -> None:
        graph = foxglove.ConnectionGraph()
        for each in TOPICS:
            graph.set_published_topic(each.name, [each.node])
        if self._goals is not None:
            for topic, node in self._goals.topics.items():
                graph.set_published_topic(topic, [node])
            for topic, node in self._goals.taken.items():
                graph.set_subscribed_topic(topic, [node])
            for service in self._goals.services:
                graph.set_advertised_service(service.name, [_NAVIGATOR])
        ours = [_NODE] * any(topic == COMMANDS for topic, *_ in self._publishers.values())
        graph.set_published_topic(COMMANDS, [*self._settings.other_publishers, *ours])
        graph.set_subscribed_topic(COMMANDS, [_CONTROLLER])
        graph.set_advertised_service(_STOP, [_CONTROLLER])
        self._server.publish_connection_graph(graph)


@dataclass(frozen=True, slots=True)
class _Described:
    """The topic of commands, as `RosDecoder` takes it."""

    settings: BridgeSettings

    @property
    def schema_name(self) -> str:
        return self.settings.commands

    @property
    def encoding(self) -> str:
        return self.settings.flavour.encoding

    @property
    def schema_encoding(self) -> str:
        return self.settings.flavour.schema_encoding

    @property
    def schema(self) -> bytes:
        return self.settings.flavour.definition(self.settings.commands)


class _Listener(ServerListener):
    """What the server calls, on its own threads."""

    def __init__(self, bridge: SimulatedBridge) -> None:
        self._bridge = bridge

    def on_subscribe(self, client: Client, channel: ChannelView) -> None:  # noqa: ARG002
        topic = channel.topic
        self._bridge.note(lambda: self._bridge.subscribed(topic))

    def on_client_advertise(self, client: Client, channel: ClientChannel) -> None:
        number = client.id
        self._bridge.note(lambda: self._bridge.advertised(number, channel))

    def on_client_unadvertise(self, client: Client, client_channel_id: int) -> None:
        number = client.id
        self._bridge.note(lambda: self._bridge.unadvertised(number, client_channel_id))

    def on_message_data(self, client: Client, client_channel_id: int, data: bytes) -> None:
        number, at = client.id, time.monotonic()
        self._bridge.note(lambda: self._bridge.received(number, client_channel_id, data, at))

    def on_get_parameters(
        self,
        client: Client,  # noqa: ARG002
        param_names: Sequence[str],
        request_id: str | None = None,  # noqa: ARG002
    ) -> list[foxglove.Parameter]:
        return self._parameters(param_names)

    def on_set_parameters(
        self,
        client: Client,  # noqa: ARG002
        parameters: Sequence[foxglove.Parameter],
        request_id: str | None = None,  # noqa: ARG002
    ) -> list[foxglove.Parameter]:
        for each in parameters:
            self._bridge.set_parameter(each.name, each.get_value())
        return self._parameters([each.name for each in parameters])

    def _parameters(self, names: Sequence[str]) -> list[foxglove.Parameter]:
        known = self._bridge.parameters()
        wanted = names or list(known)
        return [foxglove.Parameter(name, value=known[name]) for name in wanted if name in known]
