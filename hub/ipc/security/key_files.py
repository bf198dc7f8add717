"""Files that hold keys: their permissions, their replacement, and their content."""

from __future__ import annotations

import contextlib
import os
import re
import stat
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from zmq.utils import z85

from hub import files
from hub.errors import KeyFileError
from hub.ipc.roles import Role
from hub.toml_reader import Key, Problems, Reader, RefusedError, choice, load, read_table, shorten

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,63}", re.ASCII)
_Z85 = re.compile(r"[0-9a-zA-Z.\-:+=^!/*?&<>()\[\]{}@%$#]{40}", re.ASCII)
_MOST_SHOWN = 5


def is_key_name(text: str) -> bool:
    """Whether this can be a key's name: 1 to 64 letters, digits, - and _, no mark first."""
    return _NAME.fullmatch(text) is not None


def key_text(value: object) -> str:
    """A CURVE key in Z85: 40 characters for 32 bytes (ZeroMQ RFC 32).

    Raises:
        RefusedError: It is none. The text leaves it out, because it may be a secret.
    """
    if isinstance(value, str) and _Z85.fullmatch(value):
        with contextlib.suppress(Exception):  # 40 such characters can still be above 32 bytes
            if len(z85.decode(value)) == 32:
                return value
    text = "this is no key of 40 characters in Z85"
    raise RefusedError(text)


def key_name(value: object) -> str:
    """A valid name of a key.

    Raises:
        RefusedError: It is none.
    """
    if isinstance(value, str) and is_key_name(value):
        return value
    text = f"{shorten(value)} is not a name of 1 to 64 letters, digits, - and _"
    raise RefusedError(text)


key_role: Reader = choice({role.value: role for role in Role})


def is_there(path: Path) -> bool:
    """Whether the file exists, or something that hides it."""
    try:
        return path.exists()
    except OSError:
        return True


def read_private(path: Path, *, advice: str) -> dict[str, Any]:
    """The content of a TOML file that no other user can read or write.

    Args:
        path: The file.
        advice: The remedy for a missing or damaged file.

    Raises:
        KeyFileError: It is missing, damaged, another user's, or open to others.
    """
    try:
        found = path.stat()
    except FileNotFoundError as fault:
        raise KeyFileError(path, f"it is not there; {advice}") from fault
    except (OSError, ValueError) as fault:
        raise KeyFileError(path, f"{reason_of(fault)}; {advice}") from fault
    if stat.S_ISREG(found.st_mode):  # `load` refuses anything but a file
        _demand_private(path, found, f"chmod 600 {path}")
    data, _ = load(path, lambda name, problems: _damaged(name, problems, advice))
    return data


def read_keys(
    keys: Mapping[str, Key], values: object, place: str, path: Path, *, advice: str
) -> dict[str, Any]:
    """The values of one table in a file of keys.

    Raises:
        KeyFileError: Something is missing, unknown or malformed.
    """
    problems = Problems()
    fields = read_table(keys, values, place, problems)
    if problems:
        raise _damaged(str(path), problems, advice)
    return fields


def write_private(path: Path, text: str) -> None:
    """Replace a file at once and whole; only its owner can read it.

    Raises:
        KeyFileError: It cannot be written; the old file stays.
    """
    try:
        files.replace(path, text.encode(), mode=0o600)
    except OSError as fault:
        reason = f"it cannot be written ({reason_of(fault)}); make room or choose another --folder"
        raise KeyFileError(path, reason) from fault


def private_folder(folder: Path) -> None:
    """Make a folder that no other user can read, or check it.

    Raises:
        KeyFileError: It cannot be made, is another user's, or is open to others.
    """
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        found = folder.stat()
    except (OSError, ValueError) as fault:
        reason = f"its folder cannot be made ({reason_of(fault)}); choose another --folder"
        raise KeyFileError(folder, reason) from fault
    _demand_private(folder, found, f"chmod 700 {folder}")


def _demand_private(path: Path, found: os.stat_result, remedy: str) -> None:
    if sys.platform == "win32":  # these bits do not name the users that may read it
        return
    if found.st_uid not in (os.geteuid(), 0):
        raise KeyFileError(path, "it belongs to another user; make a new one as yourself")
    if found.st_mode & (stat.S_IRWXG | stat.S_IRWXO):
        raise KeyFileError(path, f"others can read or change it; run: {remedy}")


def _damaged(name: str, problems: list[str], advice: str) -> KeyFileError:
    shown = "; ".join(problems[:_MOST_SHOWN])
    return KeyFileError(name, f"{shown}; {advice}")


def reason_of(fault: Exception) -> str:
    """The system's reason for a fault."""
    return getattr(fault, "strerror", None) or str(fault)
