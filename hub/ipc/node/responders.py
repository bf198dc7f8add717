"""The queries that a client answers, at once or later."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, Generic, TypeVar

from hub.errors import HandlerFailedError, HubError, NoValueError
from hub.ipc.definition import MessageDefinition
from hub.ipc.message_info import decode
from hub.ipc.node.connection import Connection
from hub.ipc.node.direct_queries import DirectResponder
from hub.ipc.wire import control, frames

R = TypeVar("R")

Pack = Callable[[MessageDefinition[Any], Any, float], bytes]


class Reply(Generic[R]):
    """Answers one query, once, at any time before it times out.

    Attributes:
        asker: The asker's number at central, as in frame headers.
    """

    def __init__(self, asker: int, respond: Callable[[R, float | None], None], fail: Fail) -> None:
        self.asker = asker
        self._respond = respond
        self._fail = fail

    def answer(self, value: R, *, measured: float | None = None) -> None:
        """Answer; central drops a second answer.

        Args:
            value: The answer.
            measured: Time of its measurement, on the monotonic clock [s]; default: arrival of the
            query.

        Raises:
            CodecError: The value does not fit the format; the asker gets this error too.
        """
        try:
            self._respond(value, measured)
        except HubError as error:
            self._fail("HandlerFailedError", str(error))
            raise

    def fail(self, why: str) -> None:
        """Answer with an error."""
        self._fail("HandlerFailedError", why)


class FrameReply:
    """Ends one query with a frame or an error, once, at any time before it times out.

    Attributes:
        timeout: How long the asker waits [s].
    """

    def __init__(self, number: int, timeout: float, send: SendControl) -> None:
        self.timeout = timeout
        self._number = number
        self._send = send

    def answer(self, frame: bytes) -> None:
        """Answer with a whole frame."""
        self._send(control.Response(number=self._number), frame)

    def fail(self, error: str, text: str) -> None:
        """Answer with an error: its class in `hub.errors`, and a sentence."""
        _fail(self._send, self._number, error, text)


Fail = Callable[[str, str], None]
SendControl = Callable[[Any, bytes | None], object]
_Responder = Callable[[frames.Frame, control.Query, float, SendControl], None]
AnswerLast = Callable[[str, FrameReply], None]
"""Answers a question for the last value of the message of this name."""


class Responders:
    """All queries that one client answers.

    Attributes:
        last_by: Answers questions for last values; None: the client's own publishers do.
    """

    def __init__(
        self,
        name: str,
        connection: Connection,
        pack: Pack,
        last: Callable[[str], bytes | None],
        clock: Callable[[], float],
    ) -> None:
        """Answer nothing yet.

        Args:
            name: Of the client.
            connection: Sends the answers.
            pack: Makes the frame of a value, with the time of its measurement [s].
            last: The last published message of a name, as a frame.
            clock: Monotonic time [s].
        """
        self._name = name
        self._connection = connection
        self._pack = pack
        self._last = last
        self._clock = clock
        self.last_by: AnswerLast | None = None
        self._responders: dict[str, _Responder] = {}
        self._direct_responder: DirectResponder | None = None

    def add(
        self,
        request: MessageDefinition[Any],
        response: MessageDefinition[R],
        handler: Callable[[Any, Reply[R]], None],
    ) -> None:
        """Let `handler` answer queries of `request`, at once or later."""

        def answer(
            frame: frames.Frame, query: control.Query, asked: float, send: SendControl
        ) -> None:
            number = query.number

            def respond(value: R, measured: float | None) -> None:
                when = asked if measured is None else measured
                send(control.Response(number=number), self._pack(response, value, when))

            fail = functools.partial(_fail, send, number)
            handler(decode(request, frame), Reply(frame.publisher, respond, fail))

        self._responders[request.name] = answer
        self._announce(request.name)

    def add_frames(self, name: str, handler: Callable[[frames.Frame, FrameReply], None]) -> None:
        """Let `handler` answer queries of this name, undecoded."""
        self._responders[name] = lambda frame, query, _, send: handler(
            frame, FrameReply(query.number, query.timeout_s, send)
        )
        self._announce(name)

    def announce_all(self) -> None:
        """Announce all at a central that has the definitions."""
        for name in self._responders:
            self._announce(name)

    def use_direct_responder(self, direct_responder: DirectResponder | None) -> None:
        """Take queries directly too, or only through central, at a new connection to it."""
        if direct_responder is not None:
            direct_responder.renew_key()
        self._direct_responder = direct_responder

    def answer(self, query: control.Query, attached: bytes | None) -> None:
        """Handle a query from central."""
        self._answer(query, attached, self._connection.send)

    def answer_directly(self, query: control.Query, attached: bytes, asker: bytes) -> None:
        """Handle a query from a client on this machine."""
        if self._direct_responder is not None:
            self._answer(query, attached, functools.partial(self._direct_responder.answer, asker))

    def _answer(self, query: control.Query, attached: bytes | None, send: SendControl) -> None:
        asked = self._clock()  # the answer counts as measured now, even if it is sent later
        responder = self._responders.get(query.name)
        try:
            if responder is None or attached is None:
                text = f"{self._name} does not answer {query.name}"
                raise HandlerFailedError(text)
            responder(frames.unpack(attached), query, asked, send)
        except HubError as error:
            _fail(send, query.number, "HandlerFailedError", str(error))
        except Exception as error:
            text = f"{self._name} failed at {query.name}: {error!r}"
            _fail(send, query.number, "HandlerFailedError", text)
            raise

    def answer_last(self, query: control.Last) -> None:
        """Answer with the last value that this client published, or as `last_by` says."""
        if self.last_by is not None:
            reply = FrameReply(query.number, query.timeout_s, self._connection.send)
            self.last_by(query.name, reply)
            return
        frame = self._last(query.name)
        if frame is None:
            text = f"{self._name} has published no {query.name} yet"
            _fail(self._connection.send, query.number, NoValueError.__name__, text)
        else:
            self._connection.send(control.Response(number=query.number), frame)

    def _announce(self, name: str) -> None:
        if self._connection.publisher:
            direct = self._direct_responder
            address, key = (direct.address, direct.tickets.key) if direct else ("", "")
            self._connection.send(control.Handle(name=name, on=True, address=address, key=key))


def _fail(send: SendControl, number: int, error: str, text: str) -> None:
    """Send an error, without unsendable characters."""
    text = text.replace("\0", "?").encode(errors="replace").decode()
    send(control.Failure(number=number, error=error, text=text), None)
