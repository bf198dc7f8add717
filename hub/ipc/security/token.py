"""The token of a hub that listens at a TCP port of this machine.

A port of loopback admits all users of the machine, and the web pages in their browsers. So a client
there needs a token, which it reads from a file that only this user can read. The file belongs to
the port and stays: clients know the token again after the hub restarts.

While the hub is down, another program can listen at its port. So no socket carries the token:

| socket | both sides prove | another program learns |
| --- | --- | --- |
| control | by CURVE, with key pairs that are derived from the token | nothing |
| planes | by PLAIN, with a password of this run of the hub | a password that never counts again |

The planes carry most bytes, and are not encrypted: the link shaper would measure that.
"""

from __future__ import annotations

import hashlib
import hmac
import re
import secrets
from dataclasses import field
from pathlib import Path

import zmq
from zmq.utils import z85

from hub import paths
from hub.errors import KeyFileError
from hub.ipc.roles import LOCAL, Principal, Role
from hub.ipc.security import key_files
from hub.ipc.security.client_keys import KeyPair
from hub.toml_reader import Key, RefusedError
from hub.values import dataclass

_USER = b"rune"
_HUB, _CLIENT = "hub", "client"
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
        """Set the keys of a client's control socket, before it connects."""
        pair = self._pair(_CLIENT)
        socket.curve_publickey = pair.public.encode()
        socket.curve_secretkey = pair.secret.encode()
        socket.curve_serverkey = self._pair(_HUB).public.encode()

    def serve(self, socket: zmq.Socket[bytes]) -> None:
        """Set the keys of the hub's control socket, before it is bound."""
        socket.curve_server = True
        socket.curve_secretkey = self._pair(_HUB).secret.encode()

    def admits(self, credentials: tuple[bytes, ...]) -> bool:
        """Whether this is the public key of a holder, as ZAP has it."""
        public = z85.decode(self._pair(_CLIENT).public)
        return len(credentials) == 1 and hmac.compare_digest(credentials[0], public)

    def of_run(self, epoch: int) -> RunPassword:
        """The password for the planes of one run of the hub."""
        return RunPassword(text=self._derived(f"run {epoch}").hex())

    def _pair(self, side: str) -> KeyPair:
        secret = z85.encode(self._derived(side))
        return KeyPair(public=zmq.curve_public(secret).decode(), secret=secret.decode())

    def _derived(self, use: str) -> bytes:
        return hashlib.blake2b(use.encode(), key=self.text.encode(), digest_size=32).digest()


@dataclass(frozen=True, slots=True, kw_only=True)
class RunPassword:
    """What a client shows at the planes of one run of the hub.

    Attributes:
        text: The password; not shown in its repr.
    """

    text: str = field(repr=False)

    def apply(self, socket: zmq.Socket[bytes]) -> None:
        """Set the password of a client's socket, before it connects."""
        socket.plain_username = _USER
        socket.plain_password = self.text.encode()

    def serve(self, socket: zmq.Socket[bytes]) -> None:
        """Have the hub's socket of a plane ask for a password, before it is bound."""
        socket.plain_server = True

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
    """The token of a hub that will listen at this port: the known one, or a new one.

    Port 0 stands for a free port, which has no known one.
    """
    known = known_token(port) if port else None
    return known or Token(text=secrets.token_hex(_BYTES))


def keep_token(token: Token, port: int) -> Path:
    """Keep the token of a hub that listens at this port; its file.

    Raises:
        KeyFileError: It cannot be kept in a file that only this user can read.
    """
    path = token_file(port)
    if token.path is None:
        for folder in (path.parent.parent, path.parent):
            key_files.private_folder(folder)
        text = f'# The token of the hub at TCP port {port}.\ntoken = "{token.text}"\n'
        key_files.write_private(path, text)
    return path
