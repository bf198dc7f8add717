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
    RedefinedMessageError,
)
from hub.ipc import control, description, frames, security, sockets
from hub.ipc.age import AgeEstimator
from hub.ipc.broadcast import Broadcasts, Reception, decode, reception
from hub.ipc.chores import Posted, Timers
from hub.ipc.complaints import Complaints
from hub.ipc.definition import MessageDefinition
from hub.ipc.questions import Question, Questions

_logger = logging.getLogger(__name__)

T = TypeVar("T")
R = TypeVar("R")

PING_S = 0.5
LOST_S = 1.5
"""Central has not answered for this long: the connection counts as lost [s]."""
RETRY_S = 0.02
"""How soon a hello is tried again while there is no connection at all [s]."""
_BATCH = 256


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
        self.endpoint = security.connectable(endpoint)
        self._tcp_host = self.endpoint.rpartition(":")[0]
        self.complaints = Complaints(_logger, clock)
        self.refusal: HubError | None = None
        self._clock = clock
        self._context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
        self._epoch = 0
        self._joined = (0, 0)
        self._publisher = 0
        self._heard = -1e9
        self._next_ping = 0.0
        self._definitions: dict[str, MessageDefinition[Any]] = {}
        self._refused: dict[str, HubError] = {}
        self._confirmed: set[str] = set()
        self._responders: dict[str, Callable[[frames.Frame], list[Any]]] = {}
        self._questions = Questions()
        self._listings: list[control.Listing] = []
        self._published: collections.Counter[str] = collections.Counter()
        self._attached: collections.Counter[str] = collections.Counter()
        self._prefixes: dict[str, bytes] = {}
        self._ages = AgeEstimator()
        self._timers = Timers()
        self._posted = Posted()
        self._poller = zmq.Poller()
        self._poller.register(self._posted.file, zmq.POLLIN)
        self._files: dict[int, Callable[[], None]] = {}
        self._broadcasts = Broadcasts(
            self._context, self._poller, self._ages, self.complaints, clock
        )
        self._control = sockets.make(self._context, zmq.DEALER, 1000)
        sockets.connect(self._control, self.endpoint)
        self._poller.register(self._control, zmq.POLLIN)

    @property
    def connected(self) -> bool:
        """Whether central knows us and has answered lately."""
        return self._publisher > 0 and self._clock() - self._heard < LOST_S

    def wait_connected(
        self, timeout: float, *, give_up: Callable[[], bool] = lambda: False
    ) -> None:
        """Serve until central has welcomed us, or `give_up` says that nobody wants it any more.

        Raises:
            CentralUnreachableError: It did not within `timeout` [s].
            NameTakenError: Another live module has our name.
        """
        deadline = self._clock() + timeout
        while not self.connected and not give_up():
            if self.refusal is not None:
                raise self.refusal
            left = deadline - self._clock()
            if left <= 0:
                text = f"no hub answers at {self.endpoint}; is rune-hub running there?"
                raise CentralUnreachableError(text)
            self.listen(min(left, 0.1))

    def define(self, *definitions: MessageDefinition[Any]) -> None:
        """Make messages known at central; whoever publishes, subscribes or answers defines.

        Raises:
            RedefinedMessageError: We have defined one with another format ourselves.
        """
        for definition in definitions:
            known = self._definitions.get(definition.name)
            if known is not None and known.fingerprint != definition.fingerprint:
                both = f"{known.format} and as {definition.format}"
                text = f"{self.name} uses {definition.name} as {both}; keep to one"
                raise RedefinedMessageError(text)
            if known is None:
                self._definitions[definition.name] = definition
                self._prefixes[definition.name] = frames.prefix(definition.name)
                if self._publisher:
                    self._tell(description.to_listing(definition))

    def wait_defined(self, timeout: float, *, give_up: Callable[[], bool] = lambda: False) -> None:
        """Serve until central has confirmed all our definitions, or `give_up` says to stop waiting.

        Raises:
            RedefinedMessageError: One is defined with another format.
            CentralUnreachableError: Central did not answer within `timeout` [s].
        """
        deadline = self._clock() + timeout
        while not (self._confirmed.issuperset(self._definitions) or give_up()):
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
        frame = self._pack(definition, value, measured, self._published)
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
        question = Question(
            name=request.name,
            read=lambda frame: decode(response, frame),
            timeout=timeout,
            deadline=self._clock() + timeout,
            answered=answered,
            failed=failed,
        )
        self._ask(request, value, question)

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
        frame = self.query_frame(request, value, timeout=timeout)
        try:
            answer: R = decode(response, frame)
        except CodecError as error:
            raise HandlerFailedError(str(error)) from error
        return answer

    def query_frame(
        self, request: MessageDefinition[T], value: T, *, timeout: float
    ) -> frames.Frame:
        """As `query_response`, for whoever does not know what message the answer will be."""
        self.define(request)
        answers: list[frames.Frame] = []
        failures: list[QueryError] = []
        question = Question(
            name=request.name,
            read=lambda frame: frame,
            timeout=timeout,
            deadline=self._clock() + timeout,
            answered=lambda frame, _: answers.append(frame),
            failed=failures.append,
        )
        self._ask(request, value, question)
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
        self._timers.add(self._clock(), period, work)

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
        self._posted.add(work)

    def listen(self, timeout: float) -> None:
        """Wait for up to `timeout` [s] and serve what has come: messages, timers, posted work."""
        ready = dict(self._poller.poll(math.ceil(self._wait(timeout) * 1e3)))
        if self._posted.file in ready:
            self._posted.drain()
        self._posted.run()
        for file in list(self._files):
            if file in ready and file in self._files:
                self._files[file]()
        self._broadcasts.receive(ready)
        if self._control in ready:
            self._receive_control()
        self._timers.run(self._clock())
        self._keep_alive()

    def close(self) -> None:
        """Say goodbye and free everything; nothing is sent afterwards."""
        if self._context.closed:
            return
        if self._publisher:
            self._tell(control.Bye())
            self._control.linger = 200
        self._broadcasts.close(linger_ms=100)
        self._control.close()
        self._context.term()
        self._posted.close()

    def _wait(self, timeout: float) -> float:
        """How long nothing needs to be done, up to `timeout` [s]."""
        if self._posted or self._broadcasts.waiting:
            return 0.0
        now = self._clock()
        end = now + timeout
        wake = min(end, self._next_ping, self._timers.due(end), self._questions.due(end))
        return max(0.0, wake - now)

    def _pack(
        self,
        definition: MessageDefinition[Any],
        value: Any,
        measured: float | None,
        counter: collections.Counter[str],
    ) -> bytes:
        payload = definition.encode(value)
        # Counted only now, and apart from queries: a gap means that a broadcast did not come.
        counter[definition.name] += 1
        return frames.pack(
            self._prefixes[definition.name],
            publisher=self._publisher,
            fingerprint=definition.fingerprint,
            sequence=counter[definition.name],
            stamp_ns=int((self._clock() if measured is None else measured) * 1e9),
            payload=payload,
        )

    def _ask(self, request: MessageDefinition[Any], value: Any, question: Question) -> None:
        frame = self._pack(request, value, None, self._attached)
        number = self._questions.add(question)
        query = control.Query(number=number, name=request.name, timeout_s=question.timeout)
        if not self._publisher or not self._tell(query, frame):
            self._questions.not_sent(number)

    def _tell(self, message: Any, attached: bytes | None = None) -> bool:
        parts = [control.pack(message)] + ([] if attached is None else [attached])
        try:
            self._control.send_multipart(parts, zmq.NOBLOCK)
        except zmq.Again:
            if not isinstance(message, control.Hello):
                self.complaints.count("not sent", "there is no connection to central now")
            return False
        return True

    def _keep_alive(self) -> None:
        now = self._clock()
        self._questions.expire(now, self.endpoint)
        if now < self._next_ping:
            return
        self._next_ping = now + PING_S
        if now - self._heard > LOST_S and self._publisher:
            # Whatever is queued for a central that does not answer would arrive too late.
            self._forget_central()
        if self._publisher:
            self._tell(control.Ping(epoch=self._epoch))
        elif not self._tell(control.Hello(name=self.name, pid=os.getpid())):
            self._next_ping = now + RETRY_S

    def _forget_central(self) -> None:
        self._publisher = 0
        self._confirmed.clear()
        self._poller.unregister(self._control)
        self._control.close()
        self._control = sockets.make(self._context, zmq.DEALER, 1000)
        sockets.connect(self._control, self.endpoint)
        self._poller.register(self._control, zmq.POLLIN)
        self._questions.end_all(f"the hub at {self.endpoint} does not answer")

    def _receive_control(self) -> None:
        for _ in range(_BATCH):
            try:
                parts = self._control.recv_multipart(zmq.NOBLOCK)
            except zmq.Again:
                return
            try:
                message = control.unpack(parts[0])
            except (FrameError, CodecError) as error:
                self.complaints.count("malformed control frame", str(error))
                continue
            self._handle(message, parts[1] if len(parts) > 1 else None)

    def _handle(self, message: Any, attached: bytes | None) -> None:
        self._heard = self._clock()
        if isinstance(message, control.Welcome):
            self._welcome(message)
        elif isinstance(message, control.Stranger):
            self._publisher = 0
            self._next_ping = 0.0
            self._questions.end_all(f"the hub at {self.endpoint} was started again")
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
        self._epoch = message.epoch
        if self._joined != (message.epoch, message.publisher):
            # Central knew us no more: what lies in the old connections is from before that.
            self._joined = (message.epoch, message.publisher)
            self._confirmed.clear()
            self._refused.clear()
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
        if message.error in ("NameTakenError", "CentralUnreachableError"):
            self.refusal = getattr(hub.errors, message.error)(message.text)
        else:
            self._refused[message.subject] = RedefinedMessageError(message.text)
        self.complaints.count("refused by central", message.text)

    def _answer(self, message: control.Query, attached: bytes | None) -> None:
        responder = self._responders.get(message.name)
        asked = self._clock()  # what the answer says was measured from now on, not when it is sent
        try:
            if responder is None or attached is None:
                text = f"{self.name} does not answer {message.name}"
                raise HandlerFailedError(text)
            definition, value = responder(frames.unpack(attached))
            answer = self._pack(definition, value, asked, self._attached)
        except HubError as error:
            self._tell(_failure(message.number, str(error)))
            return
        except Exception as error:
            self._tell(_failure(message.number, f"{self.name} failed at {message.name}: {error!r}"))
            raise
        self._tell(control.Response(number=message.number), answer)

    def _conclude(
        self, message: control.Response | control.Failure, attached: bytes | None
    ) -> None:
        def received(frame: frames.Frame) -> Reception:
            return reception(frame, self._ages, self._clock())

        if not self._questions.conclude(message, attached, received):
            self.complaints.count("late answer", "nobody waits for it any more")


def _failure(number: int, text: str) -> control.Failure:
    """That a query ended without an answer, in a text that can be sent whatever is in it."""
    sayable = text.replace("\0", "?").encode(errors="replace").decode()
    return control.Failure(number=number, error="HandlerFailedError", text=sayable)
