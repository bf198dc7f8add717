"""Files of joysticks in the user's configuration directory: their paths, and bounded reads."""

from __future__ import annotations

import stat
from pathlib import Path

import platformdirs


def user_file(name: str) -> Path:
    """Where such a file is."""
    return platformdirs.user_config_path("rune", appauthor=False) / name


def read_user_file(path: Path, largest: int) -> bytes:
    """All of a file.

    Args:
        path: The file.
        largest: It may be so large [bytes].

    Raises:
        OSError: It is not there, or cannot be read.
        ValueError: It is no file that ends, or is too large.
    """
    if not stat.S_ISREG(path.stat().st_mode):  # to open a pipe would block
        text = "it is no regular file"
        raise ValueError(text)
    with path.open("rb") as file:
        data = file.read(largest + 1)
    if len(data) > largest:
        text = f"it is larger than {largest} bytes"
        raise ValueError(text)
    return data
