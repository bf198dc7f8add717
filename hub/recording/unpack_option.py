"""The option of commands that read recordings: how much of them is unpacked."""

from __future__ import annotations

import argparse

from hub.recording.live import words
from hub.toml_reader import RefusedError


def add_unpack(command: argparse.ArgumentParser) -> None:
    """Add the option; 0: by the size of the recording."""
    command.add_argument(
        "--unpack", type=_bytes, default=0, metavar="SIZE",
        help="unpack up to this, such as 10GB (256 times the file, at least 1 GB; parts of 64 MB)",
    )  # fmt: skip


def _bytes(text: str) -> int:
    try:
        return words.file_bytes_of(text)
    except RefusedError as error:
        raise argparse.ArgumentTypeError(str(error)) from error
