"""The commands of `rune-hub keys`; each returns the exit code. No hub needs to run."""

from __future__ import annotations

from pathlib import Path

from hub.command_output import put, put_json
from hub.ipc.roles import Role
from hub.ipc.security.keyring import Keyring, default_folder

_ROLE_WIDTH, _KEY_WIDTH = 11, 42


def keyring(folder: Path | None) -> Keyring:
    """The keys in this folder, or in the one where they belong.

    Raises:
        KeyFileError: None is given, and the user has no home.
    """
    return Keyring(folder or default_folder())


def make(keys: Keyring, name: str, role: Role) -> int:
    """Make a key, and print the file to copy.

    Raises:
        KeyNameError: The name is taken, or cannot be one.
        KeyFileError: A file cannot be used.
    """
    path = keys.make(name, role)
    put(f"{name} may {role.value}; copy this file to the machine that is to connect:")
    put(str(path))
    return 0


def list_all(keys: Keyring, *, as_json: bool) -> int:
    """Show name, role and public key of each.

    Raises:
        KeyFileError: The list is damaged or open to others.
    """
    holders = keys.holders()
    if not holders and not as_json:
        put(f"no keys in {keys.folder}; make one with: rune-hub keys make NAME --role ROLE")
    if holders and not as_json:
        put(f"{'ROLE':<{_ROLE_WIDTH}}{'PUBLIC KEY':<{_KEY_WIDTH}}NAME")
    for holder in holders:
        if as_json:
            shown = {"name": holder.name, "role": holder.role.value, "public": holder.public}
            put_json(shown)
        else:
            put(f"{holder.role.value:<{_ROLE_WIDTH}}{holder.public:<{_KEY_WIDTH}}{holder.name}")
    return 0


def remove(keys: Keyring, name: str) -> int:
    """Refuse a key from now on.

    Raises:
        KeyNameError: There is no such key.
        KeyFileError: A file cannot be used.
    """
    keys.remove(name)
    put(f"{name} is refused from now on; connections it has go on until they end")
    return 0
