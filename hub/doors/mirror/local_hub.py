"""The hub that stands for a robot on this machine: a central, and a client that joins it to a line.

What local clients subscribe to is subscribed at the robot, while they do. Their commands and
queries go to the robot, each client's in a session of its own. So the robot's own hub decides who
has control, and sees who leaves. Messages keep the numbers that they have there.
"""

from __future__ import annotations

import functools
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from hub.doors.mirror.robot_line import RobotLine
from hub.doors.mirror.sender_numbers import renumbered
from hub.doors.pads import FOR_CONSOLES
from hub.ipc.broker.central import Central
from hub.ipc.client import Client
from hub.ipc.definition import MessageDefinition, Plane
from hub.ipc.formats.codegen import Buffer
from hub.ipc.message_info import MessageInfo
from hub.ipc.node.responders import FrameReply
from hub.ipc.security.publish_rights import may_publish
from hub.ipc.transport.loop import Loop
from hub.ipc.wire import frames

NAME = "fleet"
_LONGEST_QUERY_S = 60.0


class LocalHub:
    """A hub for as long as the robot is there.

    It listens in a hidden folder. Its place becomes a link to that one when the hub can answer:
    a console that tries to connect all the time would else miss last values.
    """

    def __init__(
        self,
        line: RobotLine,
        definitions: Iterable[MessageDefinition[Any]],
        place: Path,
        loop: Loop,
    ) -> None:
        """Listen, in hiding.

        Args:
            line: To the robot.
            definitions: Of the robot's hub.
            place: Folder to listen in, which is not there yet.
            loop: Serves it.

        Raises:
            EndpointError: It cannot listen there.
        """
        self._line, self._place = line, place
        self._hidden = place.with_name(f".{place.name}")
        self._shown = False
        self._definitions: dict[str, MessageDefinition[Any]] = {}
        self._broadcasts: list[MessageDefinition[Any]] = []
        self._followed: set[MessageDefinition[Any]] = set()
        self._sessions: dict[int, int] = {}
        """The session of each client of this hub, by its number here."""
        self._numbers: Mapping[int, int] = {}
        """The number here of each of them, by its number at the robot's hub."""
        self._hidden.mkdir(mode=0o700, exist_ok=True)
        endpoint = endpoint_in(self._hidden)
        self._central = Central([endpoint], forwarder=NAME, line_delay=lambda: line.round_trip)
        self._client = Client(NAME, endpoint, loop=loop)
        self._client.respond_last(self._ask_last)
        self.define(definitions)

    @property
    def knows_all(self) -> bool:
        """Whether it knows the number that each of its clients has at the robot's hub."""
        return len(self._numbers) == len(self._sessions)

    def define(self, definitions: Iterable[MessageDefinition[Any]]) -> None:
        """Add messages of the robot."""
        for definition in definitions:
            if definition.name in self._definitions:
                continue
            self._definitions[definition.name] = definition
            self._client.respond_frames(definition, functools.partial(self._ask, definition))
            if definition.plane is Plane.COMMAND and definition.name not in FOR_CONSOLES:
                if may_publish(self._line.operator.role, definition.name):
                    handler = functools.partial(self._command, definition)
                    self._client.subscribe_payload(definition, handler)
            else:
                self._broadcasts.append(definition)
                self._client.has_subscribers(definition)  # advertises it

    def follow(self) -> None:
        """Be at the robot for who is here, and subscribe there to what they do; call it often."""
        here = {*self._central.numbers()} - {self._client.number}
        for publisher in here - self._sessions.keys():
            self._session(publisher)
        for publisher in self._sessions.keys() - here:
            self._line.close_session(self._sessions.pop(publisher))
        for definition in self._broadcasts:
            wanted = self._client.has_subscribers(definition)
            if wanted and definition not in self._followed:
                self._followed.add(definition)
                self._line.subscribe(definition, functools.partial(self._came, definition))
            elif not wanted and definition in self._followed:
                self._followed.discard(definition)
                self._line.unsubscribe(definition)

    def show(self) -> bool:
        """Let clients in if it can answer them by now; whether that is new."""
        session = self._client.session
        ready = self._client.connected and session.defined and session.subscriptions.standing
        if self._shown or not ready:
            return False
        self._place.unlink(missing_ok=True)  # of a mirror that was killed
        self._place.symlink_to(self._hidden.name)
        self._shown = True
        return True

    def know(self, numbers: Mapping[int, int]) -> None:
        """Note which number each session has at the robot's hub, by session."""
        here = {session: number for number, session in self._sessions.items()}
        self._numbers = {
            there: here[session] for session, there in numbers.items() if session in here
        }

    def close(self) -> None:
        """End; clients see at once that it is gone."""
        if self._shown:
            self._place.unlink(missing_ok=True)
        for session in self._sessions.values():
            self._line.close_session(session)
        self._sessions.clear()
        self._client.close()
        self._central.close()

    def _session(self, publisher: int) -> int:
        """The session of a client of this hub; 0: no client has this number."""
        session = self._sessions.get(publisher, 0)
        if not session and self._central.peer_of(publisher) is not None:
            session = self._sessions[publisher] = self._line.open_session()
        return session

    def _came(self, definition: MessageDefinition[Any], frame: frames.Frame) -> None:
        if frame.fingerprint == definition.fingerprint:
            self._client.forward(definition, self._here(frame))

    def _command(
        self, definition: MessageDefinition[Any], payload: Buffer, info: MessageInfo
    ) -> None:
        session = self._session(info.publisher)
        if session:
            self._line.command(definition, session, bytes(payload), info.measured)

    def _ask(
        self, definition: MessageDefinition[Any], frame: frames.Frame, reply: FrameReply
    ) -> None:
        self._line.query(
            definition,
            frame,
            self._session(frame.publisher),
            timeout=_bounded(reply.timeout),
            answered=functools.partial(self._answer, reply),
            failed=reply.fail,
        )

    def _ask_last(self, name: str, reply: FrameReply) -> None:
        self._line.last(
            name,
            timeout=_bounded(reply.timeout),
            answered=functools.partial(self._answer, reply),
            failed=reply.fail,
        )

    def _answer(self, reply: FrameReply, frame: frames.Frame) -> None:
        here = self._here(frame)
        reply.answer(
            frames.pack(
                frames.prefix(here.name),
                publisher=here.publisher,
                fingerprint=here.fingerprint,
                sequence=here.sequence,
                stamp_ns=here.stamp_ns,
                payload=(here.payload,),
            )
        )

    def _here(self, frame: frames.Frame) -> frames.Frame:
        """A message as this side's clients know it."""
        payload = renumbered(frame.name, frame.fingerprint, frame.payload, self._numbers)
        return frame._replace(payload=payload)


def endpoint_in(place: Path) -> str:
    """Where clients find the hub of a place."""
    return f"ipc://{place / 'hub'}"


def _bounded(timeout: float) -> float:
    return timeout if 0.0 < timeout < _LONGEST_QUERY_S else _LONGEST_QUERY_S
