"""A client's answers to queries: now, or later."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Generic, TypeVar

from hub.errors import HandlerFailedError, HubError, NoValueError
from hub.ipc import control, frames
from hub.ipc.connection import Connection
from hub.ipc.definition import MessageDefinition
from hub.ipc.reception import decode

R = TypeVar("R")

Pack = Callable[[MessageDefinition[Any], Any, float], bytes]


class Reply(Generic[R]):
    """An answer that is owed; it is given once, at any time before the query's time has run out."""

    def __init__(
        self, number: int, asked: float, respond: Callable[[int, R, float], None], fail: Fail
    ) -> None:
        self._number = number
        self._asked = asked
        self._respond = respond
        self._fail = fail

    def answer(self, value: R) -> None:
        """This is it; a second answer is dropped by central.

        Raises:
            CodecError: The value does not fit the format; the query has ended with that error.
        """
        try:
            self._respond(self._number, value, self._asked)
        except HubError as error:
            self._fail(self._number, "HandlerFailedError", str(error))
            raise

    def fail(self, why: str) -> None:
        """There will be none."""
        self._fail(self._number, "HandlerFailedError", why)


Fail = Callable[[int, str, str], None]
_Responder = Callable[[frames.Frame, int, float], None]


class Answers:
    """What one client answers."""

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
            connection: Where answers go.
            pack: Makes the frame of a value that was measured at a time [s].
            last: The last published message of a name, as a frame.
            clock: Monotonic time [s].
        """
        self._name = name
        self._connection = connection
        self._pack = pack
        self._last = last
        self._clock = clock
        self._responders: dict[str, _Responder] = {}

    def add(
        self,
        request: MessageDefinition[Any],
        response: MessageDefinition[R],
        handler: Callable[[Any, Reply[R]], None],
    ) -> None:
        """Let `handler` answer queries of `request`, at once or later."""

        def respond(number: int, value: R, asked: float) -> None:
            answer = self._pack(response, value, asked)
            self._connection.tell(control.Response(number=number), answer)

        def answer(frame: frames.Frame, number: int, asked: float) -> None:
            handler(decode(request, frame), Reply(number, asked, respond, self._fail))

        self._responders[request.name] = answer
        self._announce(request.name, on=True)

    def remove(self, name: str) -> None:
        """Answer queries of this name no longer."""
        if self._responders.pop(name, None) is not None:
            self._announce(name, on=False)

    def announce_all(self) -> None:
        """Tell central, which knows the definitions now, what we answer."""
        for name in self._responders:
            self._announce(name, on=True)

    def answer(self, query: control.Query, attached: bytes | None) -> None:
        """A query has come."""
        asked = self._clock()  # what the answer says was measured from now on, not when it is sent
        responder = self._responders.get(query.name)
        try:
            if responder is None or attached is None:
                text = f"{self._name} does not answer {query.name}"
                raise HandlerFailedError(text)
            responder(frames.unpack(attached), query.number, asked)
        except HubError as error:
            self._fail(query.number, "HandlerFailedError", str(error))
        except Exception as error:
            text = f"{self._name} failed at {query.name}: {error!r}"
            self._fail(query.number, "HandlerFailedError", text)
            raise

    def tell_last(self, query: control.Last) -> None:
        """Somebody wants the last value that we published."""
        frame = self._last(query.name)
        if frame is None:
            text = f"{self._name} has published no {query.name} yet"
            self._fail(query.number, NoValueError.__name__, text)
        else:
            self._connection.tell(control.Response(number=query.number), frame)

    def _announce(self, name: str, *, on: bool) -> None:
        if self._connection.publisher:
            self._connection.tell(control.Handle(name=name, on=on))

    def _fail(self, number: int, error: str, text: str) -> None:
        # Whatever is in the text, it can be sent.
        sayable = text.replace("\0", "?").encode(errors="replace").decode()
        self._connection.tell(control.Failure(number=number, error=error, text=sayable))
