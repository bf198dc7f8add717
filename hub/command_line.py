"""What both commands share: reading arguments, exit codes, the version, completion in shells."""

from __future__ import annotations

import argparse
import difflib
import enum
import re
import sys
from collections.abc import Callable, Sequence
from typing import NoReturn, TypeAlias

DISTRIBUTION = "robot-user-nexus"
_UNKNOWN = re.compile(r"invalid choice: '(?P<word>[^']{1,64})' \(choose from (?P<known>.*)\)")


class ExitCode(enum.IntEnum):
    """How a command ends.

    Attributes:
        OK: It did what was asked.
        FAULT: It failed, or the hub refused what was asked.
        USAGE: The arguments, a layout or a robot file are wrong.
        NO_HUB: No hub answers.
    """

    OK = 0
    FAULT = 1
    USAGE = 2
    NO_HUB = 3


class CommandParser(argparse.ArgumentParser):
    """Names the nearest known word, and shows its help where a command is missing."""

    def error(self, message: str) -> NoReturn:
        """Say what is wrong with the arguments in one sentence, and end with code 2."""
        if message.startswith("the following arguments are required: COMMAND"):
            self.print_help(sys.stderr)
            self.exit(ExitCode.USAGE)
        if wrong := _UNKNOWN.search(message):
            known = re.findall(r"'([^']+)'", wrong["known"]) or wrong["known"].split(", ")
            message = message[: wrong.start()] + _unknown(wrong["word"], known)
        more = "" if message.endswith("?") else f"; {self.prog} --help says more"
        self.exit(ExitCode.USAGE, f"{self.prog}: {message}{more}\n")


Commands: TypeAlias = "argparse._SubParsersAction[CommandParser]"  # noqa: SLF001 - it has no public name
"""What takes further commands."""


class ShowVersion(argparse.Action):
    """Looks the version up when it is asked for: to import what finds it costs 30 ms."""

    def __init__(self, option_strings: Sequence[str], dest: str) -> None:
        text = "show the version and exit"
        super().__init__(option_strings, dest, nargs=0, default=argparse.SUPPRESS, help=text)

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> NoReturn:
        """Print the version and end."""
        from importlib.metadata import version

        sys.stdout.write(f"{parser.prog} {version(DISTRIBUTION)}\n")
        parser.exit()


def nearest_word(word: str, known: Sequence[str]) -> str:
    """The part of a message that names the nearest known word; empty where none is near."""
    near = difflib.get_close_matches(word[:64], known, n=1, cutoff=0.5)
    return f"; did you mean {near[0]!r}?" if near else ""


def add_completion(commands: Commands) -> None:
    """Add the command that prints what completes this command's words in a shell."""
    completion = commands.add_parser(
        "completion",
        help="print what completes this command's words in your shell",
        description="Print a script that completes this command's words. For bash, write it to "
        "~/.local/share/bash-completion/completions/ under the command's name; for zsh, to a "
        "folder of $fpath under its name with _ before it.",
    )
    completion.add_argument("shell", choices=("bash", "zsh", "tcsh"))


def write_completion(parser: Callable[[], CommandParser], shell: str) -> int:
    """Write the script that completes a command's words to standard output."""
    import shtab

    sys.stdout.write(shtab.complete(parser(), shell=shell) + "\n")
    return ExitCode.OK


def _unknown(word: str, known: Sequence[str]) -> str:
    hint = nearest_word(word, known)
    return f"{word!r} is unknown" + (hint or f"; it has to be one of {', '.join(known)}")
