"""Roles of keys, and what each role may do; pure.

Which messages each role may publish is in `security/publish_rights.py`.
"""

from __future__ import annotations

import enum
import functools
import hashlib
import re

from hub.errors import NotAllowedError
from hub.values import dataclass

CONTROL, COMMANDS = "control", "command in"
"""The entrances of control messages and commands; all but the first are "PLANE in" or "out"."""
_CACHED_PRINCIPALS = 2048
"""Most cached principals; a list has half as many keys."""
_KEY_PRINT = re.compile(r"[0-9a-f]{32}")


class Role(enum.Enum):
    """The role of a key; each role includes the ones before it."""

    OBSERVE = "observe"
    OPERATE = "operate"
    SUPERVISE = "supervise"
    MODULE = "module"

    def includes(self, other: Role) -> bool:
        """Whether this role has all rights of the other."""
        return _ROLES.index(self) >= _ROLES.index(other)


_ROLES = tuple(Role)


ON_THE_ROBOT = "do it on the robot's machine, where no key is needed"


class Action(enum.Enum):
    """A request to central; the value is its name in an error.

    Rights to publish, and to query on the command plane, are in `publish_rights`.
    """

    SUBSCRIBE = "subscribe"
    LIST = "list messages and modules"
    PRESENCE = "watch connections"
    QUERY = "query"
    TAKE_OVER = "take control from others"
    DEFINE = "define a new message"
    ANSWER = "answer queries"
    CLOSE_MODULE = "close modules"
    SET_LOG_LEVEL = "set the log level"


_WATCH = frozenset({Action.SUBSCRIBE, Action.LIST, Action.PRESENCE, Action.QUERY})
_ACTIONS = {
    Role.OBSERVE: _WATCH,
    Role.OPERATE: _WATCH,
    Role.SUPERVISE: _WATCH | {Action.TAKE_OVER},
    Role.MODULE: frozenset(Action),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Principal:
    """The holder of a key, at the other end of a connection.

    Two keys are two principals, even if one replaced the other under the same name.

    Attributes:
        name: Of the key.
        role: Role of the key.
        key: Fingerprint of the public key; empty without one.
    """

    name: str
    role: Role
    key: str = ""

    @staticmethod
    def of(name: str, role: Role, public: str) -> Principal:
        """The principal of a public key (Z85)."""
        return Principal(name=name, role=role, key=_fingerprint(public))

    @property
    def user_id(self) -> str:
        """Its text in ZeroMQ's metadata of each frame: "operate:alice:FINGERPRINT"."""
        return f"{self}:{self.key}"

    def __str__(self) -> str:
        """Its text for people: "operate:alice"."""
        return f"{self.role.value}:{self.name}"


LOCAL = Principal(name="this machine", role=Role.MODULE)
"""A client without a key. It connects on this machine only, whose users are trusted."""


@functools.lru_cache(maxsize=_CACHED_PRINCIPALS)
def parse_principal(user_id: str) -> Principal:
    """The principal in a frame's User-Id.

    Raises:
        NotAllowedError: It names none: its sender has no rights.
    """
    role, _, rest = user_id.partition(":")
    name, _, key = rest.rpartition(":")
    known = role in {each.value for each in Role}
    if not name or not known or _KEY_PRINT.fullmatch(key) is None:
        text = f"a connection has the user id {user_id[:80]!r}, which is no role, name and key"
        raise NotAllowedError(text)
    return Principal(name=name, role=Role(role), key=key)


def _fingerprint(public: str) -> str:
    return hashlib.blake2b(public.encode(), digest_size=16).hexdigest()


def may(role: Role, action: Action) -> bool:
    """Whether a role has this right."""
    return action in _ACTIONS[role]


def demand(principal: Principal, action: Action) -> None:
    """Check the right of a principal.

    Raises:
        NotAllowedError: It is missing; the text names the least role that has it.
    """
    if not may(principal.role, action):
        least = next(role for role in Role if may(role, action))
        remedy = f"that needs a key made with --role {least.value}"
        if least is Role.MODULE:  # a person cannot get a key of a module
            remedy = ON_THE_ROBOT
        has = f"{principal.name} has a key to {principal.role.value}"
        text = f"{has} and may not {action.value}; {remedy}"
        raise NotAllowedError(text)


def may_connect(role: Role, place: str) -> bool:
    """Whether a role may connect to a place: CONTROL, "PLANE in" or "PLANE out".

    Every role may enter "command in": the gateway checks each frame there.
    """
    plane, _, remedy = place.rpartition(" ")
    if place == CONTROL or (plane and remedy == "out"):
        return True
    return bool(plane) and remedy == "in" and (plane == "command" or role is Role.MODULE)
