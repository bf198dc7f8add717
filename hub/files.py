"""Files that are replaced as a whole, and read no further than they may be long."""

from __future__ import annotations

import contextlib
import os
import tempfile
from pathlib import Path

from hub.errors import MapFileError


def replace(path: Path, content: bytes, *, sync: bool = True, mode: int = 0o644) -> None:
    """Put a file in place in one step.

    After a crash at any moment the file has the old content or the new one, never a mixture.

    Args:
        path: The file.
        content: Its new content.
        sync: Whether to wait until it is on the disk; else a stop of the machine may lose it.
        mode: Its permissions; until it is in place, only its owner has access.

    Raises:
        OSError: It cannot be written; the old file is as it was.
    """
    handle, name = tempfile.mkstemp(prefix=".", suffix=path.suffix, dir=path.parent)
    unfinished = Path(name)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
            file.flush()
            if sync:
                os.fsync(file.fileno())
        unfinished.chmod(mode)
        unfinished.replace(path)
    except BaseException:
        with contextlib.suppress(OSError):
            unfinished.unlink()
        raise
    if sync:
        sync_folder(path.parent)


def write_output(path: Path, content: bytes, *, sync: bool = True) -> None:
    """Write a file that a user names: a regular file in one step, else into the device or pipe.

    A link stays: what it leads to is written.

    Args:
        path: The file.
        content: Its new content.
        sync: As in `replace`.

    Raises:
        OSError: It cannot be written; a regular file is as it was.
    """
    if path.exists() and not path.is_file():
        path.write_bytes(content)
    else:
        replace(path.resolve(), content, sync=sync)


def sync_folder(folder: Path) -> None:
    """Write to the disk which files a folder has; some file systems cannot, and need not."""
    with contextlib.suppress(OSError):
        handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def read(path: Path, most: int) -> bytes:
    """The content of a file.

    Raises:
        MapFileError: It cannot be read, is no regular file, or is larger than `most` bytes.
    """
    try:
        return read_regular(path, most)
    except OSError as fault:
        text = f"{path} cannot be read: {fault.strerror or fault}"
        raise MapFileError(text) from fault
    except ValueError as fault:
        text = f"{path} is no regular file of at most {most} bytes"
        raise MapFileError(text) from fault


def read_regular(path: Path, most: int) -> bytes:
    """The content of a file.

    Raises:
        OSError: It is not there, or cannot be read.
        ValueError: It is no regular file, or is larger than `most` bytes.
    """
    if path.exists() and not path.is_file():  # to open a pipe would wait for a writer
        text = "it is no regular file"
        raise ValueError(text)
    with path.open("rb") as file:
        raw = file.read(most + 1)
    if len(raw) > most:
        text = f"it is larger than {most} bytes"
        raise ValueError(text)
    return raw


def read_own(path: Path, most: int) -> bytes:
    """The first bytes of a file in a folder where others may write too.

    Raises:
        OSError: It is not there, cannot be read, is a link, or belongs to another user.
    """
    file = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
    try:
        if os.fstat(file).st_uid != os.getuid():
            text = f"{path} belongs to another user"
            raise PermissionError(text)
        return os.read(file, most)
    finally:
        os.close(file)
