"""The file of a signing key: 64 hexadecimal digits, for its owner only."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path
from typing import Final

from hub import files
from hub.errors import KeyFileError

_MOST_BYTES: Final = 256
_LENGTH: Final = 32
_OTHERS: Final = 0o077


def read_signing_key(path: Path) -> bytes:
    """The 32 bytes of a key.

    Raises:
        KeyFileError: It cannot be read, others can read it, or it is no key.
    """
    try:
        mode = path.stat().st_mode
        text = files.read_regular(path, _MOST_BYTES)
    except (OSError, ValueError) as fault:
        raise KeyFileError(path, f"{getattr(fault, 'strerror', None) or fault}") from fault
    if mode & _OTHERS:
        raise KeyFileError(path, f"others can read or change it; run: chmod 600 {path}")
    try:
        key = bytes.fromhex(text.decode("ascii").strip())
    except ValueError as fault:
        reason = "it has to be 64 hexadecimal digits"
        raise KeyFileError(path, reason) from fault
    if len(key) != _LENGTH:
        raise KeyFileError(path, f"it has {len(key)} bytes in place of {_LENGTH}")
    return key


def key_of_phrase(phrase: str) -> bytes:
    """The key of a phrase, as ground stations make it: its SHA-256."""
    return hashlib.sha256(phrase.encode()).digest()


def write_signing_key(path: Path, key: bytes) -> None:
    """Write a key to a new file for its owner only.

    Raises:
        KeyFileError: It is there, or cannot be written.
    """
    try:
        handle = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
        with os.fdopen(handle, "w", encoding="ascii") as file:
            file.write(f"{key.hex()}\n")
    except OSError as fault:
        raise KeyFileError(path, fault.strerror or str(fault)) from fault
