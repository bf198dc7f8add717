"""Where `rune-hub adopt` writes a robot file and what it found: a file, or standard output."""

from __future__ import annotations

import sys
from pathlib import Path

from hub import files
from hub.command_output import print_error, put
from hub.plain_text import plain


class RobotFileOutput:
    """The output of one robot file."""

    def __init__(self, path: Path | None, *, replace: bool) -> None:
        """Choose the place.

        Args:
            path: Of the new file; None: standard output.
            replace: Whether a file that is there may be replaced.
        """
        self._path, self._replace = path, replace

    def is_free(self) -> bool:
        """Whether the file may be written; else an error is printed."""
        if self._path is not None and self._path.exists() and not self._replace:
            print_error(f"{self._path} is there; give another name, or --force to replace it")
            return False
        return True

    def write(self, text: str) -> bool:
        """Write the file, if there is one; returns whether that is done, else prints an error."""
        if self._path is not None:
            try:
                files.write_output(self._path, text.encode())
            except OSError as fault:
                print_error(f"{self._path} cannot be written: {fault.strerror}")
                return False
        return True

    def report(self, text: str, *lines: str) -> None:
        """Print what was found, and the robot file where it was not written to a file.

        Args:
            text: The robot file.
            lines: What was found. They go to standard error where the robot file goes to standard
                output, so that a shell can redirect that to a file.
        """
        if self._path is None:
            put(text.rstrip())
            for line in lines:
                sys.stderr.write(plain(line) + "\n")
            return
        for line in lines:
            put(line)
        put(f"written: {self._path}; `rune-hub run {self._path}` starts its hub")
