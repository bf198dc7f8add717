"""The hub's own keys, and the list of keys that may connect from other machines.

A folder holds `hub.toml` (the hub's key pair) and `list.toml` (name, role and public key of each
holder). It also holds `clients/NAME.toml` (the file to copy to that client's machine).
"""

from __future__ import annotations

import contextlib
import fcntl
import os
from collections.abc import Iterable, Iterator
from pathlib import Path

from hub.errors import KeyFileError, KeyNameError
from hub.ipc.roles import Principal, Role
from hub.ipc.security import key_files
from hub.ipc.security.client_keys import ClientKeys, KeyPair, write_client_keys
from hub.nearest import did_you_mean
from hub.toml_reader import Key
from hub.values import dataclass

MAX_KEYS = 1000
_ADVICE = "put the file back, or delete it and make a new key for every client"
_HUB = {"public": Key(key_files.key_text), "secret": Key(key_files.key_text)}
_HOLDER = {"role": Key(key_files.key_role), "public": Key(key_files.key_text)}

_Signature = tuple[int, int, int]


@dataclass(frozen=True, slots=True, kw_only=True)
class Holder:
    """A holder of a key: name, role and public key (Z85)."""

    name: str
    role: Role
    public: str

    @property
    def principal(self) -> Principal:
        """The principal of this key."""
        return Principal.of(self.name, self.role, self.public)


def default_folder() -> Path:
    """The default folder of keys: $XDG_CONFIG_HOME/rune/keys or ~/.config/rune/keys.

    Raises:
        KeyFileError: The user has no home.
    """
    named = Path(os.environ.get("XDG_CONFIG_HOME", ""))
    if named.is_absolute():  # the XDG specification ignores relative paths
        return named / "rune" / "keys"
    try:
        return Path.home() / ".config" / "rune" / "keys"
    except RuntimeError as fault:
        reason = "this user has no home; name a folder with --folder"
        raise KeyFileError(Path("~/.config/rune/keys"), reason) from fault


class Keyring:
    """The keys in one folder; several processes may use it at the same time.

    Attributes:
        folder: Their folder; made with the first file.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._hub, self._list = folder / "hub.toml", folder / "list.toml"
        self._seen: _Signature | None = None
        self._holders: dict[str, Holder] = {}

    def hub_keys(self) -> KeyPair:
        """The hub's own keys, made on first use.

        Raises:
            KeyFileError: The file is damaged, open to others, or cannot be written.
        """
        if key_files.is_there(self._hub):  # no lock: a read-only folder is enough
            key_files.private_folder(self.folder)
            return self._hub_keys()
        with _alone_in(self.folder):
            return self._hub_keys()

    def holders(self) -> tuple[Holder, ...]:
        """All holders of keys, by name; read again after a change of the file.

        Raises:
            KeyFileError: The list is damaged or open to others.
        """
        self._refresh()
        return tuple(sorted(self._holders.values(), key=lambda holder: holder.name))

    def holder(self, public: str) -> Holder | None:
        """The holder of this key, by the present list.

        Raises:
            KeyFileError: The list is damaged or open to others.
        """
        self._refresh()
        return self._holders.get(public)

    def make(self, name: str, role: Role) -> Path:
        """Make a key and put it on the list; returns the file for the client's machine.

        Raises:
            KeyNameError: The name is taken or invalid.
            KeyFileError: A file cannot be used.
        """
        if not key_files.is_key_name(name):
            text = f"no key can be called {name[:80]!r}; take 1 to 64 letters, digits, - and _"
            raise KeyNameError(text)
        path = self.folder / "clients" / f"{name}.toml"
        with _alone_in(self.folder):
            holders = self.holders()
            if name in {holder.name for holder in holders}:
                text = f"{name!r} has a key already; first say: rune-hub keys remove {name}"
                raise KeyNameError(text)
            if len(holders) >= MAX_KEYS:
                reason = f"it has {MAX_KEYS} keys already; remove some with `rune-hub keys remove`"
                raise KeyFileError(self._list, reason)
            pair, hub = KeyPair.new(), self._hub_keys()
            holder = Holder(name=name, role=role, public=pair.public)
            key_files.private_folder(path.parent)
            write_client_keys(
                path, ClientKeys(principal=holder.principal, pair=pair, hub=hub.public)
            )
            try:
                self._write([*holders, holder])
            except KeyFileError:
                path.unlink(missing_ok=True)  # a key without rights would only confuse
                raise
        return path

    def remove(self, name: str) -> None:
        """Remove a key from the list: the hub refuses new connections with it.

        Raises:
            KeyNameError: There is no such key.
            KeyFileError: A file cannot be used.
        """
        with _alone_in(self.folder):
            holders = self.holders()
            names = [holder.name for holder in holders]
            if name not in names:
                known = did_you_mean(name, names) or "; `rune-hub keys list` shows all"
                text = f"there is no key {name[:80]!r} in {self.folder}{known}"
                raise KeyNameError(text)
            self._write(holder for holder in holders if holder.name != name)
            with contextlib.suppress(OSError):  # it may have been moved to the client's machine
                (self.folder / "clients" / f"{name}.toml").unlink()

    def _hub_keys(self) -> KeyPair:
        if not key_files.is_there(self._hub):
            pair = KeyPair.new()
            key_files.write_private(
                self._hub,
                "# The hub's own keys. A client knows the hub by the public one.\n"
                f'public = "{pair.public}"\nsecret = "{pair.secret}"\n',
            )
            return pair
        values = key_files.read_private(self._hub, advice=_ADVICE)
        fields = key_files.read_keys(_HUB, values, "the file", self._hub, advice=_ADVICE)
        pair = KeyPair(public=fields["public"], secret=fields["secret"])
        pair.demand_whole(self._hub, _ADVICE)
        return pair

    def _refresh(self) -> None:
        try:
            found = self._list.stat()
        except FileNotFoundError:
            self._seen, self._holders = None, {}
            return
        except OSError as fault:
            raise KeyFileError(self._list, f"{fault.strerror}; {_ADVICE}") from fault
        # A replaced file has another inode, at any resolution of the clock; the time of change
        # shows a new mode as well.
        signature = (found.st_ctime_ns, found.st_size, found.st_ino)
        if signature != self._seen:
            # Forget the old list first: a damaged list admits no client.
            self._seen, self._holders = None, {}
            self._holders = self._read()
            self._seen = signature

    def _read(self) -> dict[str, Holder]:
        holders: dict[str, Holder] = {}
        values = key_files.read_private(self._list, advice=_ADVICE)
        for name, table in values.items():
            if not key_files.is_key_name(name):
                raise KeyFileError(self._list, f"{name[:80]!r} is no name; {_ADVICE}")
            fields = key_files.read_keys(_HOLDER, table, name, self._list, advice=_ADVICE)
            if (first := holders.get(fields["public"])) is not None:
                reason = f"{first.name} and {name} have the same key; {_ADVICE}"
                raise KeyFileError(self._list, reason)
            holders[fields["public"]] = Holder(name=name, **fields)
        return holders

    def _write(self, holders: Iterable[Holder]) -> None:
        tables = [
            f'\n[{holder.name}]\nrole = "{holder.role.value}"\npublic = "{holder.public}"\n'
            for holder in sorted(holders, key=lambda holder: holder.name)
        ]
        head = "# Keys that may connect from other machines; written by `rune-hub keys`.\n"
        key_files.write_private(self._list, head + "".join(tables))


@contextlib.contextmanager
def _alone_in(folder: Path) -> Iterator[None]:
    """Make the folder if needed, and hold an exclusive lock.

    Raises:
        KeyFileError: The folder cannot be used.
    """
    key_files.private_folder(folder)
    try:
        descriptor = os.open(folder / "lock", os.O_RDWR | os.O_CREAT, 0o600)
    except OSError as fault:
        reason = f"it cannot be made ({key_files.reason_of(fault)}); choose another --folder"
        raise KeyFileError(folder / "lock", reason) from fault
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX)
        yield
    finally:
        os.close(descriptor)
