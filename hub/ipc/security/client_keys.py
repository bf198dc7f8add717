"""A client's keys: their file, which a person copies to a console's machine, and their use."""

from __future__ import annotations

from dataclasses import field
from pathlib import Path

import zmq

from hub.errors import KeyFileError
from hub.ipc.roles import Principal, Role
from hub.ipc.security import key_files
from hub.toml_reader import Key
from hub.values import dataclass

_ADVICE = "copy it again from the robot, or make a new one there with `rune-hub keys make`"
_KEYS = {
    "name": Key(key_files.key_name),
    "role": Key(key_files.key_role),
    "public": Key(key_files.key_text),
    "secret": Key(key_files.key_text),
    "hub": Key(key_files.key_text),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class KeyPair:
    """A CURVE key pair in Z85, 40 characters each; the secret is not shown in its repr."""

    public: str
    secret: str = field(repr=False)

    @staticmethod
    def new() -> KeyPair:
        """A new pair."""
        public, secret = zmq.curve_keypair()
        return KeyPair(public=public.decode(), secret=secret.decode())

    def demand_whole(self, path: Path, advice: str) -> None:
        """Check that the two keys belong together.

        Raises:
            KeyFileError: They do not; `path` is their file.
        """
        if zmq.curve_public(self.secret.encode()).decode() != self.public:
            raise KeyFileError(path, f"its public and secret key are no pair; {advice}")


@dataclass(frozen=True, slots=True, kw_only=True)
class ClientKeys:
    """The keys for connections from another machine.

    Attributes:
        principal: The client at the hub.
        pair: Its own keys.
        hub: Public key of the hub: no other can pretend to be it.
        path: Their file; None: they are from none.
    """

    principal: Principal
    pair: KeyPair
    hub: str
    path: Path | None = field(default=None, compare=False)

    @property
    def role(self) -> Role:
        """Its role at the hub."""
        return self.principal.role

    def apply(self, socket: zmq.Socket[bytes]) -> None:
        """Set the keys of a client's socket, before it connects."""
        socket.curve_publickey = self.pair.public.encode()
        socket.curve_secretkey = self.pair.secret.encode()
        socket.curve_serverkey = self.hub.encode()


def read_client_keys(path: Path) -> ClientKeys:
    """The keys in a file from `rune-hub keys make`.

    Raises:
        KeyFileError: It is missing, damaged, or open to others.
    """
    values = key_files.read_private(path, advice=_ADVICE)
    fields = key_files.read_keys(_KEYS, values, "the file", path, advice=_ADVICE)
    pair = KeyPair(public=fields["public"], secret=fields["secret"])
    pair.demand_whole(path, _ADVICE)
    principal = Principal.of(fields["name"], fields["role"], pair.public)
    return ClientKeys(principal=principal, pair=pair, hub=fields["hub"], path=path)


def write_client_keys(path: Path, keys: ClientKeys) -> None:
    """Write the file that `read_client_keys` reads.

    Raises:
        KeyFileError: It cannot be written.
    """
    text = (
        "# A key to a robot's hub. Everyone with this file can use it.\n"
        f'name = "{keys.principal.name}"\n'
        f'role = "{keys.principal.role.value}"\n'
        f'public = "{keys.pair.public}"\n'
        f'secret = "{keys.pair.secret}"\n'
        f'hub = "{keys.hub}"\n'
    )
    key_files.write_private(path, text)
