"""The server for panels: a thread of its own serves programs, the door's thread calls it."""

from __future__ import annotations

import asyncio
import contextlib
import http
import itertools
import logging
import secrets
import socket
import ssl
import threading
import time
from collections.abc import Callable, Coroutine
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeVar, TypeVarTuple

from websockets.asyncio.server import Server, ServerConnection, serve
from websockets.exceptions import ConnectionClosed
from websockets.typing import Subprotocol

from hub.doors.foxglove import panel_wire as wire
from hub.doors.foxglove.asked import Asked
from hub.doors.foxglove.entrance import Entrance
from hub.doors.foxglove.handshake import DoorRules
from hub.doors.foxglove.viewer import Viewer
from hub.doors.panels.sentence_log import SentenceLog
from hub.doors.panels.wishes import Wishes
from hub.errors import DoorError, RosMessageError
from hub.ipc.transport.fault_counter import FaultCounter
from hub.recording.topics import RecordedTopic
from hub.ros.panel_door_name import PANEL_DOOR_SERVER
from hub.values import dataclass

if TYPE_CHECKING:
    from websockets.http11 import Request, Response

T = TypeVar("T")
Ts = TypeVarTuple("Ts")

_logger = logging.getLogger(__name__)

_MOST_FRAME: Final = 1 << 18
"""Longest message of a program [bytes]."""
_MOST_VIEWERS: Final = 32
"""Most programs at a time."""
_PING_EVERY_S: Final = 5.0
_PONG_S: Final = 10.0
_CLOSE_S: Final = 1.0
_START_S: Final = 10.0


@dataclass(frozen=True, slots=True, kw_only=True)
class ServerSettings:
    """How the server is opened.

    Attributes:
        name: What programs show.
        host: Where it listens.
        port: TCP port; 0: a free one.
        drive: Whether panels may send commands.
        names: Further names of hosts that may be asked for, and whose pages may connect.
        certificate: File with a certificate, for wss; None: ws.
        key: File with its key.
        handshake_s: Longest time of a request for a connection [s].
    """

    name: str
    host: str = "127.0.0.1"
    port: int = 0
    drive: bool = False
    names: tuple[str, ...] = ()
    certificate: Path | None = None
    key: Path | None = None
    handshake_s: float = 5.0


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
        self._settings = settings
        self._faults = FaultCounter(_logger, time.monotonic)
        self._asked = Asked(changed, self._faults, drive=settings.drive)
        self._sentences = SentenceLog(_logger, time.monotonic)
        # A program cannot open the address that means all of this machine's.
        everywhere = settings.host in ("0.0.0.0", "::")
        self.host = socket.gethostname() if everywhere else settings.host
        names = (settings.host, socket.gethostname(), *settings.names)
        self._key = secrets.token_urlsafe(16)
        self._rules = DoorRules(key=self._key, names=frozenset(map(str.lower, names)))
        self._topics: dict[int, RecordedTopic] = {}
        self._numbers = itertools.count(1)
        self._viewers: dict[int, Viewer] = {}
        self._viewer_numbers = itertools.count(1)
        self._facts: wire.Facts = {}
        self._said = ""
        self._session = str(time.time_ns())
        self._orders: dict[str, Callable[[Viewer, dict[str, Any]], None]] = {
            "subscribe": self._subscribe,
            "unsubscribe": self._unsubscribe,
            "advertise": self._advertise,
            "unadvertise": self._unadvertise,
            "getParameters": self._answer,
            "setParameters": self._answer,
        }
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, daemon=True, name="panels")
        self._thread.start()
        try:
            self._server = self._wait(self._open())
        except (OSError, ssl.SSLError) as error:
            self._end()
            raise DoorError(_words(error, settings)) from error

    @property
    def port(self) -> int:
        """The port where it listens."""
        return int(next(iter(self._server.sockets)).getsockname()[1])

    @property
    def address(self) -> str:
        """What a program opens, with the key: "ws://127.0.0.1:8765/KEY"."""
        host = f"[{self.host}]" if ":" in self.host else self.host
        scheme = "wss" if self._settings.certificate is not None else "ws"
        return f"{scheme}://{host}:{self.port}/{self._key}"

    @property
    def refused(self) -> int:
        """Number of commands, channels and connections of programs that were not taken."""
        return self._faults.counts.total()

    def take_wishes(self) -> Wishes:
        """What panels want now."""
        return self._asked.take()

    def open(self, topic: RecordedTopic) -> int:
        """Offer a topic; returns its number."""
        number = next(self._numbers)
        self._call(self._offer, number, topic)
        return number

    def close_topic(self, number: int) -> None:
        """Offer a topic no more."""
        self._call(self._withdraw, number)

    def send(self, number: int, payload: bytes, stamp: int) -> None:
        """Send a message of a topic, measured at `stamp` [ns since the epoch], to who shows it."""
        self._call(self._pass_on, number, payload, max(0, stamp))

    def set_parameters(self, values: dict[str, str | float | bool]) -> None:
        """Set what programs see as parameters."""
        self._call(self._set_facts, dict(values))

    def say(self, text: str) -> None:
        """Show a sentence in all programs, in place of the one before; empty: take it away."""
        self._sentences.note(text)
        self._call(self._show, text)

    def close(self) -> None:
        """Disconnect all programs."""
        with contextlib.suppress(TimeoutError):
            self._wait(self._shut())
        self._end()

    def _call(self, work: Callable[[*Ts], None], *arguments: *Ts) -> None:
        """Have the server's thread do something."""
        self._loop.call_soon_threadsafe(work, *arguments)

    def _wait(self, work: Coroutine[Any, Any, T]) -> T:
        return asyncio.run_coroutine_threadsafe(work, self._loop).result(_START_S)

    def _end(self) -> None:
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(_START_S)
        self._loop.close()

    async def _open(self) -> Server:
        settings = self._settings
        tls = None
        if settings.certificate is not None:
            tls = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
            tls.load_cert_chain(settings.certificate, settings.key)
        # What programs send wrong is answered to them; here it would flood the log.
        quiet = logging.getLogger("hub.doors.foxglove.websockets")
        quiet.setLevel(logging.CRITICAL)
        why = "more connections than may wait without a request"
        self._entrance = Entrance(
            "127.0.0.1" if settings.host == "localhost" else settings.host,
            settings.port,
            lambda: self._faults.count("refused connection", why),
        )
        return await serve(
            self._follow,
            sock=self._entrance,
            ssl=tls,
            process_request=self._admit,
            subprotocols=[Subprotocol(each) for each in wire.SUBPROTOCOLS],
            compression=None,
            server_header=PANEL_DOOR_SERVER,
            open_timeout=settings.handshake_s,
            ping_interval=_PING_EVERY_S,
            ping_timeout=_PONG_S,
            close_timeout=_CLOSE_S,
            max_size=_MOST_FRAME,
            logger=quiet,
        )

    async def _shut(self) -> None:
        self._server.close()
        await self._server.wait_closed()

    def _admit(self, connection: ServerConnection, request: Request) -> Response | None:
        """Refuse programs and pages without the key."""
        headers = request.headers
        why = self._rules.refusal(request.path, headers.get_all("Host"), headers.get_all("Origin"))
        status = http.HTTPStatus.FORBIDDEN
        if not why and len(self._viewers) >= _MOST_VIEWERS:
            status = http.HTTPStatus.SERVICE_UNAVAILABLE
            why = f"{_MOST_VIEWERS} programs are connected already"
        if not why:
            return None
        self._faults.count("refused connection", why)
        return connection.respond(status, f"{why}\n")

    async def _follow(self, connection: ServerConnection) -> None:
        """Serve one program until it leaves."""
        self._entrance.admit(connection.remote_address)
        viewer = Viewer(next(self._viewer_numbers), connection)
        self._viewers[viewer.number] = viewer
        info = wire.server_info(self._settings.name, self._session, drive=self._settings.drive)
        viewer.say(info)
        if self._topics:
            viewer.say(wire.channels(self._topics))
        if self._said:
            viewer.say(wire.status(self._said))
        writer = asyncio.create_task(viewer.write())
        try:
            while True:
                frame = await connection.recv()
                self._take(viewer, frame)
                await asyncio.sleep(0.0)  # a flood of one leaves time for others
        except ConnectionClosed:
            pass
        finally:
            writer.cancel()
            with contextlib.suppress(asyncio.CancelledError, ConnectionClosed):
                await writer
            del self._viewers[viewer.number]
            self._asked.leave(viewer.number)

    def _take(self, viewer: Viewer, frame: str | bytes) -> None:
        if isinstance(frame, bytes):
            found = wire.read_data(frame)
            if found is not None:
                self._asked.command((viewer.number, found[0]), found[1])
            return
        try:
            values = wire.read_text(frame.encode())
        except RosMessageError as error:
            self._faults.count("unreadable text", str(error)[:200])
            return
        op = values.get("op")
        work = self._orders.get(op) if isinstance(op, str) else None
        if work is not None:
            work(viewer, values)

    def _subscribe(self, viewer: Viewer, values: dict[str, Any]) -> None:
        for subscription, channel in wire.subscriptions(values):
            if channel in self._topics and viewer.subscribe(subscription, channel):
                self._asked.watch(viewer.number, channel)

    def _unsubscribe(self, viewer: Viewer, values: dict[str, Any]) -> None:
        for subscription in wire.numbers(values, "subscriptionIds"):
            channel = viewer.unsubscribe(subscription)
            if channel is not None:
                self._asked.unwatch(viewer.number, channel)

    def _advertise(self, viewer: Viewer, values: dict[str, Any]) -> None:
        for each in wire.panel_channels(values):
            self._asked.panel(viewer.number, each)

    def _unadvertise(self, viewer: Viewer, values: dict[str, Any]) -> None:
        for number in wire.numbers(values, "channelIds"):
            self._asked.panel_gone((viewer.number, number))

    def _answer(self, viewer: Viewer, values: dict[str, Any]) -> None:
        """Say parameters as they are; setting one changes nothing."""
        asked = wire.names(values, "parameterNames")
        facts = {name: each for name, each in self._facts.items() if not asked or name in asked}
        viewer.say(wire.parameters(facts, values.get("id")))

    def _offer(self, number: int, topic: RecordedTopic) -> None:
        self._topics[number] = topic
        self._say_to_all(wire.channels({number: topic}))

    def _withdraw(self, number: int) -> None:
        del self._topics[number]
        for viewer in self._viewers.values():
            if viewer.drop(number):
                self._asked.unwatch(viewer.number, number)
        self._say_to_all(wire.gone_channel(number))

    def _pass_on(self, number: int, payload: bytes, stamp: int) -> None:
        for viewer in self._viewers.values():
            subscription = viewer.subscription_to(number)
            if subscription is not None:
                viewer.give(wire.data(subscription, stamp, payload))

    def _set_facts(self, facts: wire.Facts) -> None:
        self._facts = facts
        self._say_to_all(wire.parameters(facts))

    def _show(self, text: str) -> None:
        self._said = text
        self._say_to_all(wire.status(text))

    def _say_to_all(self, text: str) -> None:
        for viewer in self._viewers.values():
            viewer.say(text)


def _words(error: OSError, settings: ServerSettings) -> str:
    """Why the server cannot be opened, and what to do."""
    busy = "in use" in str(error)
    reason = "another program listens there" if busy else str(error)
    other = "--port" if busy else "--host, --port or TLS file"
    return (
        f"panels cannot be served on {settings.host} port {settings.port}: {reason}; give "
        f"another {other}"
    )
