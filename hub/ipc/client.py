"""A module's connection to central: define, publish, subscribe, query, respond, timers.

One thread owns a client and calls everything but `post`, which any thread may call. The connection
mends itself: when central comes back, the client says hello, defines and handles again.
"""

from __future__ import annotations

import collections
import logging
import math
import os
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

import zmq

import hub.errors
from hub.errors import (
    CentralUnreachableError,
    CodecError,
    FrameError,
    HandlerFailedError,
    HubError,
    QueryError,
    QueryTimeoutError,
)
from hub.ipc import control, description, frames, security, sockets
from hub.ipc.age import AgeEstimator
from hub.ipc.broadcast import Broadcasts, Reception, decode, reception
from hub.ipc.complaints import Complaints
from hub.ipc.definition import MessageDefinition

_logger = logging.getLogger(__name__)

T = TypeVar("T")
R = TypeVar("R")

PING_S = 0.5
LOST_S = 1.5
"""Central has not answered for this long: the connection counts as lost [s]."""
_BATCH = 256


@dataclass(slots=True)
class _Timer:
    due: float
    period: float
    work: Callable[[], None]


@dataclass(slots=True)
class _Waiting:
    name: str
    read: Callable[[frames.Frame], Any]
    deadline: float
    timeout: float
    answered: Callable[[Any, Reception], None]
    failed: Callable[[QueryError], None]


class Client:
    """A connection to one central under a unique name.

    Attributes:
        name: The name.
        endpoint: Where central is.
        complaints: What was dropped, by reason.
        refusal: Why central refused to connect us, if it did.
    """

    def __init__(
        self,
        name: str,
        endpoint: str = security.DEFAULT_ENDPOINT,
        *,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Start connecting; this never waits.

        Raises:
            EndpointError: The endpoint is malformed or not on this machine.
        """
        self.name = name
        self.endpoint = str(security.parse_endpoint(endpoint))
        self._tcp_host = self.endpoint.rpartition(":")[0]
        self.complaints = Complaints(_logger, clock)
        self.refusal: hub.errors.HubError | None = None
        self._clock = clock
        self._context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
        self._epoch = 0
        self._publisher = 0
        self._heard = -1e9
        self._next_ping = 0.0
        self._definitions: dict[str, MessageDefinition[Any]] = {}
        self._refused: dict[str, HubError] = {}
        self._confirmed: set[str] = set()
        self._responders: dict[str, Callable[[frames.Frame], list[Any]]] = {}
        self._waiting: dict[int, _Waiting] = {}
        self._listings: list[control.Listing] = []
        self._sequences: collections.Counter[str] = collections.Counter()
        self._prefixes: dict[str, bytes] = {}
        self._ages = AgeEstimator()
        self._timers: list[_Timer] = []
        self._queries = 0
        self._posted: collections.deque[Callable[[], None]] = collections.deque()
        self._wake_read, self._wake_write = os.pipe()
        os.set_blocking(self._wake_read, False)
        os.set_blocking(self._wake_write, False)
        self._poller = zmq.Poller()
        self._poller.register(self._wake_read, zmq.POLLIN)
        self._files: dict[int, Callable[[], None]] = {}
        self._broadcasts = Broadcasts(
            self._context, self._poller, self._ages, self.complaints, clock
        )
        self._control = sockets.make(self._context, zmq.DEALER, 1000)
        self._control.connect(self.endpoint)
        self._poller.register(self._control, zmq.POLLIN)

    @property
    def connected(self) -> bool:
        """Whether central knows us and has answered lately."""
        return self._publisher > 0 and self._clock() - self._heard < LOST_S

    def wait_connected(self, timeout: float) -> None:
        """Serve until central has welcomed us.

        Raises:
            CentralUnreachableError: It did not within `timeout` [s].
            NameTakenError: Another live module has our name.
        """
        deadline = self._clock() + timeout
        while not self.connected:
            if self.refusal is not None:
                raise self.refusal
            left = deadline - self._clock()
            if left <= 0:
                text = f"no hub answers at {self.endpoint}; is rune-hub running there?"
                raise CentralUnreachableError(text)
            self.listen(min(left, 0.1))

    def define(self, *definitions: MessageDefinition[Any]) -> None:
        """Make messages known at central; whoever publishes, subscribes or answers defines."""
        for definition in definitions:
            if definition.name not in self._definitions:
                self._definitions[definition.name] = definition
                self._prefixes[definition.name] = frames.prefix(definition.name)
                if self._publisher:
                    self._tell(description.to_listing(definition))

    def wait_defined(self, timeout: float) -> None:
        """Serve until central has confirmed all our definitions.

        Raises:
            RedefinedMessageError: One is defined with another format.
            CentralUnreachableError: Central did not answer within `timeout` [s].
        """
        deadline = self._clock() + timeout
        while not self._confirmed.issuperset(self._definitions):
            for error in self._refused.values():
                raise error
            if self._clock() > deadline:
                text = f"the hub at {self.endpoint} does not confirm definitions"
                raise CentralUnreachableError(text)
            self.listen(0.05)

    def publish(
        self, definition: MessageDefinition[T], value: T, *, measured: float | None = None
    ) -> None:
        """Broadcast to all who subscribe; never waits, lost without central.

        Args:
            definition: Which message.
            value: Its value.
            measured: When its content was measured, on the monotonic clock [s]; default now.

        Raises:
            CodecError: The value does not fit the format.
        """
        self.define(definition)
        frame = self._pack(definition, value, measured)
        if self._publisher:
            self._broadcasts.send(definition, frame)

    def subscribe(
        self, definition: MessageDefinition[T], handler: Callable[[T, Reception], None]
    ) -> None:
        """Call `handler` for every message of it; several handlers are called in turn."""
        self.define(definition)
        self._broadcasts.subscribe(definition, handler)

    def respond(
        self,
        request: MessageDefinition[T],
        response: MessageDefinition[R],
        handler: Callable[[T], R],
    ) -> None:
        """Answer queries of `request`; a HubError from the handler is told to who asked."""
        self.define(request, response)

        def answer(frame: frames.Frame) -> list[Any]:
            return [response, handler(decode(request, frame))]

        self._responders[request.name] = answer
        if self._publisher:
            self._tell(control.Handle(name=request.name))

    def query_notify(
        self,
        request: MessageDefinition[T],
        value: T,
        response: MessageDefinition[R],
        *,
        timeout: float,
        answered: Callable[[R, Reception], None],
        failed: Callable[[QueryError], None],
    ) -> None:
        """Ask; exactly one of `answered` and `failed` is called later, from `listen`."""
        self.define(request, response)
        waiting = _Waiting(
            request.name,
            lambda frame: decode(response, frame),
            self._clock() + timeout,
            timeout,
            answered,
            failed,
        )
        self._ask(request, value, waiting)

    def query_response(
        self,
        request: MessageDefinition[T],
        value: T,
        response: MessageDefinition[R],
        *,
        timeout: float,
    ) -> R:
        """Ask and serve everything else until the answer is there.

        Raises:
            QueryError: No handler, it died or failed, or the time ran out.
        """
        self.define(response)
        answer: R = decode(response, self.query_frame(request, value, timeout=timeout))
        return answer

    def query_frame(
        self, request: MessageDefinition[T], value: T, *, timeout: float
    ) -> frames.Frame:
        """As `query_response`, for whoever does not know what message the answer will be."""
        self.define(request)
        answers: list[frames.Frame] = []
        failures: list[QueryError] = []
        waiting = _Waiting(
            request.name,
            lambda frame: frame,
            self._clock() + timeout,
            timeout,
            lambda frame, _: answers.append(frame),
            failures.append,
        )
        self._ask(request, value, waiting)
        while not answers and not failures:
            self.listen(0.1)
        if failures:
            raise failures[0]
        return answers[0]

    def listing(self, timeout: float) -> control.Listing:
        """All that central knows.

        Raises:
            CentralUnreachableError: It did not answer within `timeout` [s].
        """
        self._listings.clear()
        self._tell(control.List())
        deadline = self._clock() + timeout
        while not self._listings:
            if self._clock() > deadline:
                text = f"the hub at {self.endpoint} does not answer"
                raise CentralUnreachableError(text)
            self.listen(0.1)
        return self._listings[-1]

    def every(self, period: float, work: Callable[[], None]) -> None:
        """Call `work` every `period` [s] from `listen`; late calls are skipped, not made up for."""
        self._timers.append(_Timer(self._clock() + period, period, work))

    def watch(self, file: int, work: Callable[[], None]) -> None:
        """Call `work` from `listen` whenever the file descriptor is readable."""
        self._files[file] = work
        self._poller.register(file, zmq.POLLIN)

    def unwatch(self, file: int) -> None:
        """Stop watching a file descriptor."""
        del self._files[file]
        self._poller.unregister(file)

    def post(self, work: Callable[[], None]) -> None:
        """Have `work` called from `listen`; the one method that any thread may call."""
        self._posted.append(work)
        try:
            os.write(self._wake_write, b"\0")
        except BlockingIOError:
            pass  # the pipe is full of wake-ups already
        except OSError:
            _logger.debug("posted to a closed client")

    def listen(self, timeout: float) -> None:
        """Wait for up to `timeout` [s] and serve what has come: messages, timers, posted work."""
        now = self._clock()
        wake = min((timer.due for timer in self._timers), default=now + timeout)
        wait = max(0.0, min(timeout, wake - now, self._next_ping - now))
        ready = dict(self._poller.poll(math.ceil(wait * 1e3)))
        if self._wake_read in ready:
            self._drain_wake()
        while self._posted:
            self._posted.popleft()()
        for file, work in list(self._files.items()):
            if file in ready:
                work()
        self._broadcasts.receive(ready)
        if self._control in ready:
            self._receive_control()
        self._run_timers()
        self._keep_alive()

    def close(self) -> None:
        """Say goodbye and free everything; nothing is sent afterwards."""
        if self._publisher:
            self._tell(control.Bye())
            self._control.linger = 200
        self._broadcasts.close(linger_ms=100)
        self._control.close()
        self._context.term()
        os.close(self._wake_read)
        os.close(self._wake_write)

    def _pack(
        self, definition: MessageDefinition[Any], value: Any, measured: float | None
    ) -> bytes:
        self._sequences[definition.name] += 1
        return frames.pack(
            self._prefixes[definition.name],
            publisher=self._publisher,
            fingerprint=definition.fingerprint,
            sequence=self._sequences[definition.name],
            stamp_ns=int((self._clock() if measured is None else measured) * 1e9),
            payload=definition.encode(value),
        )

    def _ask(self, request: MessageDefinition[Any], value: Any, waiting: _Waiting) -> None:
        self._queries = self._queries % 0xFFFF_FFFF + 1
        self._waiting[self._queries] = waiting
        query = control.Query(number=self._queries, name=request.name, timeout_s=waiting.timeout)
        self._tell(query, self._pack(request, value, None))

    def _tell(self, message: Any, attached: bytes | None = None) -> None:
        parts = [control.pack(message)] + ([] if attached is None else [attached])
        try:
            self._control.send_multipart(parts, zmq.NOBLOCK)
        except zmq.Again:
            self.complaints.count("not sent", "the queue to central is full")

    def _keep_alive(self) -> None:
        now = self._clock()
        for number in [n for n, waiting in self._waiting.items() if waiting.deadline < now]:
            waiting = self._waiting.pop(number)
            text = f"no answer to the query {waiting.name} in {waiting.timeout:g} s"
            waiting.failed(QueryTimeoutError(text))
        if now < self._next_ping:
            return
        self._next_ping = now + PING_S
        if now - self._heard > LOST_S and self._publisher:
            # Whatever is queued for a central that does not answer would arrive too late.
            self._forget_central()
        if self._publisher:
            self._tell(control.Ping(epoch=self._epoch))
        else:
            self._tell(control.Hello(name=self.name, pid=os.getpid()))

    def _forget_central(self) -> None:
        self._publisher = 0
        self._confirmed.clear()
        for number in list(self._waiting):
            waiting = self._waiting.pop(number)
            waiting.failed(QueryTimeoutError(f"the hub at {self.endpoint} does not answer"))
        self._poller.unregister(self._control)
        self._control.close()
        self._control = sockets.make(self._context, zmq.DEALER, 1000)
        self._control.connect(self.endpoint)
        self._poller.register(self._control, zmq.POLLIN)

    def _drain_wake(self) -> None:
        try:
            while os.read(self._wake_read, 4096):
                pass
        except BlockingIOError:
            pass

    def _run_timers(self) -> None:
        now = self._clock()
        for timer in self._timers:
            if timer.due <= now:
                timer.due = max(timer.due + timer.period, now)
                timer.work()

    def _receive_control(self) -> None:
        for _ in range(_BATCH):
            try:
                parts = self._control.recv_multipart(zmq.NOBLOCK)
            except zmq.Again:
                return
            try:
                message = control.unpack(parts[0])
                self._handle(message, parts[1] if len(parts) > 1 else None)
            except (FrameError, CodecError) as error:
                self.complaints.count("malformed control frame", str(error))

    def _handle(self, message: Any, attached: bytes | None) -> None:
        self._heard = self._clock()
        if isinstance(message, control.Welcome):
            self._welcome(message)
        elif isinstance(message, control.Stranger):
            self._publisher = 0
            self._next_ping = 0.0
        elif isinstance(message, control.Refused):
            self._refuse(message)
        elif isinstance(message, control.Defined):
            self._confirmed.add(message.name)
        elif isinstance(message, control.Query):
            self._answer(message, attached)
        elif isinstance(message, (control.Response, control.Failure)):
            self._conclude(message, attached)
        elif isinstance(message, control.Listing):
            self._listings.append(message)

    def _welcome(self, message: control.Welcome) -> None:
        self.refusal = None
        self._publisher = message.publisher
        if message.epoch != self._epoch:
            self._epoch = message.epoch
            self._broadcasts.connect([self._address(message, place) for place in range(4)])
        for definition in self._definitions.values():
            self._tell(description.to_listing(definition))
        for name in self._responders:
            self._tell(control.Handle(name=name))

    def _address(self, message: control.Welcome, place: int) -> str:
        if self.endpoint.startswith("ipc://"):
            return f"ipc://{message.paths[place]}"
        return f"{self._tcp_host}:{message.ports[place]}"

    def _refuse(self, message: control.Refused) -> None:
        kind = getattr(hub.errors, message.error, CentralUnreachableError)
        if kind is hub.errors.MessageFormatError:
            kind = hub.errors.RedefinedMessageError
        error = kind(message.text)
        if message.subject == self.name:
            self.refusal = error
        else:
            self._refused[message.subject] = error
        self.complaints.count("refused by central", message.text)

    def _answer(self, message: control.Query, attached: bytes | None) -> None:
        responder = self._responders.get(message.name)
        asked = self._clock()  # what the answer says was measured from now on, not when it is sent
        try:
            if responder is None or attached is None:
                text = f"{self.name} does not answer {message.name}"
                raise HandlerFailedError(text)
            definition, value = responder(frames.unpack(attached))
            answer = self._pack(definition, value, asked)
        except HubError as error:
            failure = control.Failure(
                number=message.number, error="HandlerFailedError", text=str(error)
            )
            self._tell(failure)
            return
        self._tell(control.Response(number=message.number), answer)

    def _conclude(
        self, message: control.Response | control.Failure, attached: bytes | None
    ) -> None:
        waiting = self._waiting.pop(message.number, None)
        if waiting is None:
            self.complaints.count("late answer", "nobody waits for it any more")
        elif isinstance(message, control.Failure) or attached is None:
            text = message.text if isinstance(message, control.Failure) else "an empty answer"
            kind = getattr(hub.errors, getattr(message, "error", ""), HandlerFailedError)
            valid = isinstance(kind, type) and issubclass(kind, QueryError)
            waiting.failed(kind(text) if valid else HandlerFailedError(text))
        else:
            try:
                frame = frames.unpack(attached)
                value = waiting.read(frame)
            except (FrameError, CodecError) as error:
                waiting.failed(HandlerFailedError(str(error)))
                return
            waiting.answered(value, reception(frame, self._ages, self._clock()))
