"""The token of a hub that listens at a TCP port of this machine.

A port of loopback admits all users of the machine, and the web pages in their browsers. So a client
there shows a token, which it reads from a file that only this user can read. The file belongs to
the port and stays: clients know the token again after the hub restarts.
"""

from __future__ import annotations

import hmac
import re
import secrets
from dataclasses import field
from pathlib import Path

import zmq

from hub import paths
from hub.errors import KeyFileError
from hub.ipc.roles import LOCAL, Principal, Role
from hub.ipc.security import key_files
from hub.toml_reader import Key, RefusedError
from hub.values import dataclass

_USER = b"rune"
_BYTES = 32
_TOKEN = re.compile(r"[0-9a-f]{64}")
_ADVICE = "copy it again from the machine of the hub"


def _token_text(value: object) -> str:
    if isinstance(value, str) and _TOKEN.fullmatch(value):
        return value
    text = "this is no token of 64 hexadecimal digits"
    raise RefusedError(text)


TOKEN_KEYS = {"token": Key(_token_text)}


@dataclass(frozen=True, slots=True, kw_only=True)
class Token:
    """A token, and its use by a client.

    Attributes:
        text: The token; not shown in its repr.
        path: Its file.
    """

    text: str = field(repr=False)
    path: Path | None = field(default=None, compare=False)

    @property
    def principal(self) -> Principal:
        """Its holder is a client of this machine."""
        return LOCAL

    @property
    def role(self) -> Role:
        """Role of its holder."""
        return LOCAL.role

    def apply(self, socket: zmq.Socket[bytes]) -> None:
        """Set the token of a client's socket, before it connects."""
        socket.plain_username = _USER
        socket.plain_password = self.text.encode()

    def admits(self, credentials: tuple[bytes, ...]) -> bool:
        """Whether these are the user name and password of a holder."""
        return len(credentials) == 2 and hmac.compare_digest(credentials[1], self.text.encode())


def token_file(port: int) -> Path:
    """The file of the token of a hub at this port."""
    return paths.for_hubs()[0] / ".tokens" / str(port)


def read_token(path: Path) -> Token:
    """The token in a file.

    Raises:
        KeyFileError: It is missing, damaged, or open to others.
    """
    values = key_files.read_private(path, advice=_ADVICE)
    fields = key_files.read_keys(TOKEN_KEYS, values, "the file", path, advice=_ADVICE)
    return Token(text=fields["token"], path=path)


def known_token(port: int) -> Token | None:
    """The token for a port of this machine, if this user has one."""
    try:
        return read_token(token_file(port))
    except KeyFileError:
        return None


def own_token(port: int) -> Token:
    """The token of a hub that listens at this port, made at the first time.

    Raises:
        KeyFileError: It cannot be kept in a file that only this user can read.
    """
    known = known_token(port)
    if known is not None:
        return known
    path = token_file(port)
    for folder in (path.parent.parent, path.parent):
        key_files.private_folder(folder)
    made = Token(text=secrets.token_hex(_BYTES), path=path)
    key_files.write_private(
        path, f'# The token of the hub at TCP port {port}.\ntoken = "{made.text}"\n'
    )
    return made
