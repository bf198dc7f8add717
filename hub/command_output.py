"""How commands write lines to standard output and error, and see that standard input ended."""

from __future__ import annotations

import os
import select
import sys

from hub.plain_text import plain
from hub.table_text import json_text


def put(line: str) -> None:
    """Write a line at once, with control characters spelt out."""
    sys.stdout.write(plain(line, lines=True) + "\n")
    sys.stdout.flush()


def put_json(value: object) -> None:
    """Write a value as a line of JSON; see `json_text` for numbers that JSON has not."""
    put(json_text(value))


def print_error(text: str) -> None:
    """Write a sentence to standard error."""
    sys.stderr.write(f"rune-hub: {plain(text, lines=True)}\n")


def stdin_ended() -> bool:
    """Whether standard input has ended; its content does not count."""
    ready, _, _ = select.select([sys.stdin], [], [], 0.0)
    return bool(ready) and not os.read(sys.stdin.fileno(), 4096)
