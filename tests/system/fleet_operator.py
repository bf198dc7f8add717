"""An operator in a fleet as the protocol has it, without a console: to drive robots in tests."""

from __future__ import annotations

import itertools
import json
import time
from collections.abc import Callable
from typing import Any

from hub.gcm.common import COMMON_RESULT
from hub.gcm.control import CONSOLE_HEARTBEAT, CONTROL_REQUEST, ConsoleHeartbeat, ControlRequest
from hub.gcm.geometry import TwistStamped
from hub.gcm.navigation import STOP, VELOCITY_COMMAND
from hub.ipc.definition import MessageDefinition, Plane
from hub.ipc.roles import Principal, Role
from hub.ipc.transport.loop import Loop
from hub.zenoh.attachment import CLOCK, Attachment
from hub.zenoh.fleet_keys import FleetKey, KeyKind
from hub.zenoh.fleet_line import ZenohFleetLine
from hub.zenoh.settings import CertificateFiles, RouterPlace, client_settings
from tests.support.waiting import Limit, until

_SESSIONS = itertools.count(1000)


class FleetOperator:
    """A session at one robot."""

    def __init__(
        self,
        place: RouterPlace,
        robot: str,
        *,
        name: str = "alice",
        role: Role = Role.OPERATE,
        certificates: CertificateFiles | None = None,
    ) -> None:
        self.loop = Loop()
        settings = client_settings(place, certificates=certificates)
        self.line = ZenohFleetLine(place, settings, self.loop)
        self.robot, self.principal = robot, Principal(name=name, role=role)
        self.session = next(_SESSIONS)
        self.offset_ns = 0
        self.numbers: dict[str, int] = {}
        self.refusals: list[str] = []
        self.robots: dict[str, bool] = {}
        self._sequences: dict[str, int] = {}
        self.line.watch("rune/v1/*/alive", self._seen)
        self.line.declare_token(
            self.key(KeyKind.OPERATOR, operator=self.principal, session=self.session)
        )
        self.line.subscribe(self.key(KeyKind.OPERATORS), lambda _, said, __: self._know(said))
        self.line.subscribe(
            self.key(KeyKind.REFUSAL, operator=self.principal),
            lambda _, said, __: self.refusals.append(said.decode()),
        )

    def _seen(self, key: str, there: bool) -> None:  # noqa: FBT001
        self.robots[key.split("/")[-2]] = there

    def _know(self, said: bytes) -> None:
        self.numbers = json.loads(said)

    def key(self, kind: KeyKind, **parts: Any) -> str:
        return FleetKey(kind=kind, robot=self.robot, **parts).under("rune")

    def wait(self, condition: Callable[[], object], timeout: float = 20.0, why: str = "no") -> None:
        until(condition, timeout, why, meanwhile=lambda: self.loop.listen(0.01))

    def join(self) -> None:
        """Be known at the robot's hub, with its clock measured."""
        self.wait(lambda: self.robots.get(self.robot), why="the robot is not there")
        self.wait(lambda: self.known or self.look(), why="the hub does not know the session")
        sent = time.monotonic_ns()
        answer = self.ask(self.key(KeyKind.CLOCK), b"", b"")
        self.offset_ns = CLOCK.unpack(answer[0])[0] - (sent + time.monotonic_ns()) // 2

    def look(self) -> None:
        self._know(self.ask(self.key(KeyKind.OPERATORS), b"", b"")[0])

    @property
    def known(self) -> bool:
        return f"{self.principal}/{self.session}" in self.numbers

    def header(self, definition: MessageDefinition[Any], *, age: float = 0.0) -> Attachment:
        sequence = self._sequences[definition.name] = self._sequences.get(definition.name, 0) + 1
        return Attachment(
            publisher=self.session,
            fingerprint=definition.fingerprint,
            sequence=sequence,
            stamp_ns=time.monotonic_ns() + self.offset_ns - int(age * 1e9),
        )

    def command(self, definition: MessageDefinition[Any], value: Any, *, age: float = 0.0) -> None:
        payload = b"".join(map(bytes, definition.encode(value)))
        key = self.key(KeyKind.COMMAND, operator=self.principal, message=definition.name)
        self.line.put(key, payload, self.header(definition, age=age).pack(), Plane.COMMAND)

    def drive(self, speed: float, *, age: float = 0.0) -> None:
        self.command(VELOCITY_COMMAND, TwistStamped.planar(speed, 0.0), age=age)

    def stop(self) -> None:
        self.command(STOP, STOP.type())

    def ask(
        self, key: str, payload: bytes, header: bytes, timeout: float = 5.0
    ) -> tuple[bytes, bytes | None]:
        """Ask, and wait for the answer; a refusal fails."""
        ends: list[Any] = []
        self.line.ask(
            key,
            payload,
            header,
            timeout=timeout,
            answered=lambda *answer: ends.append(answer),
            failed=lambda *failure: ends.append(RuntimeError(*failure)),
        )
        self.wait(lambda: ends)
        if isinstance(ends[0], RuntimeError):
            raise ends[0]
        found: tuple[bytes, bytes | None] = ends[0]
        return found

    def request(self, request: ControlRequest) -> Any:
        """Ask the robot's daemon about control."""
        payload = b"".join(map(bytes, CONTROL_REQUEST.encode(request)))
        key = self.key(KeyKind.ASK, operator=self.principal, message=CONTROL_REQUEST.name)
        answer, _ = self.ask(key, payload, self.header(CONTROL_REQUEST).pack())
        return COMMON_RESULT.decode(answer)

    def take_control(self) -> None:
        assert self.request(ControlRequest(operator=self.principal.name)).done

    def drive_until(self, condition: Callable[[], object], speed: float = 0.3) -> None:
        """Command at 20 Hz, neutral first, with heartbeats, as a console does."""
        due, limit, begin = 0.0, Limit(30.0), time.monotonic() + 0.5
        while not condition():
            assert not limit.over, f"the robot does not drive; {self.refusals}"
            self.loop.listen(0.01)
            now = time.monotonic()
            if now >= due:
                due = now + 0.05
                self.command(CONSOLE_HEARTBEAT, ConsoleHeartbeat(holds=1))
                self.drive(speed if now > begin else 0.0)

    def close(self) -> None:
        self.line.close()
        self.loop.close()
