"""The server for panels. The SDK calls from threads of its own; one thread gets what they asked."""

from __future__ import annotations

import itertools
import logging
import socket
import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import field

import foxglove
from foxglove import Channel, Context, Parameter, Schema
from foxglove.websocket import Capability, ChannelView, ServerListener
from foxglove.websocket import Client as Viewer
from foxglove.websocket import ClientChannel as ViewerChannel

from hub.doors.panels.sentence_log import SentenceLog
from hub.doors.panels.wishes import (
    CMD_VEL,
    LARGEST_COMMAND,
    MOST_PANELS,
    Panel,
    PanelCommand,
    Wishes,
)
from hub.errors import DoorError
from hub.ipc.transport.fault_counter import FaultCounter
from hub.recording.topics import RecordedTopic
from hub.values import dataclass

_logger = logging.getLogger(__name__)

_WAITING = 8
"""Commands of a panel that wait for the door; the oldest is dropped."""
_BACKLOG = 64
"""Messages that wait for a slow program; the oldest is dropped."""
_MOST_OF_PROGRAM = 4
"""Most panels of one program that may send commands at a time."""
_ENCODINGS = ("json", "cdr")
"""How panels may write commands; Foxglove takes the first, and knows no ROS types for the other."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ServerSettings:
    """How the server is opened.

    Attributes:
        name: What programs show.
        host: Where it listens.
        port: TCP port; 0: a free one.
        drive: Whether panels may send commands.
        certificate: PEM, for wss; None: ws.
        key: PEM of its key.
    """

    name: str
    host: str = "127.0.0.1"
    port: int = 0
    drive: bool = False
    certificate: bytes | None = None
    key: bytes | None = None


@dataclass(slots=True)
class _Asked:
    """What the threads of the SDK have noted; guarded by a lock."""

    viewers: dict[int, set[int]] = field(default_factory=dict)
    fresh: set[int] = field(default_factory=set)
    panels: dict[Panel, tuple[str, str]] = field(default_factory=dict)
    commands: dict[Panel, deque[PanelCommand]] = field(default_factory=dict)
    parameters: tuple[Parameter, ...] = ()
    noted: bool = False


class _PanelListener(ServerListener):
    """Notes what programs ask for; newest wins, so that a flood fills no memory."""

    def __init__(self, changed: Callable[[], None], *, drive: bool) -> None:
        self._changed, self._drive = changed, drive
        self._lock = threading.Lock()
        self._asked = _Asked()
        self._faults = FaultCounter(_logger, time.monotonic)

    @property
    def refused(self) -> int:
        """Number of commands and channels that were not taken."""
        return self._faults.counts.total()

    def take(self) -> Wishes:
        """All that was asked until now."""
        asked = self._asked
        with self._lock:
            asked.noted = False
            wishes = Wishes(
                watched=frozenset(each for each, viewers in asked.viewers.items() if viewers),
                fresh=frozenset(asked.fresh),
                commands=tuple(itertools.chain.from_iterable(asked.commands.values())),
                panels=frozenset(asked.panels),
            )
            asked.fresh.clear()
            asked.commands.clear()
        return wishes

    def set_parameters(self, parameters: tuple[Parameter, ...]) -> None:
        self._asked.parameters = parameters

    def on_subscribe(self, client: Viewer, channel: ChannelView) -> None:
        with self._lock:
            self._asked.viewers.setdefault(channel.id, set()).add(client.id)
            self._asked.fresh.add(channel.id)
        self._note()

    def on_unsubscribe(self, client: Viewer, channel: ChannelView) -> None:
        with self._lock:
            self._asked.viewers.get(channel.id, set()).discard(client.id)
        self._note()

    def on_client_advertise(self, client: Viewer, channel: ViewerChannel) -> None:
        if not self._drive or channel.topic != CMD_VEL:
            why = f"{channel.topic[:80]!r} is none on which panels drive"
            self._faults.count("refused channel", why if self._drive else "panels do not drive")
            return
        with self._lock:
            panels = self._asked.panels
            of_program = sum(program == client.id for program, _ in panels)
            room = len(panels) < MOST_PANELS and of_program < _MOST_OF_PROGRAM
            if room:
                panels[client.id, channel.id] = channel.encoding[:64], channel.schema_name[:64]
        if not room:
            most = f"at most {_MOST_OF_PROGRAM} of a program and {MOST_PANELS} in all may drive"
            self._faults.count("refused channel", most)
        self._note()

    def on_client_unadvertise(self, client: Viewer, client_channel_id: int) -> None:
        with self._lock:
            self._asked.panels.pop((client.id, client_channel_id), None)
            self._asked.commands.pop((client.id, client_channel_id), None)
        self._note()

    def on_message_data(self, client: Viewer, client_channel_id: int, data: bytes) -> None:
        panel = client.id, client_channel_id
        kind = self._asked.panels.get(panel)
        if kind is None or len(data) > LARGEST_COMMAND:
            why = "its channel is not open" if kind is None else "it is too long"
            self._faults.count("refused command", f"{len(data)} bytes of a panel: {why}")
            return
        encoding, schema_name = kind
        command = PanelCommand(
            panel=panel, encoding=encoding, schema_name=schema_name, data=data,
            came=time.monotonic(),
        )  # fmt: skip
        with self._lock:
            waiting = self._asked.commands.setdefault(panel, deque(maxlen=_WAITING))
            waiting.append(command)
        self._note()

    def on_get_parameters(
        self, client: Viewer, param_names: list[str], request_id: str | None = None
    ) -> list[Parameter]:
        del client, request_id
        names = frozenset(param_names)
        return [each for each in self._asked.parameters if not names or each.name in names]

    def on_set_parameters(
        self, client: Viewer, parameters: list[Parameter], request_id: str | None = None
    ) -> list[Parameter]:
        """Change nothing: the answer has the values as they are."""
        return self.on_get_parameters(client, [each.name for each in parameters], request_id)

    def _note(self) -> None:
        with self._lock:
            noted, self._asked.noted = self._asked.noted, True
        if not noted:
            self._changed()


class ToolServer:
    """Serves topics to Foxglove and Lichtblick."""

    def __init__(self, settings: ServerSettings, changed: Callable[[], None]) -> None:
        """Open it.

        Args:
            settings: How.
            changed: Called by any thread when there are new wishes.

        Raises:
            DoorError: The port is busy, or the certificate cannot be used.
        """
        self._context = Context()
        self._channels: dict[int, Channel] = {}
        self._listener = _PanelListener(changed, drive=settings.drive)
        self._sentences = SentenceLog(_logger, time.monotonic)
        self._secure = settings.certificate is not None
        # A program cannot open the address that means all of this machine's.
        self.host = socket.gethostname() if settings.host in ("0.0.0.0", "::") else settings.host
        # What programs send wrong is answered to them; here it would flood the log.
        foxglove.set_log_level(logging.CRITICAL)
        capabilities = [Capability.Parameters]
        if settings.drive:
            capabilities.append(Capability.ClientPublish)
        try:
            self._server = foxglove.start_server(
                name=settings.name,
                host=settings.host,
                port=settings.port,
                capabilities=capabilities,
                server_listener=self._listener,
                supported_encodings=list(_ENCODINGS) if settings.drive else [],
                context=self._context,
                message_backlog_size=_BACKLOG,
                tls_cert=settings.certificate,
                tls_key=settings.key,
            )
        except (OSError, RuntimeError, ValueError) as error:
            busy = "in use" in str(error)
            reason = "another program listens there" if busy else str(error)
            other = "--port" if busy else "--host, --port or TLS file"
            text = (
                f"panels cannot be served on {settings.host} port {settings.port}: {reason}; give "
                f"another {other}"
            )
            raise DoorError(text) from error

    @property
    def address(self) -> str:
        """What a program opens: "ws://127.0.0.1:8765"."""
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"{'wss' if self._secure else 'ws'}://{host}:{self._server.port}"

    @property
    def refused(self) -> int:
        """Number of commands and channels of programs that were not taken."""
        return self._listener.refused

    def take_wishes(self) -> Wishes:
        """What panels want now."""
        return self._listener.take()

    def open(self, topic: RecordedTopic) -> int:
        """Offer a topic; returns its number."""
        schema = Schema(name=topic.schema_name, encoding=topic.schema_encoding, data=topic.schema)
        channel = Channel(
            topic.name, schema=schema, message_encoding=topic.encoding, context=self._context
        )
        self._channels[channel.id()] = channel
        return channel.id()

    def close_topic(self, number: int) -> None:
        """Offer a topic no more."""
        self._channels.pop(number).close()

    def send(self, number: int, payload: bytes, stamp: int) -> None:
        """Send a message of a topic, measured at `stamp` [ns since the epoch], to who shows it."""
        self._channels[number].log(payload, log_time=max(0, stamp))

    def set_parameters(self, values: dict[str, str | float | bool]) -> None:
        """Set what programs see as parameters."""
        parameters = tuple(Parameter(name, value=value) for name, value in values.items())
        self._listener.set_parameters(parameters)
        self._server.publish_parameter_values(list(parameters))

    def say(self, text: str) -> None:
        """Show a sentence in all programs, in place of the one before; empty: take it away."""
        self._sentences.note(text)
        if text:
            self._server.publish_status(text, foxglove.StatusLevel.Warning, "rune")
        else:
            self._server.remove_status(["rune"])

    def close(self) -> None:
        """Disconnect all programs."""
        self._server.stop()
