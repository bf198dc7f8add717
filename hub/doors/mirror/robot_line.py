"""One robot of a fleet, seen from an operator: its clock, its messages, and what is sent to it."""

from __future__ import annotations

import functools
import math
import secrets
from collections.abc import Callable
from typing import Any

from hub.bucket import Bucket
from hub.doors.mirror.document_turns import DocumentTurns
from hub.doors.mirror.fleet_frames import SentHeaders, frame_of
from hub.doors.mirror.fleet_line import Declared, FleetLine
from hub.doors.mirror.thin_choice import LeftOutNumbers, ThinChoice
from hub.errors import FrameError
from hub.ipc.definition import MessageDefinition, Plane
from hub.ipc.roles import Principal
from hub.ipc.transport.clock_sync import ClockSync
from hub.ipc.transport.fault_counter import FaultCounter
from hub.ipc.wire import frames
from hub.plain_text import plain
from hub.zenoh.attachment import CLOCK, Attachment, has_twin, lifespan, unpack
from hub.zenoh.fleet_keys import MAX_SESSION, FleetKey, KeyKind

LOST_S = 1.5
"""Time without an answer after which a robot counts as lost, as at any hub [s]."""
CLOCK_S = 0.5
_FOLLOW_S = 5.0
"""Longest time for the definitions of a robot: 20 kB on a thin line [s]."""
_MOST_WORDS = 500
_REFUSALS, _REFUSALS_PER_S = 5.0, 1.0
_ROOM = {
    Plane.COMMAND: KeyKind.STATE,
    Plane.STATE: KeyKind.STATE,
    Plane.PICTURE: KeyKind.PICTURE,
}

CameFrame = Callable[[frames.Frame], None]
"""Gets a broadcast."""
Refused = Callable[[str, str], None]
"""Gets the error's class in `hub.errors`, and a sentence."""


class RobotLine:
    """The keys of one robot, as one operator uses them; stamps are on this process's clock.

    Attributes:
        robot: Its name in the fleet.
        operator: Who asks and commands.
    """

    def __init__(
        self,
        line: FleetLine,
        fleet: str,
        robot: str,
        operator: Principal,
        clock: Callable[[], float],
        faults: FaultCounter,
    ) -> None:
        """Ask nothing yet."""
        self.robot, self.operator = robot, operator
        self._line, self._fleet, self._clock = line, fleet, clock
        self._faults = faults
        self._time = ClockSync(clock)
        self._heard = -math.inf
        self._headers = SentHeaders()
        self._declared: dict[str, Declared] = {}
        self._followed: dict[str, tuple[MessageDefinition[Any], CameFrame]] = {}
        self._choice, self._numbers = ThinChoice(), LeftOutNumbers()
        self._usual_trip = math.inf
        self._refusals = Bucket(_REFUSALS_PER_S, _REFUSALS)
        self._documents = DocumentTurns(clock)
        self._asked: set[str] = set()
        self._run = 0

    @property
    def knows_clock(self) -> bool:
        """Whether the robot's clock is known."""
        return not math.isnan(self._time.round_trip)

    @property
    def round_trip(self) -> float:
        """Shortest time of the last seconds for an answer of the robot [s]; 0: not known."""
        return self._time.round_trip if self.knows_clock else 0.0

    @property
    def silence(self) -> float:
        """Time since its last answer [s]."""
        return self._clock() - self._heard

    def begin(self) -> None:
        """The robot is there, and may be another run of it: its clock is not known."""
        self._run += 1
        self._time.begin(0)
        self._choice, self._numbers = ThinChoice(), LeftOutNumbers()
        self._usual_trip = math.inf
        self._heard = self._clock()

    def end(self) -> None:
        """Withdraw all that was declared."""
        self._run += 1
        for declared in self._declared.values():
            declared.withdraw()
        self._declared.clear()
        self._documents.clear()
        self._followed.clear()
        self._headers.clear()

    def read_clock(self) -> None:
        """Ask for the time at the robot."""
        sent, run = self._clock(), self._run

        def answered(payload: bytes, _: bytes | None) -> None:
            if run == self._run and len(payload) == CLOCK.size:
                self._heard = self._clock()
                self._time.note(sent, CLOCK.unpack(payload)[0] * 1e-9, self._heard)

        self._line.ask(
            self._key(KeyKind.CLOCK),
            b"",
            b"",
            timeout=LOST_S,
            answered=answered,
            failed=lambda *_: None,
            plane=Plane.COMMAND,
        )

    def follow(self, kind: KeyKind, came: Callable[[bytes], None]) -> None:
        """Call `came` with what stands at one of its keys, and at each change of it.

        Of many changes, it gets the newest, as often as `read_documents` allows.
        A call while the answer to the last is on its way does nothing: on a thin line the answers
        to several would delay each other.
        """
        key, run = self._key(kind), self._run

        def take(payload: bytes) -> None:
            if run == self._run:
                self._documents.add(key, functools.partial(came, payload))

        def answered(payload: bytes, _: bytes | None) -> None:
            self._asked.discard(key)
            take(payload)

        if key not in self._declared:
            subscribed = self._line.subscribe(key, lambda _, payload, __: take(payload))
            self._declared[key] = subscribed
        if key not in self._asked:
            self._asked.add(key)
            self._line.ask(
                key,
                b"",
                b"",
                timeout=_FOLLOW_S,
                answered=answered,
                failed=lambda *_: self._asked.discard(key),
            )

    def read_documents(self) -> None:
        """Read those whose turn it is; call it often."""
        self._documents.work()

    def hear_refusals(self, came: Callable[[str], None]) -> None:
        """Call `came` with each sentence why the robot refused a command of this operator."""
        key = self._key(KeyKind.REFUSAL, operator=self.operator)

        def refused(_: str, payload: bytes, __: bytes | None) -> None:
            if key in self._declared and self._refusals.take(1.0, self._clock()):
                came(plain(payload[: 4 * _MOST_WORDS].decode("utf-8", "replace"))[:_MOST_WORDS])

        if key not in self._declared:
            self._declared[key] = self._line.subscribe(key, refused)

    def subscribe(self, definition: MessageDefinition[Any], came: CameFrame) -> None:
        """Call `came` for each broadcast of a message; too old ones are left out."""
        if definition.name not in self._followed:
            self._followed[definition.name] = definition, came
            self._follow_broadcast(definition, came, thin=self._choice.thin)

    def unsubscribe(self, definition: MessageDefinition[Any]) -> None:
        """Get these broadcasts no longer."""
        if self._followed.pop(definition.name, None) is not None:
            self._withdraw(self._broadcast_key(definition, thin=self._choice.thin))

    def choose_rate(self) -> bool | None:
        """Choose the rate of states by their ages; returns a new choice: whether it is the low one.

        Call it about twice a second.
        """
        self._usual_trip = min(self._usual_trip, self.round_trip)
        before = self._choice.thin
        thin = self._choice.look(self._clock(), self._usual_trip / 2)
        if thin == before:
            return None
        for definition, came in self._followed.values():
            if has_twin(definition):
                self._follow_broadcast(definition, came, thin=thin)
                self._withdraw(self._broadcast_key(definition, thin=before))
        return thin

    def _follow_broadcast(
        self, definition: MessageDefinition[Any], came: CameFrame, *, thin: bool
    ) -> None:
        key = self._broadcast_key(definition, thin=thin)
        oldest, twin = lifespan(definition), has_twin(definition)

        def arrived(_: str, payload: bytes, attachment: bytes | None) -> None:
            if key not in self._declared:
                return
            try:
                frame = self._frame(definition.name, payload, unpack(attachment))
            except FrameError as error:
                self._faults.count("malformed header", f"{self.robot}: {error}")
                return
            age = self._clock() - frame.stamp_ns * 1e-9
            if twin:
                self._choice.note(age)
                frame = self._renumbered(frame, thin=thin)
            if age <= oldest:
                came(frame)

        self._declared[key] = self._line.subscribe(key, arrived)

    def _renumbered(self, frame: frames.Frame, *, thin: bool) -> frames.Frame:
        number = self._numbers.number(frame.name, frame.publisher, frame.sequence, thin=thin)
        return frame._replace(sequence=number)

    def _broadcast_key(self, definition: MessageDefinition[Any], *, thin: bool) -> str:
        kind = KeyKind.THIN if thin and has_twin(definition) else _ROOM[definition.plane]
        return self._key(kind, message=definition.name)

    def _withdraw(self, key: str) -> None:
        declared = self._declared.pop(key, None)
        if declared is not None:
            declared.withdraw()

    def open_session(self) -> int:
        """Let another client of this operator be there; its number."""
        session = secrets.randbelow(MAX_SESSION) + 1
        key = self._key(KeyKind.OPERATOR, operator=self.operator, session=session)
        self._declared[key] = self._line.declare_token(key)
        return session

    def close_session(self, session: int) -> None:
        """A client is there no longer."""
        self._withdraw(self._key(KeyKind.OPERATOR, operator=self.operator, session=session))
        self._headers.forget(session)

    def command(
        self, definition: MessageDefinition[Any], session: int, payload: bytes, measured: float
    ) -> None:
        """Send a command, unless it is too old by now.

        Args:
            definition: Which.
            session: Whose.
            payload: It.
            measured: Its time, on this process's clock [s].
        """
        if self._clock() - measured > lifespan(definition):
            return
        key = self._key(KeyKind.COMMAND, operator=self.operator, message=definition.name)
        try:
            header = self._header(definition.name, session, definition.fingerprint, measured)
        except FrameError as error:
            self._faults.count("command with a wrong stamp", f"{self.robot}: {error}")
        else:
            self._line.put(key, payload, header, Plane.COMMAND)

    def query(
        self,
        definition: MessageDefinition[Any],
        frame: frames.Frame,
        session: int,
        *,
        timeout: float,
        answered: Callable[[frames.Frame], None],
        failed: Refused,
    ) -> None:
        """Ask the robot; exactly one of `answered` and `failed` is called later."""
        key = self._key(KeyKind.ASK, operator=self.operator, message=frame.name)
        measured = frame.stamp_ns * 1e-9
        try:
            header = self._header(frame.name, session, frame.fingerprint, measured)
        except FrameError as error:
            failed("HandlerFailedError", str(error))
        else:
            query = (key, bytes(frame.payload), header)
            self._ask(query, definition.plane, timeout, answered, failed)

    def last(
        self,
        message: str,
        *,
        timeout: float,
        answered: Callable[[frames.Frame], None],
        failed: Refused,
    ) -> None:
        """Ask for the last value of a message; as `query`."""
        key = self._key(KeyKind.LAST, message=message)
        self._ask((key, b"", b""), Plane.STATE, timeout, answered, failed, name=message)

    def _ask(
        self,
        query: tuple[str, bytes, bytes],
        plane: Plane,
        timeout: float,
        answered: Callable[[frames.Frame], None],
        failed: Refused,
        name: str = "",
    ) -> None:
        def came(answer: bytes, attachment: bytes | None) -> None:
            self._heard = self._clock()
            try:
                read = unpack(attachment)
                frame = self._frame(name or read.name, answer, read)
                if name and self._numbers.knows(name, frame.publisher):  # among its broadcasts
                    frame = self._renumbered(frame, thin=self._choice.thin)
            except FrameError as error:
                failed("HandlerFailedError", str(error))
            else:
                answered(frame)

        self._line.ask(*query, timeout=timeout, answered=came, failed=failed, plane=plane)

    def _frame(self, name: str, payload: bytes, header: Attachment) -> frames.Frame:
        return frame_of(name, payload, header, self._time.most)

    def _header(self, name: str, session: int, fingerprint: int, measured: float) -> bytes:
        return self._headers.pack(name, session, fingerprint, measured + self._time.least)

    def _key(self, kind: KeyKind, **parts: Any) -> str:  # noqa: ANN401 - the parts differ in type
        return FleetKey(kind=kind, robot=self.robot, **parts).under(self._fleet)
