"""The key space of a fleet: what stands at which key; pure.

Each key is FLEET/v1/ROBOT/KIND, and then what the kind needs:

| key | what is there | who declares it |
| --- | --- | --- |
| `alive` | token: the robot's hub answers | robot |
| `operator/WHO/SESSION` | token: an operator is there | operator |
| `operators` | put and queryable: the sessions that the robot knows (JSON) | robot |
| `definitions` | put and queryable: the messages of the robot's hub (JSON) | robot |
| `clock` | queryable: the hub's monotonic clock [ns], as 8 bytes, little-endian | robot |
| `state/MESSAGE` | put: a message of the state plane | robot |
| `picture/MESSAGE` | put: a message of the picture plane | robot |
| `thin/MESSAGE` | put: a message of the state plane at a low rate | robot |
| `last/MESSAGE` | queryable: the last value | robot |
| `command/WHO/MESSAGE` | put: a message of the command plane | operator |
| `ask/WHO/MESSAGE` | queryable: a query | robot |
| `refusal/WHO` | put: why a command was refused, in a sentence | robot |

WHO is a role and a name, such as `operate:alice`. A router binds it to a certificate. SESSION is a
number above 0 that an operator's program draws at its start.
"""

from __future__ import annotations

import enum
import re

from hub.errors import FleetKeyError, MessageFormatError
from hub.ipc.roles import Principal, Role
from hub.values import dataclass

DEFAULT_FLEET = "rune"
VERSION = "v1"
MAX_KEY = 512
"""Longest key [characters]."""
MAX_SESSION = 0xFFFF_FFFF
MAX_NAME = 64
"""Most characters of a robot's or an operator's name, and of each part of a fleet's."""
_MOST_PARTS = 8
_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9._-]*", re.ASCII)
_ROLES = {role.value: role for role in (Role.OBSERVE, Role.OPERATE, Role.SUPERVISE)}
ROBOT, ROUTER = "robot", "router"
HOLDERS = (ROUTER, ROBOT, *_ROLES)
"""The roles of those who hold a certificate of a fleet."""
ANY = "*"
"""Stands for any one part in a pattern."""


class KeyKind(enum.Enum):
    """What stands at a key; see the table of this file."""

    ALIVE = "alive"
    OPERATOR = "operator"
    OPERATORS = "operators"
    DEFINITIONS = "definitions"
    CLOCK = "clock"
    STATE = "state"
    PICTURE = "picture"
    THIN = "thin"
    LAST = "last"
    COMMAND = "command"
    ASK = "ask"
    REFUSAL = "refusal"


_PARTS: dict[KeyKind, tuple[str, ...]] = {
    **dict.fromkeys((KeyKind.ALIVE, KeyKind.OPERATORS, KeyKind.DEFINITIONS, KeyKind.CLOCK), ()),
    **dict.fromkeys((KeyKind.STATE, KeyKind.PICTURE, KeyKind.THIN, KeyKind.LAST), ("message",)),
    KeyKind.OPERATOR: ("operator", "session"),
    KeyKind.COMMAND: ("operator", "message"),
    KeyKind.ASK: ("operator", "message"),
    KeyKind.REFUSAL: ("operator",),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class FleetKey:
    """A key of a fleet, in its parts.

    Attributes:
        kind: What stands there.
        robot: The robot's name in the fleet.
        operator: The operator, with its role; None: the kind has none.
        session: Number of the operator's session; 0: the kind has none.
        message: Name of the message; empty: the kind has none.
    """

    kind: KeyKind
    robot: str
    operator: Principal | None = None
    session: int = 0
    message: str = ""

    def under(self, fleet: str) -> str:
        """The key's text in a fleet.

        Raises:
            FleetKeyError: A part is missing, or cannot stand in a key.
        """
        parts = [check_fleet(fleet), VERSION, _checked(self.robot, "robot"), self.kind.value]
        for part in _PARTS[self.kind]:
            if part == "operator":
                parts.append(operator_text(self.operator))
            elif part == "session":
                parts.append(str(_session(str(self.session))))
            else:
                parts.append(_message(self.message))
        return "/".join(parts)


def pattern(
    fleet: str,
    kind: KeyKind,
    *,
    robot: str = ANY,
    operator: Principal | None = None,
    message: str = ANY,
) -> str:
    """The key expression of all keys of a kind; what is not given matches anything.

    Raises:
        FleetKeyError: A part cannot stand in a key.
    """
    who = ANY if operator is None else operator_text(operator)
    given = {
        "operator": who,
        "session": ANY,
        "message": message if message == ANY else _message(message),
    }
    where = robot if robot == ANY else _checked(robot, "robot")
    parts = (given[part] for part in _PARTS[kind])
    return "/".join((check_fleet(fleet), VERSION, where, kind.value, *parts))


def parse_key(fleet: str, text: str) -> FleetKey:
    """The parts of a key that came from outside.

    Raises:
        FleetKeyError: It is no key of this fleet.
    """
    start = f"{fleet}/{VERSION}/"
    if len(text) > MAX_KEY or not text.startswith(start):
        raise _refused(text, f"keys of this fleet begin with {start}")
    robot, *rest = text.removeprefix(start).split("/")
    kind = next((each for each in KeyKind if rest and each.value == rest[0]), None)
    if kind is None:
        raise _refused(text, "its kind is none that Rune knows")
    names = _PARTS[kind]
    if len(rest) - 1 != len(names):
        raise _refused(text, f"{kind.value!r} is followed by {len(names)} parts")
    given = dict(zip(names, rest[1:], strict=True))
    return FleetKey(
        kind=kind,
        robot=_checked(robot, "robot"),
        operator=parse_operator(given["operator"]) if "operator" in given else None,
        session=_session(given["session"]) if "session" in given else 0,
        message=_message(given["message"]) if "message" in given else "",
    )


def check_fleet(fleet: str) -> str:
    """The name of a fleet: one name, or several with "/" between.

    Raises:
        FleetKeyError: It cannot begin a key.
    """
    parts = fleet.split("/")
    if len(parts) > _MOST_PARTS:
        raise _refused(fleet, f"the name of a fleet has at most {_MOST_PARTS} parts")
    for part in parts:
        _checked(part, "fleet")
    return fleet


def parse_operator(text: str) -> Principal:
    """The operator in a key, such as "operate:alice".

    Raises:
        FleetKeyError: It names no role of an operator, or no name.
    """
    role, _, name = text.partition(":")
    if role not in _ROLES:
        raise _refused(text, f"an operator's role is one of {', '.join(_ROLES)}")
    return Principal(name=_checked(name, "operator"), role=_ROLES[role])


def operator_text(operator: Principal | None) -> str:
    """The operator's part of a key.

    Raises:
        FleetKeyError: There is none, or a key cannot hold it.
    """
    if operator is None:
        raise _refused(str(operator), "this kind of key needs an operator")
    parse_operator(str(operator))
    return str(operator)


def _checked(name: str, owner: str) -> str:
    if len(name) > MAX_NAME or _NAME.fullmatch(name) is None:
        reason = (
            f"the name of a {owner} has 1 to {MAX_NAME} letters (a to z), digits, '.', '_' and "
            "'-', with no '.' or '-' first"
        )
        raise _refused(name, reason)
    return name


def _message(name: str) -> str:
    from hub.ipc.definition import check_name  # it brings numpy, which a command line does without

    try:
        check_name(name)
    except MessageFormatError as error:
        raise _refused(name, "a message name is 1 to 64 letters, digits and underscores") from error
    return name


def _session(text: str) -> int:
    digits = text.isascii() and text.isdecimal() and len(text) <= 10
    number = int(text) if digits else 0
    if not 0 < number <= MAX_SESSION or str(number) != text:
        raise _refused(text, f"a session is a number from 1 to {MAX_SESSION}")
    return number


def _refused(text: str, reason: str) -> FleetKeyError:
    return FleetKeyError(text, reason)
