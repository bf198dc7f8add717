"""A robot of a fleet that says wrong things of itself under its name, and robots that flicker.

python -m tests.misbehaving.rogue_robot PLACE FLEET NAME COUNT RATE SEED: a router and its fleet,
the robot's name, how many inputs in all, and how many a second. It writes a JSON line when it has
joined, begins with a line of input, and writes another JSON line at its end.
"""

from __future__ import annotations

import collections
import json
import os
import random
import sys
import time
from collections.abc import Callable
from typing import Any

from hub.gcm.catalog import MESSAGES
from hub.gcm.control import CONTROL_STATE, ControlState
from hub.gcm.navigation import ROBOT_STATE, VELOCITY_COMMAND
from hub.ipc.definition import MessageDefinition
from hub.ipc.wire.definition_listing import to_listing
from hub.zenoh.attachment import CLOCK, Attachment
from hub.zenoh.fleet_session import FleetQuery, FleetWay, open_fleet_session
from hub.zenoh.session import ZenohDeclared
from hub.zenoh.settings import client_settings, parse_place
from tests.misbehaving.bad_frames import spoil

_BURST_S = 0.005
_GHOSTS = 300
_FAR = (0, 1, (1 << 62) - 1, 1 << 62, (1 << 63) - 1, -1, -(1 << 63))
_LISTED = ("name", "format", "fields", "keep", "plane")
_LARGE = 500
"""One input of this number is a large one."""
_AWAY = 4000
"""After this number of inputs, the robot goes, or comes back."""


class RogueRobot:
    """A robot that mirrors show, as it answers their first questions well."""

    def __init__(self, place: str, fleet: str, name: str, seed: int) -> None:
        where = parse_place(place)
        self._session = open_fleet_session(where, client_settings(where))
        self._chance = random.Random(seed)
        self._fleet, self._key = f"{fleet}/v1/", f"{fleet}/v1/{name}/"
        self._definitions = json.dumps([_listed(each) for each in MESSAGES]).encode()
        self._good = b"".join(map(bytes, CONTROL_STATE.encode(ControlState(operator="eve"))))
        self._ghosts: dict[int, ZenohDeclared] = {}
        self._sequence = 0
        self._puts: list[Callable[[], None]] = [
            *[self._state] * 6, self._document, self._document, self._refusal, self._token,
        ]  # fmt: skip
        self.sent: collections.Counter[str] = collections.Counter()
        self._alive: ZenohDeclared | None = self._session.declare_token(self._key + "alive")
        self._kept = []  # else Zenoh ends them
        for kind, answer in (
            ("clock", self._clock),
            ("definitions", lambda query: query.answer(self._definitions)),
            ("operators", lambda query: query.answer(b"{}")),
            ("last/*", self._answer),
            ("ask/*/*", self._answer),
        ):
            self._kept.append(self._session.respond(self._key + kind, answer))

    def one(self, number: int) -> None:
        """Do one wrong thing."""
        if number % _AWAY == _AWAY - 1:
            self._come_or_go()
        elif number % _LARGE == _LARGE - 1:
            self._large()
        else:
            self._chance.choice(self._puts)()

    def close(self) -> None:
        """Leave."""
        self._session.close()

    def _put(self, key: str, payload: bytes, attachment: bytes | None = None) -> None:
        self._session.put(self._key + key, payload, attachment, FleetWay.STATE)

    def _clock(self, query: FleetQuery) -> None:
        """Right for most questions: a robot that no mirror shows attacks none."""
        now, chance = time.monotonic_ns(), self._chance
        self.sent["clock"] += 1
        if chance.random() < 0.95:
            query.answer(CLOCK.pack(now))
        elif chance.random() < 0.5:
            query.answer(CLOCK.pack(chance.choice(_FAR)))
        else:
            query.answer(spoil(CLOCK.pack(now), chance))

    def _answer(self, query: FleetQuery) -> None:
        chance = self._chance
        self.sent["answer"] += 1
        if chance.random() < 0.2:
            query.refuse(chance.choice(["QueryError", "x", "OSError", ""]), "no \x1b[2J" * 99)
        else:
            message = query.key.rpartition("/")[2]
            query.answer(spoil(self._good, chance), self._header(CONTROL_STATE, message))

    def _header(self, definition: MessageDefinition[Any], name: str = "") -> bytes:
        chance = self._chance
        self._sequence += 1
        far = chance.random() < 0.2
        header = Attachment(
            publisher=chance.choice([1, 2, chance.getrandbits(32)]),
            fingerprint=definition.fingerprint,
            sequence=chance.getrandbits(64) if far else self._sequence,
            stamp_ns=chance.choice(_FAR) if chance.random() < 0.2 else time.monotonic_ns(),
            name=name,
        ).pack()
        return spoil(header, chance) if chance.random() < 0.3 else header

    def _state(self) -> None:
        chance = self._chance
        often = (CONTROL_STATE, ROBOT_STATE, VELOCITY_COMMAND)
        choices: list[MessageDefinition[Any]] = [*often, *MESSAGES]
        definition = chance.choice(choices)
        room = chance.choice(["state", "state", "state", "thin", "picture"])
        right = definition is CONTROL_STATE and chance.random() < 0.5
        payload = self._good if right else spoil(self._good, chance)
        self._put(f"{room}/{definition.name}", payload, self._header(definition))
        self.sent[room] += 1

    def _document(self) -> None:
        chance = self._chance
        if chance.random() < 0.5:
            said: Any = {str(chance.getrandbits(chance.randint(1, 40))): chance.randint(-1, 99)}
            good = json.dumps(said | {"9" * chance.choice([3, 5000]): 7}).encode()
            self._put("operators", spoil(good, chance) if chance.random() < 0.7 else good)
            self.sent["operators"] += 1
            return
        said = [self._other() for _ in range(chance.randint(1, 3))]
        good = json.dumps(said).encode()
        self._put("definitions", spoil(good, chance) if chance.random() < 0.5 else good)
        self.sent["definitions"] += 1

    def _other(self) -> dict[str, Any]:
        """A message with a new name, and now and then with a number beyond all bounds."""
        chance = self._chance
        said: dict[str, Any] = _listed(chance.choice(MESSAGES))
        said["name"] = f"T_Other{chance.getrandbits(32)}"
        if chance.random() < 0.3:
            numbers = [10**400, -1, float("nan"), float("inf"), "7", None]
            said[chance.choice(["rate_hz", "lifespan_s"])] = chance.choice(numbers)
        return said

    def _refusal(self) -> None:
        self._put("refusal/operate:ann", self._chance.randbytes(self._chance.randint(0, 300)))
        self.sent["refusal"] += 1

    def _token(self) -> None:
        """A robot that comes, or goes, and answers nothing; some names are none."""
        number = self._chance.randrange(_GHOSTS)
        ghost = self._ghosts.pop(number, None)
        if ghost is not None:
            ghost.undeclare()
        else:
            name = f"ghost{number}" if number % 3 else "a b" + "x" * number
            self._ghosts[number] = self._session.declare_token(f"{self._fleet}{name}/alive")
        self.sent["token"] += 1

    def _come_or_go(self) -> None:
        self.sent["came or went"] += 1
        if self._alive is not None:
            self._alive.undeclare()
            self._alive = None
        else:
            self._alive = self._session.declare_token(self._key + "alive")

    def _large(self) -> None:
        chance = self._chance
        self.sent["large"] += 1
        if chance.random() < 0.5:
            many = [self._other() for _ in range(600)]
            self._put("definitions", json.dumps(many).encode())
        else:
            key = f"state/{CONTROL_STATE.name}"
            self._put(key, bytes(5 << 20), self._header(CONTROL_STATE))


def _listed(definition: MessageDefinition[Any]) -> dict[str, Any]:
    entry = to_listing(definition)
    return {key: getattr(entry, key) for key in _LISTED}


def _say(figures: object) -> None:
    sys.stdout.write(json.dumps(figures) + "\n")
    sys.stdout.flush()


def main() -> None:
    os.nice(10)
    place, fleet, name, count, rate, seed = sys.argv[1:7]
    robot = RogueRobot(place, fleet, name, int(seed))
    _say({"event": "joined"})
    sys.stdin.readline()
    started = time.monotonic()
    done = 0
    while done < int(count):
        due = min(int(count), int((time.monotonic() - started) * float(rate)))
        while done < due:
            robot.one(done)
            done += 1
        time.sleep(_BURST_S)
    took = round(time.monotonic() - started, 1)
    robot.close()
    _say({"done": done, "took_s": took, **robot.sent})


if __name__ == "__main__":
    main()
