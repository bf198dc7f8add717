"""Where central may listen, to whom a client may talk, and what each role may do.

Without keys the bus stays on this machine. Pure decisions only: keys are in `keys.py` and
`keyring.py`, the sockets that other machines reach in `gateway.py`.
"""

from __future__ import annotations

import enum
import functools
import hashlib
import ipaddress
import re
from dataclasses import dataclass

from hub.errors import EndpointError, NotAllowedError

DEFAULT_PORT = 1381
DEFAULT_ENDPOINT = f"tcp://127.0.0.1:{DEFAULT_PORT}"
CONTROL = "control"
"""The place where control messages come in; the others are "PLANE in" and "PLANE out"."""
_MAX_IPC_PATH = 100
_KNOWN_BEARERS = 2048
"""Bearers that are remembered; a list has half as many keys."""
_KEY_PRINT = re.compile(r"[0-9a-f]{32}")
_HOST_NAME = re.compile(r"[A-Za-z0-9]([A-Za-z0-9._-]{0,251}[A-Za-z0-9])?")


class Role(enum.Enum):
    """What a key is for; each role may do what the ones before it may."""

    OBSERVE = "observe"
    OPERATE = "operate"
    SUPERVISE = "supervise"
    MODULE = "module"

    def includes(self, other: Role) -> bool:
        """Whether holders of this role may do all that holders of the other may."""
        return _ROLES.index(self) >= _ROLES.index(other)


_ROLES = tuple(Role)


ON_THE_ROBOT = "do it on the robot's machine, where no key is needed"


class Action(enum.Enum):
    """What a client asks central for; the value says it in an error.

    Who may publish, and query on the command plane, is in `publish_rights`.
    """

    SUBSCRIBE = "subscribe"
    LIST = "list messages and modules"
    PRESENCE = "hear who comes and goes"
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
class Bearer:
    """Who is at the other end of a connection: the holder of a key.

    Two keys are two bearers, also if one was made after the other under the same name.

    Attributes:
        name: Of the key.
        role: What the key is for.
        key: Fingerprint of the public key; empty for who connects without one.
    """

    name: str
    role: Role
    key: str = ""

    @staticmethod
    def of(name: str, role: Role, public: str) -> Bearer:
        """The bearer of a public key (Z85)."""
        return Bearer(name=name, role=role, key=_fingerprint(public))

    @property
    def user_id(self) -> str:
        """As ZeroMQ carries it beside each frame of the connection: "operate:alice:FINGERPRINT"."""
        return f"{self}:{self.key}"

    def __str__(self) -> str:
        """As people read it: "operate:alice"."""
        return f"{self.role.value}:{self.name}"


LOCAL = Bearer(name="this machine", role=Role.MODULE)
"""Whoever connects without a key; that works on this machine only, whose users are trusted."""


@functools.lru_cache(maxsize=_KNOWN_BEARERS)
def parse_bearer(user_id: str) -> Bearer:
    """The bearer that a frame's User-Id names.

    Raises:
        NotAllowedError: It names none, so its sender has no rights here.
    """
    role, _, rest = user_id.partition(":")
    name, _, key = rest.rpartition(":")
    known = role in {each.value for each in Role}
    if not name or not known or _KEY_PRINT.fullmatch(key) is None:
        text = f"a connection says it belongs to {user_id[:80]!r}, which is no role, name and key"
        raise NotAllowedError(text)
    return Bearer(name=name, role=Role(role), key=key)


def _fingerprint(public: str) -> str:
    return hashlib.blake2b(public.encode(), digest_size=16).hexdigest()


def may(role: Role, action: Action) -> bool:
    """Whether holders of this role may do this."""
    return action in _ACTIONS[role]


def demand(bearer: Bearer, action: Action) -> None:
    """Refuse what the bearer's role does not allow.

    Raises:
        NotAllowedError: It does not; the text names the least role that does.
    """
    if not may(bearer.role, action):
        least = next(role for role in Role if may(role, action))
        way = f"that needs a key made with --role {least.value}"
        if least is Role.MODULE:  # a key that is a part of the robot is no remedy for a person
            way = ON_THE_ROBOT
        text = f"{bearer.name} has a key to {bearer.role.value} and may not {action.value}; {way}"
        raise NotAllowedError(text)


def may_enter(role: Role, place: str) -> bool:
    """Whether holders of this role may connect to a place: CONTROL, "PLANE in" or "PLANE out".

    Every role enters "command in": what passes there is looked at frame by frame.
    """
    plane, _, way = place.rpartition(" ")
    if place == CONTROL or (plane and way == "out"):
        return True
    return bool(plane) and way == "in" and (plane == "command" or role is Role.MODULE)


@dataclass(frozen=True, slots=True)
class TcpEndpoint:
    """A TCP address; port 0 lets the system choose when binding."""

    host: str
    port: int

    def __str__(self) -> str:
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"tcp://{host}:{self.port or '*'}"

    @property
    def on_loopback(self) -> bool:
        """Whether only this machine reaches it."""
        return _is_loopback(self.host)


@dataclass(frozen=True, slots=True)
class IpcEndpoint:
    """A Unix domain socket."""

    path: str

    def __str__(self) -> str:
        return f"ipc://{self.path}"


def parse_endpoint(text: str, *, beyond_loopback: bool = False) -> TcpEndpoint | IpcEndpoint:
    """The endpoint that a person wrote, for a hub to listen at.

    Args:
        text: Such as tcp://127.0.0.1:1381 or ipc:///a/path.
        beyond_loopback: Whether other machines may be let in, which takes keys.

    Raises:
        EndpointError: It is malformed, or not on this machine and that is not allowed.
    """
    scheme, separator, rest = text.partition("://")
    if separator and scheme == "ipc" and rest:
        if len(rest.encode()) > _MAX_IPC_PATH:
            reason = f"its path is longer than {_MAX_IPC_PATH} bytes"
            raise EndpointError(_refusal(text, reason))
        if "*" in rest:
            raise EndpointError(_refusal(text, "write the path of a socket file"))
        return IpcEndpoint(rest)
    endpoint = _tcp(text)
    if endpoint.on_loopback:
        return endpoint
    if not beyond_loopback:
        raise EndpointError(_refusal(text, _NEEDS_KEYS))
    if not _is_address(endpoint.host):
        reason = "write an address of this machine, or 0.0.0.0 for all of them"
        raise EndpointError(_refusal(text, reason))
    return endpoint


def connectable(text: str, *, with_keys: bool = False) -> str:
    """The endpoint that a person wrote, as the address a client connects to.

    Args:
        text: Such as tcp://127.0.0.1:1381; with keys also tcp://robot.example:1481.
        with_keys: Whether the client has keys, and so may leave this machine.

    Raises:
        EndpointError: It is malformed, names no port, or is not on this machine and the client
            has no keys.
    """
    endpoint: TcpEndpoint | IpcEndpoint
    if with_keys and text.startswith("tcp://"):
        endpoint = _tcp(text)
        if not (_is_address(endpoint.host) or _HOST_NAME.fullmatch(endpoint.host)):
            raise EndpointError(_refusal(text, "its host is no name and no address"))
        if _is_address(endpoint.host) and ipaddress.ip_address(endpoint.host).is_unspecified:
            raise EndpointError(_refusal(text, "that is where a hub listens; name its machine"))
    else:
        endpoint = parse_endpoint(text)
    if isinstance(endpoint, TcpEndpoint) and endpoint.port == 0:
        raise EndpointError(_refusal(text, "port 0 is only for a hub that starts"))
    return str(endpoint)


_NEEDS_KEYS = (
    "without keys only this machine (127.0.0.1) is allowed; go to a robot through ssh (`rune` has "
    "--ssh USER@HOST, `rune-hub` goes through ssh -L), or give --keys the file of a key that "
    "`rune-hub keys make NAME --role operate` has made on it"
)


def _tcp(text: str) -> TcpEndpoint:
    scheme, separator, rest = text.partition("://")
    host, colon, port = rest.rpartition(":")
    if not separator or scheme != "tcp" or not colon or not (port.isdigit() and port.isascii()):
        raise EndpointError(_refusal(text, "write tcp://127.0.0.1:1381 or ipc:///a/path"))
    if len(port) > 5 or int(port) > 65529:
        raise EndpointError(_refusal(text, "its port is above 65529"))
    host = host.strip("[]")
    return TcpEndpoint("127.0.0.1" if host == "localhost" else host, int(port))


def _is_address(host: str) -> bool:
    try:
        return not ipaddress.ip_address(host).is_multicast
    except ValueError:
        return False


def _is_loopback(host: str) -> bool:
    return _is_address(host) and ipaddress.ip_address(host).is_loopback


def _refusal(text: str, reason: str) -> str:
    return f"endpoint {text[:80]!r} cannot be used: {reason}"
