"""A robot that an operator drives through the gateway while hostile observers attack the hub.

For a benchmark and a soak test: how late messages come, how fast a stop is acted on, and who
loses the hub.
"""

from __future__ import annotations

import contextlib
import math
import subprocess
import sys
import time
from collections import defaultdict
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass, field
from pathlib import Path

from hub.gcm import common, control, navigation, vision
from hub.gcm.geometry import TwistStamped
from hub.gcm.navigation import Stop
from hub.ipc.client import Client
from hub.ipc.definition import MessageDefinition
from hub.ipc.roles import Role
from hub.ipc.security.client_keys import read_client_keys
from hub.ipc.security.keyring import Keyring
from tests.misbehaving.hostile_observer import ATTACKS
from tests.support.ports import free_port
from tests.support.waiting import until
from tests.system.harness import HubProcess

MIX = tuple(ATTACKS)
"""One hostile observer of each kind."""
OURS = ("robomon", "driver", "navigation", "vision", "operator", "watcher")
TURN = 0.5
UP, DOWN, LOCAL = "operator_to_robot", "robot_to_operator", "within_robot"
"""Ways of messages: commands, a probe 50 times a second, GCM_RobotState."""
_PROBE_S = 0.02
_HOSTILE = "tests.misbehaving.hostile_observer"
_COMMAND_S = 0.05
_HEARTBEAT_S = 0.2
_NEUTRAL_S = 0.4
_BETWEEN_STOPS_S = 2.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Probe:
    """A message that is nothing but its age."""

    number: int = 0


PROBE = MessageDefinition(name="T_Probe", format="{int}", type=Probe, rate_hz=1.0 / _PROBE_S)


@dataclass(slots=True)
class Seen:
    """What was measured in one time.

    Attributes:
        ages: How old messages were when they came, by their way [s].
        queries: How long queries of the operator took [s].
        stops: From a stop of the operator to wheels that are told zero [s].
        unanswered: Queries of the operator that failed.
        gone: Who of the robot and its operator lost the hub.
    """

    ages: defaultdict[str, list[float]] = field(default_factory=lambda: defaultdict(list))
    queries: list[float] = field(default_factory=list)
    stops: list[float] = field(default_factory=list)
    unanswered: int = 0
    gone: list[str] = field(default_factory=list)

    def p99(self, way: str) -> float:
        """The age that one message of a hundred exceeds [s]."""
        ages = sorted(self.ages[way])
        return ages[int(len(ages) * 0.99)] if ages else math.nan


class AttackedHub:
    """A hub with a gateway, an operator who comes through it, and a client of its machine."""

    def __init__(self, stack: ExitStack, folder: Path) -> None:
        self._folder = folder
        self._ring = Keyring(folder / "keys")
        port = free_port()
        lines = f'gateway = "tcp://127.0.0.1:{port}"\nkeys = "{folder / "keys"}"'
        keys = read_client_keys(self._ring.make("op", Role.OPERATE))
        self.hub = stack.enter_context(closing(HubProcess(folder, gateway=lines)))
        self.gateway = f"tcp://127.0.0.1:{port}"
        self._truth: navigation.GroundTruth | None = None
        self.seen = Seen()
        self._wanted = TwistStamped.planar(0.0, 0.0)
        self._asked: float | None = None
        self._watcher = Client("watcher", self.hub.endpoint)
        self._operator = Client("operator", self.gateway, keys=keys)
        for client in (self._watcher, self._operator):
            stack.callback(client.close)
            client.wait_connected(10.0)
        self._numbers = [self._watcher.number, self._operator.number]
        self._read = 0
        self._begin()

    def measure(self, seconds: float) -> Seen:
        """Drive, stop and look for so long; what was seen."""
        self.seen = seen = Seen()
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self._turn()
            self._serve_for(_BETWEEN_STOPS_S / 2.0)
            sent = time.monotonic()
            self._operator.publish(navigation.STOP, Stop(reason="measured"))
            self._wanted = TwistStamped.planar(0.0, 0.0)
            with contextlib.suppress(AssertionError):
                until(lambda: self._told == 0.0, 3.0, meanwhile=self._serve)
            seen.stops.append(time.monotonic() - sent)
            self._serve_for(_BETWEEN_STOPS_S / 2.0)
        lines = self.hub.log.read_text().splitlines()
        seen.gone = [line for line in lines[self._read :] if _loses(line)]
        self._read = len(lines)
        numbers = [self._watcher.number, self._operator.number]
        if numbers != self._numbers:
            seen.gone.append(f"the numbers of watcher and operator: {self._numbers}, {numbers}")
            self._numbers = numbers
        return seen

    def refused(self) -> dict[str, int]:
        """What central has refused up to now, by reason."""
        listing = self._watcher.directory.listing(5.0)
        return {count.reason: count.count for count in listing.dropped}

    @contextlib.contextmanager
    def attackers(self, attacks: Sequence[str], seconds: float) -> Iterator[None]:
        """Hostile observers, each with a key and an address of its own."""
        processes = []
        try:
            for number, attack in enumerate(attacks):
                key = self._ring.make(f"eve{number}-{time.monotonic_ns()}", Role.OBSERVE)
                # On a machine of its own it would take no processor from the robot.
                command = ["nice", "-n", "19", sys.executable, "-m", _HOSTILE, attack]
                options = [self.gateway, str(key), f"127.0.0.{11 + number}", str(seconds)]
                processes.append(subprocess.Popen([*command, *options]))
                self._serve_for(0.05)
            self._serve_for(3.0)  # until the last of them has begun
            yield
            for attack, process in zip(attacks, processes, strict=True):
                assert process.poll() in (None, 0), f"the attack {attack!r} ended by itself"
        finally:
            for process in processes:
                process.kill()
                process.wait()

    def _begin(self) -> None:
        def remember(truth: navigation.GroundTruth) -> None:
            self._truth = truth

        self._watcher.define(PROBE)
        self._watcher.wait_defined(10.0)
        for way, client, definition in (
            (UP, self._watcher, navigation.VELOCITY_COMMAND),
            (DOWN, self._operator, PROBE),
            (LOCAL, self._watcher, navigation.ROBOT_STATE),
        ):
            client.subscribe(
                definition,
                lambda _, reception, way=way: self.seen.ages[way].append(reception.age),
            )
        self._watcher.every(_PROBE_S, lambda: self._watcher.publish(PROBE, Probe()))
        self._watcher.subscribe(navigation.GROUND_TRUTH, lambda truth, _: remember(truth))
        self._operator.define(
            navigation.VELOCITY_COMMAND, navigation.STOP, control.CONSOLE_HEARTBEAT
        )
        until(lambda: self._truth is not None, 10.0, meanwhile=self._serve)
        alive = control.ConsoleHeartbeat(holds=1)
        self._operator.every(
            _HEARTBEAT_S, lambda: self._operator.publish(control.CONSOLE_HEARTBEAT, alive)
        )
        self._operator.every(
            _COMMAND_S,
            lambda: self._operator.publish(navigation.VELOCITY_COMMAND, self._wanted),
        )
        take = control.ControlRequest(action=control.ControlAction.TAKE, operator="op")
        answer = self._operator.query_response(
            control.CONTROL_REQUEST, take, common.COMMON_RESULT, timeout=5.0
        )
        assert answer.done, answer.text
        self._operator.every(0.1, self._ask)
        self._turn()

    def _turn(self) -> None:
        """Drive, from neutral, until the wheels are told to; again where nobody listened yet."""

        def push() -> None:
            self._wanted = TwistStamped.planar(0.0, 0.0)
            self._serve_for(_NEUTRAL_S)
            self._wanted = TwistStamped.planar(0.0, TURN)
            self._serve_for(_NEUTRAL_S)

        push()
        until(lambda: self._told > 0.0, 20.0, "the robot does not turn", meanwhile=push)

    @property
    def _told(self) -> float:
        assert self._truth is not None
        return self._truth.commanded_angular

    def _ask(self) -> None:
        """Ask for something that an observer may ask for as well."""
        sent, seen = time.monotonic(), self.seen

        def answered(*_: object) -> None:
            seen.queries.append(time.monotonic() - sent)

        def failed(_: object) -> None:
            seen.unanswered += 1

        self._operator.query_notify(
            vision.IMAGE_REQUEST,
            vision.ImageRequest(),
            vision.IMAGE,
            timeout=2.0,
            answered=answered,
            failed=failed,
        )

    def _serve(self) -> None:
        self._watcher.listen(0.001)
        self._operator.listen(0.001)

    def _serve_for(self, seconds: float) -> None:
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self._serve()


def _loses(line: str) -> bool:
    """Whether a line of the hub's log says that somebody who matters has lost the hub."""
    return "the hub at" in line or any(f" {name} is gone" in line for name in OURS)
